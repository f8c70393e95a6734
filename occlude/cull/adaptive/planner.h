// The decisions of `adaptive`, from plain numbers: whether to test or to draw everything, by which
// method, how deep, and whether a probe is due. It knows no device, no clock and no tree.
//
// Implements  the cost-benefit rules of M. Guthe, A. Balazs, R. Klein, "Near Optimal Hierarchical
//             Culling: Performance Driven Use of Hardware Occlusion Queries", EGSR 2006:
//             QueryReasonable -> hoped_us(), retest_pays(). What drawing and testing cost comes
//             from CostModel.
//
//   state         a frame in it                   at its end                        next state
//   -----         -------------                   ----------                        ----------
//   first_look    tests; nothing is known yet     hides keep_margin x its cost      culling
//                                                 hides less                        drawing_all
//                 by tests on the device, which see nothing before something is
//                 drawn, it is at once ...                                          first_probes
//   first_probes  draws all, and probes           promises start_margin x cost      culling
//                                                 does not; costs not yet known     first_probes
//                                                 does not; costs are known, or
//                                                 max_first_probes were made        drawing_all
//   culling       tests                           keep_margin x cost, smoothed      culling
//                                                 less                              drawing_all
//   drawing_all   draws all; probes when due      promises start_margin x cost      culling
//                                                 does not                          drawing_all
//
// A method that an option prescribes is not given up once the state is `culling`. If the device
// cannot test at all, every frame draws all, whatever the state. The decision and its reason are a
// FramePlan (core/frame_report.h), which the report of every frame carries.
#pragma once

#include <occlude/core/frame_report.h>
#include <occlude/cull/adaptive/adaptive_options.h>
#include <occlude/cull/parts/cost_model.h>
#include <occlude/cull/parts/test_prices.h>

#include <cstddef>
#include <cstdint>

namespace occlude {

/// The planner's constants. Ratios have no unit; `us` means microseconds.
struct PlannerConstants {
    // --- which method ---

    /// The expected cost of a method assumes at least this many tests ...
    double min_expected_tests = 64.0;
    /// ... and, for tests on the device, this many rounds, because some tests reveal others.
    double expected_device_rounds = 1.5;
    /// The method changes if another costs less than this share of the one in use. With a ratio
    /// near 1, two methods of equal cost would alternate.
    double cost_ratio_to_switch = 0.7;
    /// Read-backs are called expensive before they are fully measured if at least
    /// `min_read_samples` of them took over `expensive_read_ratio` times the hint.
    double expensive_read_ratio = 4.0;
    size_t min_read_samples = 2;

    // --- does testing pay? ---

    /// The weight of one frame in the smoothed ratio of saved to spent time.
    double ratio_step = 0.25;
    /// A frame's ratio is clamped to this, so that one lucky frame is forgotten soon.
    double max_frame_ratio = 16.0;

    // --- when is a probe due? ---

    /// A probe that takes more than this share of a frame is made rarely, so that it does not show
    /// in the 99th percentile.
    double noticeable_share = 0.05;
    uint32_t rare_probe_frames = 128; ///< the least number of frames between two such probes
    /// ... unless the work in the frustum has changed by `changed_work_ratio` since the last probe
    uint32_t soon_probe_frames = 16;
    double changed_work_ratio = 1.25;
    /// The least number of frames between two probes on the device, which take many tests.
    uint32_t device_probe_frames = 16;
    /// Back-off: a probe that finds less than `vain_probe_ratio` of its cost multiplies the
    /// interval to the next by `probe_backoff`, up to `max_probe_backoff` times the base interval.
    double vain_probe_ratio = 0.5;
    double probe_backoff = 2.0;
    double max_probe_backoff = 4.0;
    /// At most this many of the first frames are probed. That is enough to measure each kind of
    /// round of each method three times.
    uint32_t max_first_probes = 12;

    // --- how deep? ---

    /// A node that costs less to draw than this many tests of hidden nodes is not opened.
    double kept_tests_to_open = 2.0;
    /// A probe opens no node with less than this share of the frame's work.
    double probe_grain = 1.0 / 512.0;
    /// The test of a new node is credited with the frames for which the node probably stays hidden,
    /// but with at most this many.
    double max_frames_ahead = 16.0;
    /// How many texels the test of a box by its faces may read per microsecond of drawing cost. At
    /// 10 ns a texel this is a quarter of the drawing. Fewer than `min_texels` cannot decide
    /// anything.
    double texels_per_us = 25.0;
    double max_texels = 16384.0;
    double min_texels = 16.0;
    /// The assumed cost of a test of a shape until a clock has timed some.
    double shape_test_us = 2.0;
    /// Queries per node that was hidden before, because such nodes share queries: the start value,
    /// and the weight of one frame in the running average.
    double first_tests_per_kept = 0.2;
    double tests_per_kept_step = 1.0 / 8.0;

