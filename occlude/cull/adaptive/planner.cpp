#include <occlude/cull/adaptive/planner.h>

#include <algorithm>

namespace occlude {

namespace {

constexpr const PlannerConstants& k = kPlannerConstants;

// Shorter times are rounded up to this, so that ratios are finite.
constexpr double kMinUs = 1e-3;

FramePlan::Kind kind_of(TestMethod method)
{
    switch (method) {
    case TestMethod::queries:
        return FramePlan::Kind::queries;
    case TestMethod::raster:
        return FramePlan::Kind::raster;
    case TestMethod::pyramid:
        return FramePlan::Kind::pyramid;
    case TestMethod::automatic:
        break;
    }
    return FramePlan::Kind::draw_all;
}

} // namespace

void AdaptivePlanner::reset()
{
    *this = AdaptivePlanner{options_};
}

// --- which method --------------------------------------------------------------------------------

double AdaptivePlanner::expected_us(const CostModel& costs, TestMethod method) const
{
    const double rounds = method == TestMethod::pyramid ? 1.0 : k.expected_device_rounds;
    const RoundCost cost = costs.round(method);
    return rounds * cost.us_per_round +
           std::max(tests_last_frame_, k.min_expected_tests) * cost.us_per_test;
}

bool AdaptivePlanner::reads_are_expensive(const CostModel& costs) const
{
    return costs.rounds_measured(TestMethod::pyramid) >= k.min_read_samples &&
           costs.round(TestMethod::pyramid).us_per_round >
               k.expensive_read_ratio * costs.hint(TestMethod::pyramid).us_per_round;
}

// True if the cost of the method in use rests on a few read-backs, which may have been disturbed.
// The planner then keeps the method, unless the reads are far more expensive than their hint.
bool AdaptivePlanner::cost_is_uncertain(const CostModel& costs) const
{
    return method_ == TestMethod::pyramid && costs.partly_known(method_) &&
           !reads_are_expensive(costs);
}

// True if a trial has begun to measure the method, or will do so.
bool AdaptivePlanner::is_being_measured(const CostModel& costs, TestMethod method,
                                        bool measures) const
{
    const bool tries = measures && method_ == TestMethod::pyramid && !reads_are_expensive(costs);
    return costs.partly_known(method) || (tries && costs.least_known(method).tests > 0);
}

TestMethod AdaptivePlanner::choose_method(const CostModel& costs, bool measures) const
{
    switch (options_.method) {
    case AdaptiveOptions::Method::queries:
        return TestMethod::queries;
    case AdaptiveOptions::Method::raster:
        return TestMethod::raster;
    case AdaptiveOptions::Method::pyramid:
        return TestMethod::pyramid;
    case AdaptiveOptions::Method::draw_all:
    case AdaptiveOptions::Method::automatic:
        break;
    }
    if (cost_is_uncertain(costs)) {
        return method_;
    }
    const bool has_one = costs.has(method_);
    TestMethod best = method_;
    double best_us = has_one ? k.cost_ratio_to_switch * expected_us(costs, method_) : 0.0;
    for (const TestMethod method : {TestMethod::pyramid, TestMethod::raster, TestMethod::queries}) {
        const bool not_now =
            has_one && (method == method_ || is_being_measured(costs, method, measures));
        if (!costs.has(method) || not_now) {
            continue;
        }
        const double us = expected_us(costs, method);
        if (!costs.has(best) || us < best_us) {
            best = method;
            best_us = us;
        }
    }
    return best;
}

bool AdaptivePlanner::start_frame(const CostModel& costs, const Start& start)
{
    tests_last_frame_ = start.tests_last_frame;
    const TestMethod method = choose_method(costs, start.measures);
    const bool changes = method != method_;
    if (changes) {
        method_ = method;
        last_probe_us_ = 0.0;
        frames_since_probe_ = k.rare_probe_frames;
    }
    if (start.cut_is_empty && method_ != TestMethod::pyramid) {
        // Nothing is drawn yet, so that tests on the device would hide nothing.
        if (is_first_look()) {
            state_ = State::first_probes;
            frames_since_probe_ = k.rare_probe_frames;
        } else {
            state_ = State::drawing_all;
        }
    }
    can_test_ = costs.has(method_) && options_.method != AdaptiveOptions::Method::draw_all;
    return changes;
}

// --- how deep ------------------------------------------------------------------------------------

CutPrices AdaptivePlanner::cut_prices(const CostModel& costs) const
{
    return {.us_per_unit = costs.us_per_unit(),
            .units_per_item = costs.units(0, 1),
            .min_open_us = k.kept_tests_to_open * kept_us(costs)};
}

DepthTestBudget AdaptivePlanner::depth_budget(const CostModel& costs) const
{
    return {.texels_per_us = k.texels_per_us,
            .max_texels = k.max_texels,
            .min_texels = k.min_texels,
            .texels_below_min = 0,
            .test_us = costs.round(TestMethod::pyramid).us_per_test};
}

double AdaptivePlanner::kept_us(const CostModel& costs) const
{
    const RoundCost cost = costs.round(method_);
    return method_ == TestMethod::queries
               ? cost.us_per_box + tests_per_kept_ * (cost.us_per_test - cost.us_per_box)
               : cost.us_per_test;
}

double AdaptivePlanner::hoped_us(const CostModel& costs, double draw_us, double hidden_share,
                                 double keep_probability) const
{
    const double stays = method_ == TestMethod::queries ? keep_probability : 0.0;
    const double later_frames = std::min(stays / (1.0 - stays), k.max_frames_ahead);
    return hidden_share * (draw_us + later_frames * std::max(draw_us - kept_us(costs), 0.0));
}

bool AdaptivePlanner::retest_pays(const CostModel& costs, double draw_us, double chance_covered,
                                  double age_frames) const
{
    const double benefit_us = 0.5 * chance_covered * chance_covered * (draw_us - kept_us(costs));
    return costs.round(method_).us_per_test < age_frames * benefit_us;
}

void AdaptivePlanner::note_sharing(double tests, double kept)
{
    if (method_ == TestMethod::queries && kept > 0.0) {
        tests_per_kept_ += k.tests_per_kept_step * (std::min(tests / kept, 1.0) - tests_per_kept_);
    }
}

// --- after a frame -------------------------------------------------------------------------------

// Smoothing the ratio gives hysteresis: tests need not pay in every single frame.
FramePlan AdaptivePlanner::judge(const CostModel& costs, const Outcome& outcome)
{
    const bool chooses = options_.method == AdaptiveOptions::Method::automatic;
    const bool first_look = is_first_look();
    const double saved_us = costs.us_per_unit() * outcome.hidden_units;
    FramePlan plan;
    plan.kind = kind_of(method_);
    plan.reason = !chooses     ? FramePlan::Reason::chosen
                  : first_look ? FramePlan::Reason::first_look
                               : FramePlan::Reason::saves;
    plan.drawn_us = static_cast<float>(costs.us_per_unit() * outcome.drawn_units);
    plan.saved_us = static_cast<float>(saved_us);
    plan.spent_us = static_cast<float>(outcome.spent_us);

    // The next frame does not draw what the first look drew in vain.
    const double may_save_us =
        saved_us + (first_look ? costs.us_per_unit() * outcome.wasted_units : 0.0);
    const double ratio = may_save_us / std::max(outcome.spent_us, kMinUs);
    saved_per_spent_ = first_look ? ratio
                                  : (1.0 - k.ratio_step) * saved_per_spent_ +
                                        k.ratio_step * std::min(ratio, k.max_frame_ratio);
    const bool pays = outcome.spent_us > 0.0 && (saved_per_spent_ >= double{options_.keep_margin} ||
                                                 cost_is_uncertain(costs));
    state_ = State::culling;
    if (chooses && !pays) {
        state_ = State::drawing_all;
        frames_since_probe_ = outcome.tested ? 0 : k.rare_probe_frames;
        units_at_probe_ = outcome.drawn_units + outcome.hidden_units;
    }
    return plan;
}

FramePlan AdaptivePlanner::drew_all(const CostModel& costs, double drawn_units)
{
    ++frames_since_probe_;
    const bool wanted = options_.method == AdaptiveOptions::Method::draw_all;
    FramePlan plan;
    plan.kind = FramePlan::Kind::draw_all;
    plan.reason = can_test_ ? FramePlan::Reason::saves_too_little
                  : wanted  ? FramePlan::Reason::chosen
                            : FramePlan::Reason::no_tests;
    plan.drawn_us = static_cast<float>(costs.us_per_unit() * drawn_units);
    return plan;
}

bool AdaptivePlanner::probe_due(const CostModel& costs, double drawn_units) const
{
    const double frame_us = costs.whole_us(drawn_units);
    const double probe_us = std::max(costs.round(method_).us_per_round, last_probe_us_);
    const bool other_view = std::max(drawn_units, units_at_probe_) >=
                            k.changed_work_ratio * std::min(drawn_units, units_at_probe_);
    const double interval = (other_view ? 1.0 : probe_backoff_) * probe_us /
                            std::max(frame_us * double{options_.probe_share}, 1e-6);
    const double at_least = probe_us > k.noticeable_share * frame_us
                                ? (other_view ? k.soon_probe_frames : k.rare_probe_frames)
                            : method_ == TestMethod::pyramid ? 1.0
                                                             : k.device_probe_frames;
    return can_test_ && !culls() && frames_since_probe_ >= std::max(interval, at_least);
}

void AdaptivePlanner::judge_probe(const CostModel& costs, const Outcome& outcome, FramePlan& plan)
{
    const double saved_us = costs.us_per_unit() * outcome.hidden_units;
    plan.reason = FramePlan::Reason::probe;
    plan.saved_us = static_cast<float>(saved_us);
    plan.spent_us = static_cast<float>(outcome.spent_us);
    frames_since_probe_ = 0;
    units_at_probe_ = outcome.drawn_units;
    last_probe_us_ = outcome.spent_us;
    probe_backoff_ = saved_us < k.vain_probe_ratio * outcome.spent_us
                         ? std::min(k.probe_backoff * probe_backoff_, k.max_probe_backoff)
                         : 1.0;
    ++first_probes_;
    if (saved_us > double{options_.start_margin} * outcome.spent_us) {
        saved_per_spent_ = saved_us / std::max(outcome.spent_us, kMinUs);
        state_ = State::culling;
        return;
    }
    // The first probes follow one another directly, because they teach what tests cost.
    const bool learns = is_first_look() && first_probes_ < k.max_first_probes &&
                        costs.least_known(method_).tests > 0;
    state_ = learns ? State::first_probes : State::drawing_all;
}

} // namespace occlude
