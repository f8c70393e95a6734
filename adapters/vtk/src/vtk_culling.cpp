#include <occlude/vtk/vtk_culling.h>

#include "actor_blocks.h"
#include "culled_props.h"
#include "prop_kind.h"

#include <vtkActor.h>
#include <vtkCullerCollection.h>
#include <vtkMapper.h>
#include <vtkMath.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLActor.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPropCollection.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <typeinfo>
#include <vector>

namespace occlude {

namespace {

// Positions are multiplied by a matrix in float: each coordinate of the mesh may be off by a few of
// these shares of the largest.
constexpr double kFloatShare = 0x1p-21;

double slack_of(vtkActor& actor)
{
    const double* bounds = actor.GetMapper()->GetBounds();
    double reach = 0.0;
    for (int i = 0; i < 6; ++i) {
        reach = std::max(reach, std::abs(bounds[i]));
    }
    double scale = 0.0;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) {
            scale = std::max(scale, std::abs(actor.GetMatrix()->GetElement(row, column)));
        }
    }
    return kFloatShare * reach * scale;
}

Bounds bounds_of(vtkProp& prop)
{
    Bounds bounds{};
    std::copy_n(prop.GetBounds(), bounds.size(), bounds.begin());
    return bounds;
}

bool has_bounds(vtkProp& prop)
{
    const double* bounds = prop.GetUseBounds() ? prop.GetBounds() : nullptr;
    return bounds != nullptr && vtkMath::AreBoundsInitialized(bounds) != 0;
}

PropKind kind_in_list(vtkProp& prop)
{
    const bool bounded = has_bounds(prop); // and the pipeline is up to date
    const PropKind kind = kind_of(prop);
    return kind == PropKind::testable && !bounded ? PropKind::kept : kind;
}

} // namespace

struct VtkCulling::Parts {
    vtkNew<CulledProps> culled;
    ActorBlocks blocks;
    VtkCullingOptions options;
    std::vector<PropKind> kinds; ///< by place in the renderer's list

    void choose_run(size_t& begin, size_t& end) const;
    void expect_all(vtkRenderer& renderer);
    void take(vtkActor& actor);
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
    for (size_t place = 0; place <= kinds.size(); ++place) {
        if (place < kinds.size() && kinds[place] != PropKind::ordered) {
            testable += kinds[place] == PropKind::testable ? 1 : 0;
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
        if (prop->GetVisibility() != 0 && kind_in_list(*prop) == PropKind::testable) {
            auto& actor = static_cast<vtkActor&>(*prop);
            culled->expect(prop, bounds_of(*prop), slack_of(actor), 1);
        }
    }
}

void VtkCulling::Parts::take(vtkActor& actor)
{
    uint32_t triangles = 0;
    vtkMapper& mapper = *actor.GetMapper();
    if (auto* plain = vtkPolyDataMapper::SafeDownCast(&mapper);
        plain != nullptr && plain->GetInput() != nullptr) {
        triangles = triangles_of(*plain->GetInput());
    } else {
        for (vtkPolyData* leaf : leaves_of(mapper)) {
            triangles += triangles_of(*leaf);
        }
    }
    const double slack = slack_of(actor);
    const std::span<const ActorBlock> cut = blocks.blocks_of(actor, triangles);
    if (cut.empty()) {
        culled->add({&actor, nullptr, 0}, bounds_of(actor), slack, triangles);
    }
    for (uint32_t i = 0; i < cut.size(); ++i) { // number 0 is the actor as a whole
        culled->add({&actor, cut[i].mapper, i + 1}, placed_by(actor, cut[i].bounds), slack,
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
    parts_->kinds.clear();
    for (vtkProp* prop : list) {
        parts_->kinds.push_back(kind_in_list(*prop));
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
        if (place >= end || parts_->kinds[place] != PropKind::testable) {
            list[kept++] = prop;
            continue;
        }
        const double time = initialized != 0 ? prop->GetRenderTimeMultiplier() : 1.0;
        prop->SetAllocatedRenderTime(time / total * renderer->GetAllocatedRenderTime(), renderer);
        if (culled.stats().culled_props++ == 0) {
            list[kept++] = &culled; // in the place of the first one
        }
        parts_->take(static_cast<vtkActor&>(*prop));
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
