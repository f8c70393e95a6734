// The culler that is never slower than frustum culling: it measures what drawing and testing cost
// on the running device, and tests only what pays.
//
// Implements  the cost-benefit rules of M. Guthe, A. Balazs, R. Klein, "Near Optimal Hierarchical
//             Culling: Performance Driven Use of Hardware Occlusion Queries", EGSR 2006, over the
//             two-phase order of U. Haar, S. Aaltonen, SIGGRAPH 2015 courses (two_phase.h) and the
//             multiqueries of O. Mattausch, J. Bittner, M. Wimmer, EG 2008 (chc_plus_plus.h).
// Map         one frame, in order (Adaptive::cull_frame):
//               per view: cull, or draw all?    -> judge (at the end of the frame before)
//               sort the cut by what was seen   -> sort_out (cut_culler.h)
//               draw what was visible           -> draw_expected
//               test the rest, draw what shows  -> by_pyramid or by_device
//               test what was drawn, for later  -> retest, retest_by_device
//               keep the cut short              -> finish_cut
//             c_bb, c_scr, p_cov, p_occ         -> coverage.h
//             t_render, t_query                 -> cost_model.h
//             QueryReasonable                   -> worth_testing, retest_reasonable
// Deviations  Costs are measured in running frames (cost_model.h). What is hidden shares queries
//             later, so what it may save is counted less its share of one, and over as many frames
//             as it probably stays hidden; the gain of testing what is visible is not divided by a
//             depth complexity. A failed multiquery is halved where that is cheaper. Besides
//             queries there are cheaper tests, and the method is chosen by its cost. A whole view
//             is not tested at all where that would cost more than it hides: then frames are those
//             of frustum culling, and a probe now and then (a test of the finished frame, at most
//             `probe_share` of the time) finds out whether that has changed. The traversal starts
//             from the cut of the last frame, not from the root (hierarchy_cut.h).
// Guarantees  exact: every item in the frustum is drawn, or lies in a node that a test in this very
//             frame found hidden. Measured times change what is tested and how, never the image.
//             Without a clock, or on a device without exact timing, decisions follow the hints of
//             DeviceCaps.
// Cost        O(entries of the cut) a frame, which follows the visible boundary; one depth
// read-back
//             or a few rounds of tests. When it draws all: that of `frustum`, and the probes.
#pragma once

#include <occlude/core/clock.h>
#include <occlude/cull/cut_culler.h>
#include <occlude/cull/parts/chc_plus_plus_math.h>
#include <occlude/cull/parts/cost_model.h>
#include <occlude/cull/parts/coverage.h>
#include <occlude/cull/parts/frustum_walk.h>

#include <array>
#include <cstdint>
#include <string_view>
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
    /// Test the shapes of items (item_shapes.h) where their boxes are not hidden and that may pay.
    bool shapes = true;
};

constexpr auto option_names(AdaptiveOptions::Method)
{
    return std::array<std::string_view, 5>{"automatic", "draw_all", "queries", "raster", "pyramid"};
}

class Adaptive final : public CutCuller {
public:
    /// Without a clock costs are what the device's hints say.
    explicit Adaptive(const Hierarchy& hierarchy, AdaptiveOptions options = {},
                      SecondsClock clock = {});

    const CostModel& costs() const { return costs_; }

private:
    /// A test under way over candidates [first, first + count) of `round_`.
    struct Group {
        uint32_t first = 0;
        uint32_t count = 0;
    };
    /// A test of what is drawn, whose answer is for a frame to come.
    struct LateTest {
        Ticket ticket;
        uint64_t entry = 0; ///< name_of() it
    };

    void cull_frame(CullFrame& frame) override;
    void reset_state() override;

    // --- the plan ---
    void start_frame(CullFrame& frame);
    bool unknown(TestMethod method) const;
    TestMethod choose_method() const;
    double expected_us(TestMethod method) const;
    void judge(CullFrame& frame);
    void stop_culling();
    void draw_all(CullFrame& frame);
    bool probe_due(double drawn_units) const;
    void probe(CullFrame& frame);
    void probe_by_pyramid(CullFrame& frame);

    // --- the rules of the traversal (cut_culler.h) ---
    bool opens(NodeId node) const override;
    using CutCuller::opens;
    uint32_t most_texels(const Entry& entry) const override;
    bool worth_testing(const Entry& entry) const override
    {
        return hoped_us(entry) > costs_.round(method_).us_per_test;
    }
    bool worth_shape(const Entry& entry) const override
    {
        return shape_share_ * draw_us(entry) > shape_us_;
    }
    void shape_answered(bool hidden, double us) override;
    double shape_clock() const override { return now(); }
    bool still_visible(const Entry& entry) const override;
    bool read_again(CullFrame& frame) override;
    void answered(bool hidden) override;
    void spared(const Entry& entry) override { hidden_units_ += units(entry); }
    void wasted(const Entry& entry) override { wasted_units_ += units(entry); }
    bool merges(CullFrame& frame, NodeId node) override;

