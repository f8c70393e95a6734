#include <occlude/cull/two_phase.h>

#include <algorithm>

namespace occlude {

namespace {

// Drawing a triangle costs as much as looking at some texels: the faces of a box are tested with
// half a texel per triangle, in these bounds.
constexpr uint64_t kLeastTexels = 32;
constexpr uint64_t kMostTexels = 4096;

constexpr uint64_t kSeed = 1;

} // namespace

TwoPhase::TwoPhase(const Hierarchy& hierarchy, TwoPhaseOptions options)
    : CutCuller(hierarchy, DepthTests{options.refine}, options.shapes)
    , options_(options)
{
}

bool TwoPhase::opens(NodeId node) const
{
    return options_.virtual_leaves ? !hierarchy().is_leaf(node) : has_parts(node);
}

uint32_t TwoPhase::most_texels(const Entry& entry) const
{
    return static_cast<uint32_t>(std::clamp(triangles_of(entry) / 2, kLeastTexels, kMostTexels));
}

bool TwoPhase::read_again(CullFrame& frame)
{
    return options_.reread_triangles > 0 && frame.caps().read_depth &&
           frame.queued_triangles() >= options_.reread_triangles && read(frame);
}

void TwoPhase::cull_frame(CullFrame& frame)
{
    depth_.start_frame(frame.samples());
    sort_out(frame);
    draw_expected(frame);
    if (frame.caps().read_depth) {
        frame.start_draws();
    }
    project_all(frame);
    read(frame);
    test_candidates(frame);
    reveal(frame);
    frame.flush_draws();
    if (options_.final_depth) {
        read(frame);
    }
    retest(frame);
    finish_cut(frame, kSeed);
}

} // namespace occlude