    // --- when is depth read again? ---

    /// While a frame reveals nodes, depth is read again when the queued drawing costs this many
    /// read-backs. The number grows by `reread_growth` after each read-back that hid less than
    /// `worthwhile_read_ratio` times its cost, because the device stands still while it is read.
    double first_reread_cost = 4.0;
    double reread_growth = 2.0;
    double worthwhile_read_ratio = 4.0;
};

inline constexpr PlannerConstants kPlannerConstants{};

class AdaptivePlanner {
public:
    enum class State : uint8_t { first_look, first_probes, culling, drawing_all };

    explicit AdaptivePlanner(const AdaptiveOptions& options)
        : options_(options)
    {
    }

    /// Forgets the view. O(1).
    void reset();

    // --- before a frame ---

    struct Start {
        bool cut_is_empty = false; ///< no entry of the cut is known to be visible
        bool measures = false;     ///< there is a clock to measure methods with
        double tests_last_frame = 0.0;
    };
    /// Chooses the method. Returns true if it differs from the method of the last frame.
    bool start_frame(const CostModel& costs, const Start& start);

    State state() const { return state_; }
    TestMethod method() const { return method_; }
    bool can_test() const { return can_test_; }
    /// False: the frame draws everything in the frustum.
    bool culls() const
    {
        return can_test_ && (state_ == State::first_look || state_ == State::culling);
    }
    /// True while nothing is known of the view and no frame has been judged.
    bool is_first_look() const
    {
        return state_ == State::first_look || state_ == State::first_probes;
    }

    // --- how deep ---

    CutPrices cut_prices(const CostModel& costs) const;
    DepthTestBudget depth_budget(const CostModel& costs) const;

    /// The cost of testing a node again that was hidden: its share of a query.
    double kept_us(const CostModel& costs) const;
    /// The time that testing a new node, which costs `draw_us` to draw, saves on average: in this
    /// frame and, with queries, in the frames for which it probably stays hidden.
    double hoped_us(const CostModel& costs, double draw_us, double hidden_share,
                    double keep_probability) const;
    /// QueryReasonable for a visible node that was tested `age_frames` ago. `chance_covered` is the
    /// probability that it lies behind what is drawn (coverage.h).
    bool retest_pays(const CostModel& costs, double draw_us, double chance_covered,
                     double age_frames) const;
    /// Records that `kept` nodes, hidden before, took `tests` queries in a frame.
    void note_sharing(double tests, double kept);

    // --- what methods cost ---

    /// The expected cost of a frame's tests by `method`, if it makes as many as the last frame.
    double expected_us(const CostModel& costs, TestMethod method) const;
    /// True if enough read-backs were so far above their hint that they need no more measuring.
    bool reads_are_expensive(const CostModel& costs) const;

    // --- after a frame ---

    struct Outcome {
        double drawn_units = 0.0;  ///< work that was drawn
        double hidden_units = 0.0; ///< work that tests saved
        double wasted_units = 0.0; ///< work that was drawn although it is hidden
        double spent_us = 0.0;     ///< time spent on tests
        bool tested = true;        ///< false: depth could not be read, or nothing was drawn
    };
    /// Ends a frame with culls(): judges whether tests paid. May change the state.
    FramePlan judge(const CostModel& costs, const Outcome& outcome);

    /// Ends a frame that drew everything.
    FramePlan drew_all(const CostModel& costs, double drawn_units);

    /// With everything in the frustum drawn: true if a probe of what tests would hide is due.
    bool probe_due(const CostModel& costs, double drawn_units) const;
    /// Ends such a probe. Changes `plan`, and may change the state.
    void judge_probe(const CostModel& costs, const Outcome& outcome, FramePlan& plan);

private:
    bool cost_is_uncertain(const CostModel& costs) const;
    bool is_being_measured(const CostModel& costs, TestMethod method, bool measures) const;
    TestMethod choose_method(const CostModel& costs, bool measures) const;

    AdaptiveOptions options_;
    State state_ = State::first_look;
    TestMethod method_ = TestMethod::automatic;
    bool can_test_ = false;
    double tests_last_frame_ = 0.0;
    double saved_per_spent_ = 0.0; ///< smoothed
    double tests_per_kept_ = kPlannerConstants.first_tests_per_kept;

    // Probes.
    uint32_t first_probes_ = 0; ///< made
    /// so that the first probe may come at once
    uint32_t frames_since_probe_ = kPlannerConstants.rare_probe_frames;
    double probe_backoff_ = 1.0;
    double units_at_probe_ = 0.0; ///< in the frustum when tests were last made
    double last_probe_us_ = 0.0;
};

} // namespace occlude
