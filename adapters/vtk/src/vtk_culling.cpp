#include <occlude/vtk/vtk_culling.h>

#include "actor_blocks.h"
#include "culled_props.h"
#include "prop_states.h"

#include <vtkActor.h>
#include <vtkCullerCollection.h>
#include <vtkFrustumCoverageCuller.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPropCollection.h>
#include <vtkRenderer.h>

#include <span>
#include <typeinfo>
#include <vector>

namespace occlude {

namespace {

// True if a culler before `self` has asked each prop in the list for its bounds.
bool bounds_are_up_to_date(vtkRenderer& renderer, const vtkCuller& self)
{
    vtkCullerCollection& cullers = *renderer.GetCullers();
    cullers.InitTraversal();
    for (vtkCuller* culler = cullers.GetNextItem(); culler != nullptr && culler != &self;
         culler = cullers.GetNextItem()) {
        if (typeid(*culler) == typeid(vtkFrustumCoverageCuller)) {
            return true;
        }
    }
    return false;
}

} // namespace

struct VtkCulling::Parts {
    vtkNew<CulledProps> culled;
    ActorBlocks blocks;
    VtkCullingOptions options;
    PropStates known;
    std::vector<const PropState*> states; ///< by place in the renderer's list

    void choose_run(size_t& begin, size_t& end) const;
    void expect_all(vtkRenderer& renderer);
    void take(vtkActor& actor, const PropState& state);
};

vtkStandardNewMacro(VtkCulling);

VtkCulling::VtkCulling()
    : parts_(std::make_unique<Parts>())
{
}

VtkCulling::~VtkCulling() = default;

vtkSmartPointer<VtkCulling> VtkCulling::attach(vtkRenderer& renderer,
                                               const VtkCullingOptions& options)
{
    auto culling = vtkSmartPointer<VtkCulling>::New();
    culling->set_options(options);
    renderer.AddCuller(culling);
    return culling;
}

void VtkCulling::detach(vtkRenderer& renderer)
{
    renderer.RemoveCuller(this);
}

void VtkCulling::set_options(const VtkCullingOptions& options)
{
    parts_->options = options;
    parts_->culled->set_options(options);
    parts_->blocks.set_block_triangles(options.block_triangles);
}

const VtkCullingStats& VtkCulling::stats() const
{
    return parts_->culled->stats();
}

// Props that depend on the order part the list into runs; the one with the most testable props.
void VtkCulling::Parts::choose_run(size_t& begin, size_t& end) const
{
    size_t most = 0;
    size_t start = 0;
    size_t testable = 0;
    begin = end = 0;
    for (size_t place = 0; place <= states.size(); ++place) {
        if (place < states.size() && states[place]->kind != PropKind::ordered) {
            testable += states[place]->kind == PropKind::testable ? 1 : 0;
            continue;
        }
        if (testable > most) {
            most = testable;
            begin = start;
            end = place;
        }
        start = place + 1;
        testable = 0;
    }
}

// The first hierarchy has the actors outside of the frustum, too.
void VtkCulling::Parts::expect_all(vtkRenderer& renderer)
{
    vtkPropCollection& props = *renderer.GetViewProps();
    vtkCollectionSimpleIterator at{};
    props.InitTraversal(at);
    while (vtkProp* prop = props.GetNextProp(at)) {
        if (prop->GetVisibility() == 0) {
            continue;
        }
        const PropState& state = known.of(*prop, false);
        if (state.kind == PropKind::testable) {
            culled->expect(prop, state.bounds, state.slack, state.triangles);
        }
    }
}

void VtkCulling::Parts::take(vtkActor& actor, const PropState& state)
{
    const std::span<const ActorBlock> cut = blocks.blocks_of(actor, state.triangles);
    if (cut.empty()) {
        culled->add({&actor, nullptr, 0}, state.bounds, state.slack, state.triangles);
    }
    for (uint32_t i = 0; i < cut.size(); ++i) { // number 0 is the actor as a whole
        culled->add({&actor, cut[i].mapper, i + 1}, placed_by(actor, cut[i].bounds), state.slack,
                    cut[i].triangles);
    }
}

double VtkCulling::Cull(vtkRenderer* renderer, vtkProp** props, int& count, int& initialized)
{
    const std::span<vtkProp*> list(props, static_cast<size_t>(count));
    double total = 0.0;
    for (const vtkProp* prop : list) {
        total += initialized != 0 ? const_cast<vtkProp*>(prop)->GetRenderTimeMultiplier() : 1.0;
    }
    CulledProps& culled = *parts_->culled;
    culled.stats() = {};
    culled.stats().props = list.size();
    if (!enabled_ || renderer->GetSelector() != nullptr || renderer->GetUseShadows() != 0) {
        return total;
    }
    const bool up_to_date = bounds_are_up_to_date(*renderer, *this);
    parts_->known.begin_frame();
    parts_->states.clear();
    for (vtkProp* prop : list) {
        parts_->states.push_back(&parts_->known.of(*prop, up_to_date));
    }
    size_t begin = 0;
    size_t end = 0;
    parts_->choose_run(begin, end);

    const bool first_frame = culled.is_new();
    culled.begin_frame();
    parts_->blocks.begin_frame();
    size_t kept = begin;
    for (size_t place = begin; place < list.size(); ++place) {
        vtkProp* prop = list[place];
        if (place >= end || parts_->states[place]->kind != PropKind::testable) {
            list[kept++] = prop;
            continue;
        }
        const double time = initialized != 0 ? prop->GetRenderTimeMultiplier() : 1.0;
        prop->SetAllocatedRenderTime(time / total * renderer->GetAllocatedRenderTime(), renderer);
        if (culled.stats().culled_props++ == 0) {
            list[kept++] = &culled; // in the place of the first one
        }
        parts_->take(static_cast<vtkActor&>(*prop), *parts_->states[place]);
    }
    if (first_frame) {
        parts_->expect_all(*renderer);
    }
    culled.end_frame();
    count = static_cast<int>(kept);
    return total;
}

void VtkCulling::PrintSelf(std::ostream& out, vtkIndent indent)
{
    vtkCuller::PrintSelf(out, indent);
    out << indent << "Enabled: " << enabled_ << "\n";
    out << indent << "Algorithm: " << parts_->options.algorithm << "\n";
}

} // namespace occlude
