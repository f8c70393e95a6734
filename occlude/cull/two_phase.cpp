#include <occlude/cull/two_phase.h>

namespace occlude {

namespace {

// Seed of the random choice of nodes that the cut merges.
constexpr uint64_t kSeed = 1;

} // namespace

// Work is counted in triangles here: a test may look at half a texel per triangle that it may save.
TwoPhase::TwoPhase(HierarchyRef hierarchy, TwoPhaseOptions options)
    : Culler(hierarchy)
    , options_(clamped(options))
    , cut_(hierarchy)
    , depth_(cut_, DepthTests{options.refine}, options.shapes)
{
    cut_.set_prices({.us_per_unit = 1.0, .stop_at_virtual_leaves = options.virtual_leaves});
    depth_.set_budget({.texels_per_us = 0.5,
                       .max_texels = 4096.0,
                       .min_texels = 32.0,
                       .texels_below_min = 32,
                       .test_us = DepthTestBudget::kAlways});
    depth_.set_tile_px(static_cast<int>(options_.tile));
}

void TwoPhase::reset_state()
{
    cut_.forget();
}

void TwoPhase::cull_frame(CullFrame& frame)
{
    cut_.start_frame();
    depth_.start_frame(frame);

    // Phase 1: draw what was visible in the last frame, and build the pyramid of its depth.
    cut_.sort_out(frame);
    cut_.draw_visible(frame);
    if (frame.caps().read_depth) {
        frame.start_draws();
    }
    depth_.project_all(frame); // while the device draws
    depth_.read(frame);

    // Phase 2: test the rest against it, and draw what is not hidden. With `reread_triangles` 0,
    // the difference wraps around to a number that no frame reaches, so that depth is read once.
    const uint64_t max_waiting_triangles = options_.reread_triangles - 1;
    depth_.test_candidates(frame);
    while (depth_.reveal(frame, static_cast<double>(max_waiting_triangles))) {
        depth_.read(frame);
    }
    frame.flush_draws();

    // The visible set of the next frame.
    if (options_.final_depth) {
        depth_.read(frame);
    }
    depth_.retest(frame);
    cut_.finish(frame, kSeed, [&](NodeId node) { return depth_.node_hidden(frame, node); });
}

} // namespace occlude
