#include "prop_view.h"

#include <occlude/core/view.h>

#include <vtkActor.h>
#include <vtkInformation.h>
#include <vtkInformationIterator.h>
#include <vtkInformationKey.h>
#include <vtkMapper.h>
#include <vtkMatrix3x3.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkOpenGLCamera.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkOpenGLRenderer.h>
#include <vtkOpenGLState.h>
#include <vtkProperty.h>
#include <vtkSmartPointer.h>
#include <vtkTexture.h>

#include <epoxy/gl.h>
#include <glm/gtc/type_ptr.hpp>

#include <algorithm>
#include <limits>

namespace occlude {

namespace {

// Gives the actor the keys of the prop that stands for it, as long as it is drawn. A pass has set
// them on that prop, and reads them from the actor while its mapper makes shaders.
class LentKeys {
public:
    LentKeys(vtkActor& actor, vtkInformation* keys)
        : actor_(actor)
        , keys_(keys != nullptr && keys->GetNumberOfKeys() > 0 ? keys : nullptr)
    {
        if (keys_ == nullptr) {
            return;
        }
        vtkInformation* own = actor.GetPropertyKeys();
        if (own == nullptr) {
            const vtkNew<vtkInformation> made;
            actor.SetPropertyKeys(made);
            own = made;
        }
        before_ = vtkSmartPointer<vtkInformation>::New();
        before_->Copy(own);
        own->Append(keys_);
    }
    ~LentKeys()
    {
        if (keys_ == nullptr) {
            return;
        }
        vtkInformation* own = actor_.GetPropertyKeys();
        const vtkNew<vtkInformationIterator> lent;
        lent->SetInformation(keys_);
        for (lent->InitTraversal(); lent->IsDoneWithTraversal() == 0; lent->GoToNextItem()) {
            own->CopyEntry(before_, lent->GetCurrentKey()); // removes what was not there
        }
    }
    LentKeys(const LentKeys&) = delete;
    LentKeys& operator=(const LentKeys&) = delete;

private:
    vtkActor& actor_;
    vtkInformation* keys_;
    vtkSmartPointer<vtkInformation> before_;
};

// More pairs of boxes than this are not compared: everything is drawn again.
constexpr size_t kMostPairs = 1u << 21;

bool touch(const Aabb& a, const Aabb& b)
{
    return a.min.x <= b.max.x && b.min.x <= a.max.x && a.min.y <= b.max.y && b.min.y <= a.max.y &&
           a.min.z <= b.max.z && b.min.z <= a.max.z;
}

// Blending that leaves an opaque colour as it is.
bool blends_opaque_as_itself(vtkOpenGLState& state)
{
    if (!state.GetEnumState(GL_BLEND)) {
        return true;
    }
    std::array<int, 4> factors{};
    state.GetBlendFuncState(factors.data());
    int equation = 0;
    glGetIntegerv(GL_BLEND_EQUATION_RGB, &equation);
    return (factors[0] == GL_SRC_ALPHA || factors[0] == GL_ONE) &&
           (factors[1] == GL_ONE_MINUS_SRC_ALPHA || factors[1] == GL_ZERO) &&
           (factors[2] == GL_SRC_ALPHA || factors[2] == GL_ONE) &&
           (factors[3] == GL_ONE_MINUS_SRC_ALPHA || factors[3] == GL_ZERO) &&
           equation == GL_FUNC_ADD;
}

} // namespace

void ItemPainter::start(vtkRenderer& renderer, vtkInformation* keys)
{
    renderer_ = &renderer;
    keys_ = keys;
    actor_ = nullptr;
}

void ItemPainter::draw(const DrawnItem& item)
{
    if (item.block == nullptr) {
        leave();
        const LentKeys lent(*item.actor, keys_);
        item.actor->RenderOpaqueGeometry(renderer_);
        return;
    }
    if (item.actor != actor_) {
        leave();
        enter(*item.actor);
    }
    const LentKeys lent(*item.actor, keys_);
    item.actor->Render(renderer_, item.block);
}

void ItemPainter::finish()
{
    leave();
}

// What vtkActor::RenderOpaqueGeometry does before it calls the mapper, and after.
void ItemPainter::enter(vtkActor& actor)
{
    actor_ = &actor;
    actor.GetProperty()->Render(&actor, renderer_);
    if (actor.GetBackfaceProperty() != nullptr) {
        actor.GetBackfaceProperty()->BackfaceRender(&actor, renderer_);
    }
    if (actor.GetTexture() != nullptr) {
        actor.GetTexture()->Render(renderer_);
    }
}

void ItemPainter::leave()
{
    if (actor_ == nullptr) {
        return;
    }
    actor_->GetProperty()->PostRender(actor_, renderer_);
    if (actor_->GetTexture() != nullptr) {
        actor_->GetTexture()->PostRender(renderer_);
    }
    actor_ = nullptr;
}

PropView::PropView(const VtkCullingOptions& options, const ItemTree& tree)
    : tree_(tree)
    , culler_(*this, tree.hierarchy(), options.algorithm, options.on_message, "vtk.no_culling")
{
}

bool PropView::draw(vtkRenderer& renderer, vtkInformation* keys, std::span<const DrawnItem> items,
                    std::span<const ItemId> ids, VtkCullingStats& stats)
{
    follow_context(renderer);
    if (!can_test(renderer) || !culler_.prepare()) {
        return false;
    }
    items_ = items;
    batch_.make_room(items.size());
    first_.clear();
    place_of_item_.assign(tree_.size(), kNotThere);
    for (uint32_t place = 0; place < ids.size(); ++place) {
        if (tree_.in_hierarchy(ids[place])) {
            place_of_item_[ids[place].value] = place;
        } else {
            first_.push_back(place);
        }
    }
    vtkMatrix4x4* unused = nullptr;
    vtkMatrix3x3* unused_too = nullptr;
    vtkMatrix4x4* clip_from_world = nullptr; // in the order of OpenGL
    static_cast<vtkOpenGLCamera*>(renderer.GetActiveCamera())
        ->GetKeyMatrices(&renderer, unused, unused_too, unused, clip_from_world);
    ViewOptions options;
    options.viewport_origin_px = {viewport_[0], viewport_[1]};
    const View view = View::from_clip(glm::mat4{glm::make_mat4(&clip_from_world->Element[0][0])},
                                      {viewport_[2], viewport_[3]}, {}, options);

    painter_.start(renderer, keys);
    sequence_.clear();
    stats.report = culler_.cull(view);
    stats.redrawn_items = settle_ties(ids);
    const auto here = std::ranges::count_if(culler_.drawn_items(), [&](ItemId item) {
        return place_of_item_[item.value] != kNotThere;
    });
    stats.unknown_items = first_.size();
    stats.hidden_items = items.size() - first_.size() - static_cast<size_t>(here);
    if (renderer.GetRenderWindow()->GetAbortRender() != 0) {
        culler_.forget();
    }
    return true;
}

void PropView::draw_place(uint32_t place)
{
    painter_.draw(items_[place]);
    sequence_.push_back(place);
}

// Where two surfaces have the same depth, the renderer shows the one that it draws last. An item
// that came after one of a later place may have taken such pixels from it: that one is drawn again,
// which changes nothing else.
size_t PropView::settle_ties(std::span<const ItemId> ids)
{
    late_.clear();
    uint32_t last_place = 0;
    uint32_t first_late = std::numeric_limits<uint32_t>::max();
    drawn_at_.assign(items_.size(), kNotThere);
    for (uint32_t time = 0; time < sequence_.size(); ++time) {
        const uint32_t place = sequence_[time];
        drawn_at_[place] = time;
        if (place < last_place) {
            late_.push_back(place);
            first_late = std::min(first_late, place);
        }
        last_place = std::max(last_place, place);
    }
    if (late_.empty() || !last_wins_) {
        return 0;
    }
    size_t redrawn = 0;
    const bool all = late_.size() * sequence_.size() > kMostPairs;
    auto time = static_cast<uint32_t>(sequence_.size());
    for (uint32_t place = first_late + 1; place < items_.size(); ++place) {
        if (drawn_at_[place] == kNotThere) {
            continue;
        }
        const Aabb& box = tree_.box(ids[place]);
        const bool overdrawn = all || std::ranges::any_of(late_, [&](uint32_t late) {
                                   return late < place && drawn_at_[late] > drawn_at_[place] &&
                                          touch(tree_.box(ids[late]), box);
                               });
        if (overdrawn) {
            painter_.draw(items_[place]);
            drawn_at_[place] = time++;
            late_.push_back(place);
            ++redrawn;
        }
    }
    painter_.finish();
    return redrawn;
}

// A window that is finalized and shown again has a new context, maybe at the old one's address.
void PropView::follow_context(vtkRenderer& renderer)
{
    auto* window = vtkOpenGLRenderWindow::SafeDownCast(renderer.GetRenderWindow());
    const uint64_t made = window != nullptr ? window->GetContextCreationTime() : 0;
    if (context_made_ != 0 && made != context_made_) {
        window->ReleaseCurrent(); // so that the device takes no other object for one of its own
        culler_.context_is_gone();
        window->MakeCurrent();
    }
    context_made_ = made;
}

// False where the state of the frame is not one that tests are right for.
bool PropView::can_test(vtkRenderer& renderer)
{
    auto* window = vtkOpenGLRenderWindow::SafeDownCast(renderer.GetRenderWindow());
    if (window == nullptr || vtkOpenGLCamera::SafeDownCast(renderer.GetActiveCamera()) == nullptr) {
        return false;
    }
    vtkOpenGLState& state = *window->GetState();
    std::array<float, 2> range{};
    int function = 0;
    glGetIntegerv(GL_VIEWPORT, viewport_.data());
    glGetFloatv(GL_DEPTH_RANGE, range.data());
    glGetIntegerv(GL_DEPTH_FUNC, &function);
    last_wins_ = function == GL_LEQUAL;
    return range[0] == 0.0f && range[1] == 1.0f && state.GetEnumState(GL_DEPTH_TEST) &&
           (function == GL_LEQUAL || function == GL_LESS) && !state.GetEnumState(GL_STENCIL_TEST) &&
           glIsEnabled(GL_COLOR_LOGIC_OP) == GL_FALSE && blends_opaque_as_itself(state);
}

void PropView::begin_frame(const View&)
{
    for (const uint32_t place : first_) {
        draw_place(place);
    }
    painter_.finish();
}

// Passes are alike here: the algorithms that draw depth first are not offered.
void PropView::draw(std::span<const ItemId> items, DrawPass)
{
    for (const ItemId item : items) {
        if (place_of_item_[item.value] != kNotThere) {
            batch_.insert(place_of_item_[item.value]);
        }
    }
    batch_.take_all([this](uint32_t place) { draw_place(place); });
    painter_.finish();
}

void PropView::prepare_tests()
{
    saved_.read();
    saved_.set_for_tests(viewport_);
}

void PropView::restore_state()
{
    saved_.put_back();
}

} // namespace occlude
