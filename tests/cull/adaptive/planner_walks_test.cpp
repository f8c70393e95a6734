// The planner of `adaptive` over many frames of simple simulated views and devices.
#include "cull/adaptive/planner.h"

#include <gtest/gtest.h>

namespace occlude {
namespace {

using test::planner::costs_of;
using Outcome = AdaptivePlanner::Outcome;

// A view of which tests would hide `hidden(frame)` of 10,000 triangles at `test_us` a frame.
struct Walk {
    int culled = 0;
    int probes = 0;
    double us = 0.0; ///< of drawing and testing
};

template <class Hidden>
Walk walk(const CostModel& costs, double test_us, int frames, Hidden&& hidden)
{
    constexpr double kUnits = 10000.0;
    AdaptivePlanner planner{{}};
    Walk walk;
    bool known = false;
    for (int frame = 0; frame < frames; ++frame) {
        planner.start_frame(costs, {.cut_is_empty = !known, .tests_last_frame = 100.0});
        const double hides = hidden(frame) * kUnits;
        if (planner.culls()) {
            ++walk.culled;
            walk.us += kUnits - hides + test_us;
            planner.judge(
                costs, {.drawn_units = kUnits - hides, .hidden_units = hides, .spent_us = test_us});
        } else {
            FramePlan plan = planner.drew_all(costs, kUnits);
            walk.us += kUnits;
            if (planner.probe_due(costs, kUnits)) {
                ++walk.probes;
                walk.us += test_us;
                planner.judge_probe(
                    costs, {.drawn_units = kUnits, .hidden_units = hides, .spent_us = test_us},
                    plan);
            }
        }
        known = planner.culls();
    }
    return walk;
}

TEST(Planner, WhereNothingIsHiddenProbesTakeAHundredthOfTheTimeAtMost)
{
    for (const bool reads : {false, true}) {
        const CostModel costs = costs_of({.query_us = reads ? 1e6f : 1.0f, .reads_depth = reads});
        const Walk w = walk(costs, 200.0, 2000, [](int) { return 0.0; });
        EXPECT_LE(w.culled, 1);
        EXPECT_GT(w.probes, 3);
        EXPECT_LE(w.us, 1.01 * 2000 * 10000.0);
    }
}

TEST(Planner, WhereMuchIsHiddenItCullsAllButTheFirstFrame)
{
    const CostModel costs = costs_of({});
    const Walk w = walk(costs, 200.0, 200, [](int) { return 0.9; });
    EXPECT_EQ(w.culled, 199);
    EXPECT_EQ(w.probes, 1);
}

TEST(Planner, FollowsAViewThatChangesBetweenOpenAndClosed)
{
    const CostModel costs = costs_of({});
    const auto hidden = [](int frame) { return frame / 500 % 2 == 0 ? 0.0 : 0.9; };
    const Walk w = walk(costs, 200.0, 2000, hidden);
    EXPECT_GT(w.culled, 700);  // 1,000 frames are worth it
    EXPECT_LT(w.culled, 1030); // few other frames are culled
    EXPECT_LT(w.us, 0.7 * 2000 * 10000.0);
}

// Five kinds of device costs with different hidden work: culling is never slower than drawing
// everything.
TEST(Planner, OnSimulatedDevicesItNeverCostsMoreThanDrawingAll)
{
    for (const float triangle_us : {0.01f, 0.1f, 1.0f}) {
        for (const double test_us : {50.0, 500.0, 5000.0}) {
            for (const double share : {0.0, 0.05, 0.3, 0.9}) {
                const CostModel costs = costs_of(
                    {.us_per_triangle = triangle_us, .query_us = 1e6f, .reads_depth = true});
                AdaptivePlanner planner{{}};
                constexpr double kUnits = 100000.0;
                constexpr int kFrames = 1000;
                const double draw_us = static_cast<double>(triangle_us) * kUnits;
                double us = 0.0;
                for (int frame = 0; frame < kFrames; ++frame) {
                    planner.start_frame(costs, {.tests_last_frame = 100.0});
                    const Outcome outcome{.drawn_units = (1.0 - share) * kUnits,
                                          .hidden_units = share * kUnits,
                                          .spent_us = test_us};
                    if (planner.culls()) {
                        us += (1.0 - share) * draw_us + test_us;
                        planner.judge(costs, outcome);
                        continue;
                    }
                    us += draw_us;
                    FramePlan plan = planner.drew_all(costs, kUnits);
                    if (planner.probe_due(costs, kUnits)) {
                        us += test_us;
                        planner.judge_probe(costs, outcome, plan);
                    }
                }
                const double first_frames_us = 2.0 * test_us;
                EXPECT_LE(us, 1.01 * kFrames * draw_us + first_frames_us)
                    << triangle_us << " us a triangle, " << test_us << " us of tests, " << share;
                if (share * draw_us > 2.0 * test_us) {
                    EXPECT_LE(us, 1.1 * kFrames * ((1.0 - share) * draw_us + test_us));
                }
            }
        }
    }
}

} // namespace
} // namespace occlude
