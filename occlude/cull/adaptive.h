// The culler that is never slower than frustum culling: it measures what drawing and testing cost
// on the running device, and tests only what pays.
//
// Implements  the cost-benefit rules of M. Guthe, A. Balazs, R. Klein, "Near Optimal Hierarchical
//             Culling: Performance Driven Use of Hardware Occlusion Queries", EGSR 2006, over the
//             two-phase order of U. Haar, S. Aaltonen, SIGGRAPH 2015 courses (two_phase.h) and the
//             multiqueries of O. Mattausch, J. Bittner, M. Wimmer, EG 2008 (chc_plus_plus.h).
// Map         one frame, in order (Adaptive::cull_frame):
//               per view: cull, or draw all?    -> judge (at the end of the frame before)
//               sort the cut by what was seen   -> sort_out
//               draw what was visible           -> draw_expected
//               test the rest, draw what shows  -> by_pyramid or by_device
//               test what was drawn, for later  -> retest_by_pyramid, retest_by_device
//               keep the cut short              -> finish_cut
//             c_bb, c_scr, p_cov, p_occ         -> coverage.h
//             t_render, t_query                 -> cost_model.h
//             QueryReasonable                   -> worth_testing, retest_reasonable
// Deviations  Costs are measured in running frames (cost_model.h). Besides queries there are cheaper
//             tests, and the method is chosen by its cost. A whole view is not tested at all where
//             that would cost more than it hides: then frames are those of frustum culling, and a
//             probe now and then (a test of the finished frame, at most `probe_share` of the time)
//             finds out whether that has changed. The traversal starts from the cut of the last
//             frame, not from the root (hierarchy_cut.h).
// Guarantees  exact: every item in the frustum is drawn, or lies in a node that a test in this very
//             frame found hidden. Measured times change what is tested and how, never the image.
//             Without a clock, or on a device without exact timing, decisions follow the hints of
//             DeviceCaps.
// Cost        O(entries of the cut) a frame, which follows the visible boundary; one depth read-back
//             or a few rounds of tests. When it draws all: that of `frustum`, and the probes.
#pragma once

#include <occlude/core/depth_pyramid.h>
#include <occlude/core/projection.h>
#include <occlude/cull/chc_plus_plus_math.h>
#include <occlude/cull/clock.h>
#include <occlude/cull/cost_model.h>
#include <occlude/cull/coverage.h>
#include <occlude/cull/cull_frame.h>
#include <occlude/cull/culler.h>
#include <occlude/cull/frustum_walk.h>
#include <occlude/cull/hierarchy_cut.h>

#include <array>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

namespace occlude {

struct AdaptiveOptions {
    /// How tests are made. `automatic` chooses what costs least; the others are for comparisons.
    enum class Method : uint8_t { automatic, draw_all, queries, raster, pyramid };
    Method method = Method::automatic;
    /// The part of the time that probes may take while nothing is tested.
    float probe_share = 0.005f;
    /// Tests must hide so many times what they cost, or the view is not tested any more.
    float keep_margin = 1.2f;
    /// ... and a probe must promise so much before it is tested again.
    float start_margin = 1.5f;
    /// Measure by the clock. Otherwise costs stay what the device's hints say, and runs repeat.
    bool measure = true;
    uint64_t seed = 1; ///< of the choice of entries that are merged
};

constexpr auto option_names(AdaptiveOptions::Method)
{
    return std::array<std::string_view, 5>{"automatic", "draw_all", "queries", "raster", "pyramid"};
}

class Adaptive final : public Culler {
public:
    /// Without a clock costs are what the device's hints say.
    explicit Adaptive(const Hierarchy& hierarchy, AdaptiveOptions options = {},
                      SecondsClock clock = {});

    const CostModel& costs() const { return costs_; }
    const HierarchyCut& cut() const { return cut_; }

private:
    struct Candidate {
        HierarchyCut::Entry entry;
        PlaneMask mask = Frustum::kAllPlanes;
        float distance = 0.0f;
        bool alone = false; ///< a test together with others found samples
    };
    /// A test under way over candidates [first, first + count) of `round_`.
    struct Group {
        uint32_t first = 0;
        uint32_t count = 0;
    };
    struct LateTest {
        Ticket ticket;
        NodeId node;
    };

    void cull_frame(CullFrame& frame) override;
    void reset_state() override;

    // --- the plan ---
    void start_frame(CullFrame& frame);
    TestMethod choose_method() const;
    void judge(CullFrame& frame);
    void stop_culling();
    void draw_all(CullFrame& frame);
    bool probe_due(double frame_us) const;
    void probe(CullFrame& frame);
    void probe_by_pyramid(CullFrame& frame);

    // --- one frame of culling ---
    void sort_out(CullFrame& frame);
    void draw_expected(CullFrame& frame);
    void finish_cut(CullFrame& frame);

