// The planner of `adaptive` by numbers alone: its decisions, frame by frame, for costs and findings
// that are written down here. (Simulated views: planner_walks_test.cpp.)
#include "cull/adaptive/planner.h"

#include <gtest/gtest.h>

namespace occlude {
namespace {

using namespace test::planner;
using State = AdaptivePlanner::State;
using Outcome = AdaptivePlanner::Outcome;
using Start = AdaptivePlanner::Start;

// Brings a planner with these options to the state in which it culls by queries.
AdaptivePlanner culling_by_queries(const CostModel& costs, const AdaptiveOptions& options = {})
{
    AdaptivePlanner planner{options};
    planner.start_frame(costs, kNothingKnown);
    FramePlan plan = planner.drew_all(costs, 1000.0);
    planner.judge_probe(costs, {.drawn_units = 1000.0, .hidden_units = 900.0, .spent_us = 10.0},
                        plan);
    planner.start_frame(costs, kKnown);
    EXPECT_TRUE(planner.culls());
    return planner;
}

// --- states --------------------------------------------------------------------------------------

TEST(Planner, ByDepthItCullsFromTheFirstFrameOn)
{
    const CostModel costs = costs_of({.query_us = 1e6f, .reads_depth = true});
    AdaptivePlanner planner{{}};
    planner.start_frame(costs, kNothingKnown);
    EXPECT_EQ(planner.method(), TestMethod::pyramid);
    EXPECT_EQ(planner.state(), State::first_look);
    EXPECT_TRUE(planner.culls());
}

TEST(Planner, ByTestsOnTheDeviceItDrawsAllFirstAndProbesAtOnce)
{
    const CostModel costs = costs_of({});
    AdaptivePlanner planner{{}};
    planner.start_frame(costs, kNothingKnown);
    EXPECT_EQ(planner.method(), TestMethod::queries);
    EXPECT_EQ(planner.state(), State::first_probes);
    EXPECT_FALSE(planner.culls());
    EXPECT_EQ(planner.drew_all(costs, 1000.0).kind, FramePlan::Kind::draw_all);
    EXPECT_TRUE(planner.probe_due(costs, 1000.0));
}

TEST(Planner, AFirstLookThatHidesEnoughBeginsToCull)
{
    const CostModel costs = costs_of({.query_us = 1e6f, .reads_depth = true});
    for (const double hidden : {1199.0, 1201.0}) { // against 1,000 us, with a margin of 1.2
        AdaptivePlanner planner{{}};
        planner.start_frame(costs, kNothingKnown);
        const FramePlan plan = planner.judge(
            costs, {.drawn_units = 500.0, .hidden_units = hidden, .spent_us = 1000.0});
        EXPECT_EQ(plan.reason, FramePlan::Reason::first_look);
        EXPECT_EQ(planner.state(), hidden > 1200.0 ? State::culling : State::drawing_all);
    }
}

TEST(Planner, WhatAFirstLookDrewInVainCountsAsHidden)
{
    const CostModel costs = costs_of({.query_us = 1e6f, .reads_depth = true});
    AdaptivePlanner planner{{}};
    planner.start_frame(costs, kNothingKnown);
    planner.judge(costs, {.hidden_units = 100.0, .wasted_units = 1200.0, .spent_us = 1000.0});
    EXPECT_EQ(planner.state(), State::culling);
    // Only then: in the next frame the hidden geometry need not be drawn.
    for (int frame = 0; frame < 20 && planner.culls(); ++frame) {
        planner.start_frame(costs, kKnown);
        planner.judge(costs, {.hidden_units = 100.0, .wasted_units = 1200.0, .spent_us = 1000.0});
    }
    EXPECT_EQ(planner.state(), State::drawing_all);
}

TEST(Planner, OneBadFrameDoesNotEndCullingButSeveralDo)
{
    const CostModel costs = costs_of({});
    AdaptivePlanner planner = culling_by_queries(costs);
    const Outcome good{.drawn_units = 100.0, .hidden_units = 300.0, .spent_us = 100.0};
    const Outcome bad{.drawn_units = 100.0, .hidden_units = 50.0, .spent_us = 100.0};
    for (int frame = 0; frame < 40; ++frame) { // ratio 3
        planner.judge(costs, good);
    }
    planner.judge(costs, bad); // 0.75 x 3 + 0.25 x 0.5 = 2.375
    EXPECT_EQ(planner.state(), State::culling);
    planner.judge(costs, bad); // 1.906
    planner.judge(costs, bad); // 1.555
    planner.judge(costs, bad); // 1.291
    EXPECT_EQ(planner.state(), State::culling);
    planner.judge(costs, bad); // 1.093 < 1.2
    EXPECT_EQ(planner.state(), State::drawing_all);
}

TEST(Planner, OneLuckyFrameCountsAsSixteenTimesItsCostAtMost)
{
    const CostModel costs = costs_of({});
    AdaptivePlanner planner = culling_by_queries(costs);
    const Outcome even{.hidden_units = 121.0, .spent_us = 100.0};
    for (int frame = 0; frame < 60; ++frame) {
        planner.judge(costs, even); // towards 1.21
    }
    planner.judge(costs, {.hidden_units = 1e9, .spent_us = 1.0}); // at most 0.75 x 1.22 + 4
    const Outcome nothing{.hidden_units = 0.0, .spent_us = 100.0};
    int frames = 0;
    for (; planner.culls(); ++frames) {
        planner.judge(costs, nothing);
    }
    EXPECT_EQ(frames, 5); // 4.92 x 0.75^5 = 1.17
}

TEST(Planner, AFrameThatSpentNothingHasNoReasonToCull)
{
    const CostModel costs = costs_of({});
    AdaptivePlanner planner = culling_by_queries(costs);
    planner.judge(costs, {.drawn_units = 10.0, .hidden_units = 0.0, .spent_us = 0.0});
    EXPECT_EQ(planner.state(), State::drawing_all);
}

TEST(Planner, AMethodThatAnOptionPrescribesIsNotGivenUp)
{
    const CostModel costs = costs_of({});
    AdaptivePlanner planner =
        culling_by_queries(costs, {.method = AdaptiveOptions::Method::queries});
    for (int frame = 0; frame < 50; ++frame) {
        const FramePlan plan = planner.judge(costs, {.hidden_units = 0.0, .spent_us = 1000.0});
        EXPECT_EQ(plan.reason, FramePlan::Reason::chosen);
        EXPECT_EQ(planner.state(), State::culling);
    }
}

TEST(Planner, WithoutATestItDrawsAllAndSaysWhy)
{
    const CostModel none = costs_of({.same_frame_results = false});
    AdaptivePlanner planner{{}};
    planner.start_frame(none, kNothingKnown);
    EXPECT_FALSE(planner.can_test());
    EXPECT_EQ(planner.drew_all(none, 100.0).reason, FramePlan::Reason::no_tests);
    EXPECT_FALSE(planner.probe_due(none, 100.0));

    const CostModel all = costs_of({});
    AdaptivePlanner told{{.method = AdaptiveOptions::Method::draw_all}};
    told.start_frame(all, kNothingKnown);
    EXPECT_EQ(told.drew_all(all, 100.0).reason, FramePlan::Reason::chosen);
    EXPECT_FALSE(told.probe_due(all, 100.0));
}

TEST(Planner, AResetForgetsTheView)
{
    const CostModel costs = costs_of({});
    AdaptivePlanner planner = culling_by_queries(costs);
    planner.note_sharing(100.0, 100.0);
    planner.reset();
    EXPECT_EQ(planner.state(), State::first_look);
    EXPECT_EQ(planner.method(), TestMethod::automatic);
    planner.start_frame(costs, kNothingKnown);
    EXPECT_DOUBLE_EQ(planner.kept_us(costs), 0.2); // a fifth of a query again
}

// --- methods -------------------------------------------------------------------------------------

TEST(Planner, ChoosesTheCheapestMethodForTheTestsOfTheLastFrame)
{
    // A read-back costs 400 us and 0.1 us a test, flags 15 us and 1 us a test.
    const CostModel costs = costs_of({.query_us = 3.0f, .flag_us = 1.0f, .reads_depth = true});
    AdaptivePlanner planner{{}};
    planner.start_frame(costs, {.tests_last_frame = 10.0});
    EXPECT_EQ(planner.method(), TestMethod::raster);
    // 615 against 460 us: not enough to switch. 1,015 against 500 us: switches.
    EXPECT_FALSE(planner.start_frame(costs, {.tests_last_frame = 600.0}));
    EXPECT_TRUE(planner.start_frame(costs, {.tests_last_frame = 1000.0}));
    EXPECT_EQ(planner.method(), TestMethod::pyramid);
    // Switches back only where flags are cheaper by the same margin: 415 against 440 us does not,
    // 79 against 406 us does.
    EXPECT_FALSE(planner.start_frame(costs, {.tests_last_frame = 400.0}));
    EXPECT_TRUE(planner.start_frame(costs, {.tests_last_frame = 64.0}));
    EXPECT_EQ(planner.method(), TestMethod::raster);
}

TEST(Planner, AFewReadBacksDecideNothingUnlessTheyAreFarFromTheirHint)
{
    CostModel costs = costs_of({.query_us = 3.0f, .reads_depth = true});
    AdaptivePlanner planner{{.method = AdaptiveOptions::Method::pyramid}};
    planner.start_frame(costs, kNothingKnown);
    costs.record_round(TestMethod::pyramid, 1, 1, 1500.0); // the hint is 400
    costs.record_round(TestMethod::pyramid, 1, 1, 1500.0);
    EXPECT_FALSE(planner.reads_are_expensive(costs));
    costs.record_round(TestMethod::pyramid, 1, 1, 1700.0);
    costs.record_round(TestMethod::pyramid, 1, 1, 1700.0);
    costs.record_round(TestMethod::pyramid, 1, 1, 1700.0);
    EXPECT_TRUE(planner.reads_are_expensive(costs));
}

// --- probes --------------------------------------------------------------------------------------

// Counts the frames until the next probe. All frames have the same work.
int frames_to_probe(AdaptivePlanner& planner, const CostModel& costs, double units)
{
    for (int frame = 1; frame < 100000; ++frame) {
        planner.start_frame(costs, kNothingKnown);
        planner.drew_all(costs, units);
        if (planner.probe_due(costs, units)) {
            return frame;
        }
    }
    return -1;
}

void probe_in_vain(AdaptivePlanner& planner, const CostModel& costs, double units, double spent_us)
{
    FramePlan plan;
    planner.judge_probe(costs, {.drawn_units = units, .spent_us = spent_us}, plan);
    EXPECT_EQ(plan.reason, FramePlan::Reason::probe);
    EXPECT_FALSE(planner.culls());
}

// A planner that has made its first probes and draws all.
AdaptivePlanner drawing_all(const CostModel& costs, double units, double probe_us)
{
    AdaptivePlanner planner{{}};
    for (uint32_t i = 0; i < kPlannerConstants.max_first_probes; ++i) {
        planner.start_frame(costs, kNothingKnown);
        probe_in_vain(planner, costs, units, probe_us);
    }
    EXPECT_EQ(planner.state(), State::drawing_all);
    return planner;
}

TEST(Planner, ProbesTakeTheirShareOfTheTimeAndBackOffWhileTheyFindNothing)
{
    // A frame takes 100,000 us. Probes may take 0.005 of it: 500 us a frame.
    const CostModel costs = costs_of({});
    AdaptivePlanner planner = drawing_all(costs, 1e5, 20000.0);
    // A probe of 20,000 us uses the share of 40 frames, and takes a fifth of a frame. So 128 frames
    // are the minimum, and back-off makes them 160.
    EXPECT_NEAR(frames_to_probe(planner, costs, 1e5), 160, 1);
    probe_in_vain(planner, costs, 1e5, 2000.0); // the share of 4 frames, backed off to 16
    EXPECT_NEAR(frames_to_probe(planner, costs, 1e5), 16, 1);
}

TEST(Planner, AProbeThatAlmostPaysIsNotInVain)
{
    const CostModel costs = costs_of({});
    AdaptivePlanner planner = drawing_all(costs, 1e5, 20000.0);
    FramePlan plan;
    planner.judge_probe(costs, {.drawn_units = 1e5, .hidden_units = 11000.0, .spent_us = 20000.0},
                        plan);
    EXPECT_EQ(planner.state(), State::drawing_all); // 0.55 of its cost
    EXPECT_EQ(frames_to_probe(planner, costs, 1e5), 128);
}

TEST(Planner, ANoticeableProbeComesSoonerWhereTheViewHasChanged)
{
    const CostModel costs = costs_of({});
    for (const double units : {1.24e5, 1.26e5}) {
        AdaptivePlanner planner = drawing_all(costs, 1e5, 7000.0); // 7% of a frame
        EXPECT_EQ(frames_to_probe(planner, costs, units), units < 1.25e5 ? 128 : 16);
    }
}

TEST(Planner, AProbeMustPromiseMoreThanCullingMustKeep)
{
    const CostModel costs = costs_of({});
    for (const double hidden : {149.0, 151.0}) {
        AdaptivePlanner planner = drawing_all(costs, 1000.0, 100.0);
        FramePlan plan;
        planner.judge_probe(costs, {.hidden_units = hidden, .spent_us = 100.0}, plan);
        EXPECT_EQ(planner.state(), hidden > 150.0 ? State::culling : State::drawing_all);
    }
}

// --- how deep ------------------------------------------------------------------------------------

TEST(Planner, ANodeIsOpenedWhereDrawingItCostsMoreThanTwoTestsOfHiddenNodes)
{
    const CostModel costs = costs_of({.query_us = 10.0f});
    AdaptivePlanner planner = culling_by_queries(costs);
    EXPECT_DOUBLE_EQ(planner.kept_us(costs), 2.0); // a fifth of a query
    EXPECT_DOUBLE_EQ(planner.cut_prices(costs).min_open_us, 4.0);
    for (int frame = 0; frame < 100; ++frame) {
        planner.note_sharing(50.0, 50.0); // they cannot share a query any more
    }
    EXPECT_NEAR(planner.cut_prices(costs).min_open_us, 20.0, 0.01);
}

TEST(Planner, ATestIsCreditedWithTheFramesForWhichANodeStaysHidden)
{
    const CostModel costs = costs_of({.query_us = 10.0f});
    const AdaptivePlanner planner = culling_by_queries(costs);
    EXPECT_DOUBLE_EQ(planner.hoped_us(costs, 100.0, 0.5, 0.0), 50.0);
    // Hidden for one frame more: saves 100 us once, and then 98 us.
    EXPECT_DOUBLE_EQ(planner.hoped_us(costs, 100.0, 0.5, 0.5), 0.5 * (100.0 + 98.0));
    // Looks at most 16 frames ahead, however certain the prediction.
    EXPECT_DOUBLE_EQ(planner.hoped_us(costs, 100.0, 1.0, 0.9999), 100.0 + 16.0 * 98.0);
}

TEST(Planner, AVisibleNodeIsTestedAgainTheSoonerTheMoreIsInFrontOfIt)
{
    const CostModel costs = costs_of({.query_us = 10.0f});
    const AdaptivePlanner planner = culling_by_queries(costs);
    const auto frames_until = [&](double covered) {
        double age = 1.0;
        while (!planner.retest_pays(costs, 102.0, covered, age)) {
            age += 1.0;
        }
        return age;
    };
    EXPECT_EQ(frames_until(1.0), 1.0);    // 50 us of benefit a frame
    EXPECT_EQ(frames_until(0.5), 1.0);    // 12.5 us
    EXPECT_EQ(frames_until(0.25), 4.0);   // 3.125 us
    EXPECT_EQ(frames_until(0.125), 13.0); // 0.78 us
    EXPECT_FALSE(planner.retest_pays(costs, 102.0, 0.0, 1e6));
}

} // namespace
} // namespace occlude
