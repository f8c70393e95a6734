// The culler that is never slower than frustum culling: it measures what drawing and testing cost
// on the running device, and tests only what pays.
//
// Implements  the cost-benefit rules of M. Guthe, A. Balazs, R. Klein, "Near Optimal Hierarchical
//             Culling: Performance Driven Use of Hardware Occlusion Queries", EGSR 2006, over the
//             two-phase order of U. Haar, S. Aaltonen, SIGGRAPH 2015 courses (two_phase.h) and the
//             multiqueries of O. Mattausch, J. Bittner, M. Wimmer, EG 2008 (chc_plus_plus.h).
// Map         one frame, in order (Adaptive::cull_frame):
//               cull this view, or draw it all?  -> AdaptivePlanner (adaptive/planner.h)
//               sort the cut by what was seen    -> CutTraversal::sort_out
//               draw what was visible            -> CutTraversal::draw_visible
//               test the rest, draw what shows   -> TestingByDepth or TestingByDevice
//               test what was drawn, for later   -> ... and their retest
//               keep the cut short               -> CutTraversal::finish
//             c_bb, c_scr, p_cov, p_occ          -> parts/coverage.h
//             t_render, t_query                  -> parts/cost_model.h, adaptive/cost_meter.h
//             QueryReasonable                    -> AdaptivePlanner::hoped_us, retest_pays
// Deviations  Costs are measured in running frames (cost_model.h). Nodes that stay hidden share
//             queries later. So the benefit of finding a node hidden is reduced by its share of a
//             query, and counted for as many frames as the node probably stays hidden. The benefit
//             of testing a visible node is not divided by a depth complexity. A failed multiquery
//             is halved where that is cheaper. Queries are one of several test methods, and the
//             cheapest is chosen. If testing costs more than it hides, the whole view is drawn as
//             by frustum culling. Then an occasional probe (a test of the finished frame, for at
//             most `probe_share` of the time) finds out whether that has changed. The traversal
//             starts from the cut of the last frame, not from the root (hierarchy_cut.h).
// Guarantees  exact: every item in the frustum is drawn, or lies in a node that a test of this
//             frame found hidden. Measured times change what is tested and how, never the image.
//             Decisions follow the hints of DeviceCaps if there is no clock, if the clock stands
//             still or is coarse, and on a device without exact timing.
// Cost        O(entries of the cut) per frame, which follows the visible boundary; plus one
//             read-back of depth (in tiles, if that costs less) or a few rounds of tests. A frame
//             that draws everything costs as much as one of `frustum`, plus the probes.
#pragma once

#include <occlude/core/clock.h>
#include <occlude/cull/adaptive/adaptive_options.h>
#include <occlude/cull/adaptive/by_depth.h>
#include <occlude/cull/adaptive/by_device.h>
#include <occlude/cull/adaptive/method_trials.h>
#include <occlude/cull/adaptive/shared.h>
#include <occlude/cull/culler.h>
#include <occlude/cull/parts/frustum_walk.h>

#include <array>
#include <string_view>

namespace occlude {

constexpr auto option_names(AdaptiveOptions::Method)
{
    return std::array<std::string_view, 5>{"automatic", "draw_all", "queries", "raster", "pyramid"};
}

class Adaptive final : public Culler {
public:
    using Options = AdaptiveOptions;
    static constexpr AlgorithmTraits kTraits{
        .name = "adaptive",
        .paper = "Guthe, Balazs, Klein 2006, with measured costs",
        .summary = "measures the costs of drawing and testing, and tests only if that saves time",
    };

    /// Without a clock, costs stay at the device's hints.
    explicit Adaptive(HierarchyRef hierarchy, AdaptiveOptions options = {},
                      SecondsClock clock = {});

private:
    friend class CullerProbe; // of the tests
    void cull_frame(CullFrame& frame) override;
    void reset_state() override;

    void start_frame(CullFrame& frame);
    void draw_all(CullFrame& frame);
    void cull_view(CullFrame& frame);
    void finish_cut(CullFrame& frame);
    void probe(CullFrame& frame);
    void drop_late_tests();
    AdaptivePlanner::Outcome outcome(const CullFrame& frame) const;

    AdaptiveOptions options_;
    AdaptiveShared shared_;
    MethodTrials trials_;
    TestingByDepth by_depth_;
    TestingByDevice by_device_;
    FrustumWalk walk_;
    double frame_since_us_ = 0.0; ///< when the frame began
    double drawn_units_ = 0.0;    ///< work that the last frame drew
    std::vector<Ticket> dropped_; ///< scratch
};

template <class Visit>
void visit_options(AdaptiveOptions& o, Visit&& visit)
{
    visit("method", o.method, "how tests are made; automatic: by the cheapest method");
    visit("probe_share", o.probe_share, {0.0f, 1.0f},
          "share of the time that probes may take while everything is drawn");
    visit("keep_margin", o.keep_margin, {},
          "draw everything if tests hide less than this many times their cost");
    visit("start_margin", o.start_margin, {},
          "test again when a probe promises this many times its cost");
    visit("measure", o.measure,
          "measure costs by the clock; false: take the device's hints, so that runs repeat");
    visit("seed", o.seed, {}, "seed of the random choice of nodes that the cut merges");
    visit("shapes", o.shapes,
          "test the boxes of an item's shape if the item's own box is not hidden");
}

} // namespace occlude