    // --- against depth that was read back ---
    void by_pyramid(CullFrame& frame);
    void project_all(CullFrame& frame);
    void test_candidates(CullFrame& frame);
    bool read_depth(CullFrame& frame);
    void measure_read(CullFrame& frame);
    void reveal(CullFrame& frame);
    void open(CullFrame& frame, const Candidate& candidate, bool tested);
    void retest_by_pyramid(CullFrame& frame);
    bool hidden(const CullFrame& frame, NodeId node);
    void compare_all(std::span<const ScreenBounds> bounds);
    bool hidden_by_faces(NodeId node, const ScreenBounds& bounds) const;

    // --- by tests on the device (adaptive_device_tests.cpp) ---
    void by_device(CullFrame& frame);
    void by_rounds(CullFrame& frame);
    void collect_round(CullFrame& frame, bool first_round);
    void group_round(CullFrame& frame);
    void note_answer(const Candidate& candidate, bool found_hidden);
    void take_answers(CullFrame& frame);
    void draw_untested(CullFrame& frame, const Candidate& candidate);
    void open_for_next_round(CullFrame& frame, const Candidate& candidate);
    void retest_by_device(CullFrame& frame);
    void take_late_answers(CullFrame& frame);
    bool retest_reasonable(const CullFrame& frame, const Candidate& candidate);
    void note_drawing(CullFrame& frame);
    void measure_methods(CullFrame& frame, std::span<const Candidate> candidates);

    // --- shared ---
    bool is_terminal(NodeId node) const;
    void note_first_answer(bool found_hidden);
    bool worth_testing(NodeId node, double probability) const;
    void keep_hidden(CullFrame& frame, HierarchyCut::Entry entry, Decision decision);
    void keep_visible(HierarchyCut::Entry entry);
    void draw_entry(CullFrame& frame, const Candidate& candidate, Decision decision);
    void add_children(CullFrame& frame, const Candidate& candidate, std::vector<Candidate>& out);
    /// Microseconds; 0 without a clock.
    double now() const { return clock_ ? 1e6 * clock_() : 0.0; }

    AdaptiveOptions options_;
    SecondsClock clock_;
    CostModel costs_;
    HierarchyCut cut_;

    // Of the view, from frame to frame.
    TestMethod method_ = TestMethod::automatic;
    bool can_test_ = false;
    bool culling_ = true;
    bool first_look_ = true;
    uint32_t frames_since_probe_ = 0xffff;
    double saved_per_spent_ = 0.0; ///< smoothed
    double tests_last_frame_ = 0.0;
    double last_probe_us_ = 0.0;
    double hidden_share_ = 0.5; ///< of the work in nodes that were tested for the first time

    // Of the frame.
    bool probing_ = false; ///< asking of a frame that is drawn already
    double started_us_ = 0.0;
    double tests_ = 0.0;      ///< made so far
    double spent_us_ = 0.0;   ///< on them
    double testing_us_ = 0.0; ///< by the clock, in comparisons with depth
    double hidden_units_ = 0.0;
    std::vector<Candidate> expected_;   ///< visible in the last frame, in the frustum
    std::vector<Candidate> candidates_; ///< hidden or unknown, in the frustum
    std::vector<Aabb> boxes_;
    std::vector<uint8_t> hidden_by_rectangle_;
    std::vector<ScreenBounds> expected_bounds_;
    std::vector<ScreenBounds> candidate_bounds_;

    // Against depth.
    DepthPyramid pyramid_;
    ScreenSpace screen_;
    bool depth_known_ = false;
    double read_after_us_ = 0.0; ///< of drawing, before depth is read again
    double units_at_read_ = 0.0;
    std::vector<Candidate> stack_;
    std::vector<std::pair<float, NodeId>> children_;

    // By tests on the device.
    std::vector<Candidate> round_;
    std::vector<Candidate> next_round_;
    std::vector<Group> groups_;
    std::vector<std::pair<double, uint32_t>> by_keep_;
    std::vector<double> keep_;
    std::vector<LateTest> late_;
    std::vector<NodeId> found_hidden_;
    TestBatch batch_;
    std::vector<Ticket> tickets_;
    KeepTable keep_table_;
    ScreenCoverage coverage_;

    FrustumWalk walk_;
};

template <class Visit>
void visit_options(AdaptiveOptions& o, Visit&& visit)
{
    visit("method", o.method, "how tests are made; automatic: as costs least");
    visit("probe_share", o.probe_share,
          "part of the time that probes may take while nothing is tested");
    visit("keep_margin", o.keep_margin,
          "tests must hide so many times what they cost, or all is drawn");
    visit("start_margin", o.start_margin,
          "a probe must promise so much before anything is tested again");
    visit("measure", o.measure,
          "measure costs by the clock; false: the device's hints, repeatable");
    visit("seed", o.seed, "of the choice of entries of the cut that are merged");
}

} // namespace occlude
