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
#include <vtkTexture.h>

#include <epoxy/gl.h>
#include <glm/gtc/type_ptr.hpp>

#include <algorithm>

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
    vtkNew<vtkInformation> before_;
};

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
    stats.report = culler_.cull(view);
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
    return range[0] == 0.0f && range[1] == 1.0f && state.GetEnumState(GL_DEPTH_TEST) &&
           (function == GL_LEQUAL || function == GL_LESS) && !state.GetEnumState(GL_STENCIL_TEST) &&
           glIsEnabled(GL_COLOR_LOGIC_OP) == GL_FALSE && blends_opaque_as_itself(state);
}

void PropView::begin_frame(const View&)
{
    for (const uint32_t place : first_) {
        painter_.draw(items_[place]);
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
    batch_.take_all([this](uint32_t place) { painter_.draw(items_[place]); });
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