    // --- against depth that was read back ---
    void by_pyramid(CullFrame& frame);
    bool read_depth(CullFrame& frame);
    bool reads_are_dear() const;
    bool guessing() const;
    bool measures_read(const CullFrame& frame) const;
    bool measure_read(CullFrame& frame);
    double come_to_rest(CullFrame& frame);

    // --- by tests on the device (adaptive_device_tests.cpp) ---
    void by_device(CullFrame& frame);
    void by_rounds(CullFrame& frame);
    void collect_round(CullFrame& frame, bool first_round);
    void group_round(CullFrame& frame);
    void note_answer(const Candidate& candidate, bool found_hidden);
    void note_sharing();
    size_t most_singly() const;
    void take_answers(CullFrame& frame);
    void draw_untested(CullFrame& frame, const Candidate& candidate);
    void open_for_next_round(CullFrame& frame, const Candidate& candidate);
    void retest_by_device(CullFrame& frame);
    void keep_parts_visible(const CullFrame& frame, const Candidate& candidate);
    void take_late_answers(CullFrame& frame);
    bool retest_reasonable(const CullFrame& frame, const Candidate& candidate);
    void note_drawing(CullFrame& frame);
    void measure_methods(CullFrame& frame, std::span<const Candidate> candidates);
    void measure_round(CullFrame& frame, TestMethod method, std::span<const Candidate> candidates,
                       size_t boxes_per_test);

    // --- shared ---
    double units(const Entry& entry) const
    {
        return costs_.units(triangles_of(entry), items_of(entry));
    }
    double draw_us(const Entry& entry) const { return costs_.us_per_unit() * units(entry); }
    /// What it costs to find hidden again, frame by frame, what was hidden: its share of a query.
    double kept_us() const
    {
        const RoundCost cost = costs_.round(method_);
        return method_ == TestMethod::queries
                   ? cost.us_per_box + tests_per_kept_ * (cost.us_per_test - cost.us_per_box)
                   : cost.us_per_test;
    }
    Aabb test_box(const CullFrame& frame, const Entry& entry) const
    {
        return frame.view().inflated_for_test(box_of(entry));
    }
    bool near(const CullFrame& frame, const Entry& entry) const
    {
        return frame.view().touches_near(test_box(frame, entry));
    }
    double hoped_us(const Entry& entry) const;
    static uint64_t name_of(const Entry& entry)
    {
        return uint64_t{entry.node.value} << 32 | entry.place;
    }
    /// Microseconds; 0 without a clock.
    double now() const { return clock_ ? 1e6 * clock_() : 0.0; }

    AdaptiveOptions options_;
    SecondsClock clock_;
    CostModel costs_;

    // Of the view, from frame to frame.
    TestMethod method_ = TestMethod::automatic;
    bool can_test_ = false;
    bool culling_ = true;
    bool first_look_ = true;
    uint32_t first_probes_ = 0;
    uint32_t frames_since_probe_ = 0xffff;
    double probe_patience_ = 1.0;  ///< grows while probes find nothing
    double units_at_look_ = 0.0;   ///< in the frustum, when tests were last made
    double saved_per_spent_ = 0.0; ///< smoothed
    double tests_last_frame_ = 0.0;
    double last_probe_us_ = 0.0;
    double hidden_share_ = 0.5;   ///< of the work in nodes that were tested for the first time
    double shape_share_ = 0.5;    ///< of the shapes that were tested: were hidden
    double shape_us_ = 2.0;       ///< what the test of one takes; smoothed
    double tests_per_kept_ = 0.2; ///< queries per node that was hidden: they share them

    // Of the frame.
    double started_us_ = 0.0;
    double spent_us_ = 0.0;  ///< on tests
    double shapes_us_ = 0.0; ///< ... of shapes, of these
    double hidden_units_ = 0.0;
    double wasted_units_ = 0.0;
    bool measured_ = false; ///< what a method costs, beside the frame's own work

    // Against depth.
    double read_after_us_ = 0.0; ///< of drawing, before depth is read again
    double units_at_read_ = 0.0;
    double hidden_at_read_ = 0.0; ///< units

    // By tests on the device.
    std::vector<Candidate> round_;
    std::vector<Candidate> next_round_;
    std::vector<Group> groups_;
    uint32_t together_ = 0;   ///< the last number of a part of a failed group, of this frame
    double kept_tests_ = 0.0; ///< queries of what was hidden, of this frame
    double kept_ = 0.0;       ///< what was hidden and asked again, of this frame
    std::vector<double> keep_;
    std::vector<LateTest> late_;
    std::vector<uint64_t> found_hidden_; ///< names of entries, ascending
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
    visit("shapes", o.shapes,
          "test the boxes of which an item consists where its own is not hidden");
}

} // namespace occlude
