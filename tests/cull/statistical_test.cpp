#include <occlude/cull/statistical.h>

#include "support/culler_probe.h"
#include "support/trees.h"
#include "support/visibility_script.h"

#include <occlude/cull/stop_and_wait.h>
#include <occlude/device/scripted_device.h>
#include <occlude/hierarchy/builders/bsp_builder.h>

#include <gtest/gtest.h>

#include <algorithm>

namespace occlude {
namespace {

using test::look;
using test::look_ahead;
using test::row_tree;
using Issue = StatisticalOptions::Issue;
using Time = StatisticalOptions::Time;
using Results = StatisticalOptions::Results;

// Tree of row_tree(2): 0 (1 (3 4) 2 (5 6)); only the nearest leaf, 3, is visible.
DeviceScript nearest_leaf_visible()
{
    return {.boxes = visible_subjects({NodeId{0u}, NodeId{1u}, NodeId{3u}})};
}

// The nodes tested in `frame`, in order.
std::vector<uint32_t> tested(const ScriptedDevice& device, uint64_t frame)
{
    std::vector<uint32_t> nodes;
    for (const auto& event : device.trace()) {
        if (event.frame == frame && event.verb == ScriptedDevice::Verb::query) {
            for (const NodeId node : event.subjects) {
                nodes.push_back(node.value);
            }
        }
    }
    return nodes;
}

// Runs frames until `node` is tested again after frame 0, and returns the seconds between.
double seconds_to_next_test(Statistical& culler, ScriptedDevice& device, NodeId node, double& now,
                            double step)
{
    const double start = now;
    for (int i = 0; i < 1000; ++i) {
        now += step;
        device.clear_trace();
        culler.cull(look_ahead(), device);
        for (const auto& event : device.trace()) {
            if (std::ranges::find(event.subjects, node) != event.subjects.end()) {
                return now - start;
            }
        }
    }
    return -1.0;
}

TEST(Statistical, TheFirstFrameGoesDownTheTreeInBatches)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device(nearest_leaf_visible());
    Statistical culler{tree};
    culler.cull(look_ahead(), device);
    // Children take the place of their parent: 3 and 4 come before 2, which is answered already.
    EXPECT_EQ(device.frame_text(0), "query [0]\nflush\npoll 0 -> 1000\n"
                                    "query [1] [2]\nflush\npoll 1 -> 1000\npoll 2 -> 0\n"
                                    "query [3] [4]\nflush\npoll 3 -> 1000\npoll 4 -> 0\n"
                                    "draw 0\n");
}

TEST(Statistical, TheNextFrameTestsOnlyWhatWasHidden)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device(nearest_leaf_visible());
    Statistical culler{tree};
    culler.cull(look_ahead(), device);
    const FrameReport report = culler.cull(look_ahead(), device);
    // 0, 1 and 3 are drawn untested, and before the tests.
    EXPECT_EQ(device.frame_text(1), "draw 0\nquery [4] [2]\nflush\npoll 4 -> 0\npoll 2 -> 0\n");
    EXPECT_EQ(report.counters.queries, 2u);
    EXPECT_EQ(report.counters.batches, 1u);
    EXPECT_EQ(report.counters.waits, 0u);
    EXPECT_EQ(report.counters.nodes_visited, 5u);
}

TEST(Statistical, TestsAtTheirPlaceSeeTheDrawsBeforeThem)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device(nearest_leaf_visible());
    Statistical culler{tree, {.issue = Issue::at_place}};
    culler.cull(look_ahead(), device);
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(1), "draw 0\nquery [4]\nflush\nquery [2]\nflush\n"
                                    "poll 4 -> 0\npoll 2 -> 0\n");
}

TEST(Statistical, NoMoreTestsAreUnderWayThanAllowed)
{
    const Hierarchy tree = row_tree(3); // 7 .. 14 are the leaves
    for (const Results results : {Results::all, Results::oldest}) {
        ScriptedDevice device({.latency = [](uint64_t) { return Latency::never(); }});
        Statistical culler{tree, {.base_time = 0.0f, .max_in_flight = 3, .results = results}};
        culler.cull(look_ahead(), device);
        size_t under_way = 0;
        size_t most = 0;
        for (const auto& event : device.trace()) {
            if (event.verb == ScriptedDevice::Verb::query) {
                under_way += event.tickets.size();
            } else if (event.verb == ScriptedDevice::Verb::wait) {
                --under_way;
            }
            most = std::max(most, under_way);
        }
        EXPECT_EQ(most, 3u);
        EXPECT_EQ(culler.drawn_items().size(), 8u);
    }
}

TEST(Statistical, WithTheOldestResultThePointerReturnsWhileOthersAreUnderWay)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device({.latency = [](uint64_t) { return Latency::never(); }});
    Statistical culler{tree, {.results = Results::oldest}};
    culler.cull(look_ahead(), device);
    // 3 and 4 are tested while 2 still is under way; 2 keeps the place of 5 and 6.
    const std::string text = device.frame_text(0);
    EXPECT_LT(text.find("query [3] [4]"), text.find("wait 2"));
    EXPECT_LT(text.find("wait 2"), text.find("query [5] [6]"));
    EXPECT_EQ(culler.drawn_items().size(), 4u);
}

TEST(Statistical, ThePauseFollowsTheFormula)
{
    const Hierarchy tree = row_tree(1);
    const Statistical culler{tree, {.base_time = 2.0f, .spread = 0.0f}};
    EXPECT_DOUBLE_EQ(CullerProbe::pause(culler, NodeId{0u}, 0), 2.0);
    EXPECT_DOUBLE_EQ(CullerProbe::pause(culler, NodeId{0u}, 1), 3.0);
    EXPECT_DOUBLE_EQ(CullerProbe::pause(culler, NodeId{0u}, 2), 3.5);
    EXPECT_DOUBLE_EQ(CullerProbe::pause(culler, NodeId{0u}, 8), 4.0 - 2.0 / 256.0);
}

TEST(Statistical, SpreadPausesStayWithinTheSpreadAndDiffer)
{
    const Hierarchy tree = row_tree(1);
    const Statistical culler{tree, {.base_time = 1.0f, .spread = 0.25f}};
    double least = 10.0;
    double most = 0.0;
    for (uint32_t node = 0; node < 1000; ++node) {
        least = std::min(least, CullerProbe::pause(culler, NodeId{node}, 1));
        most = std::max(most, CullerProbe::pause(culler, NodeId{node}, 1));
    }
    EXPECT_GE(least, 1.5 * 0.75);
    EXPECT_LT(least, 1.5 * 0.76);
    EXPECT_LE(most, 1.5 * 1.25);
    EXPECT_GT(most, 1.5 * 1.24);
}

TEST(Statistical, ANodeIsTestedLessOftenTheMoreOftenItWasVisible)
{
    const Hierarchy tree = row_tree(0); // a single leaf
    ScriptedDevice device;
    double now = 5.0;
    Statistical culler{
        tree,
        {.base_time = 1.0f, .history = 2, .max_age = 9.0f, .spread = 0.0f, .time = Time::clock},
        [&now] { return now; }};
    culler.cull(look_ahead(), device);
    // 1.5 s after one visible result, 1.75 s after two. Only the last two results count.
    const double step = 0.125;
    EXPECT_DOUBLE_EQ(seconds_to_next_test(culler, device, NodeId{0u}, now, step), 1.5);
    EXPECT_DOUBLE_EQ(seconds_to_next_test(culler, device, NodeId{0u}, now, step), 1.75);
    EXPECT_DOUBLE_EQ(seconds_to_next_test(culler, device, NodeId{0u}, now, step), 1.75);
}

TEST(Statistical, AHiddenResultAmongTheKeptOnesShortensThePause)
{
    const Hierarchy tree = row_tree(0);
    ScriptedDevice device;
    double now = 0.0;
    Statistical culler{
        tree,
        {.base_time = 1.0f, .history = 2, .max_age = 9.0f, .spread = 0.0f, .time = Time::clock},
        [&now] { return now; }};
    culler.cull(look_ahead(), device);
    seconds_to_next_test(culler, device, NodeId{0u}, now, 0.125); // visible two times
    device.script().boxes = visible_subjects({});
    EXPECT_DOUBLE_EQ(seconds_to_next_test(culler, device, NodeId{0u}, now, 0.125), 1.75);
    EXPECT_TRUE(culler.drawn_items().empty());
    // Hidden: tested in every frame, so that it is drawn in the first frame in which it is visible.
    EXPECT_DOUBLE_EQ(seconds_to_next_test(culler, device, NodeId{0u}, now, 0.125), 0.125);
    device.script().boxes = {};
    EXPECT_DOUBLE_EQ(seconds_to_next_test(culler, device, NodeId{0u}, now, 0.125), 0.125);
    EXPECT_EQ(culler.drawn_items().size(), 1u);
    EXPECT_DOUBLE_EQ(seconds_to_next_test(culler, device, NodeId{0u}, now, 0.125), 1.5);
}

TEST(Statistical, StatisticsThatAreTooOldAreForgotten)
{
    const Hierarchy tree = row_tree(0);
    ScriptedDevice device;
    double now = 0.0;
    Statistical culler{tree,
                       {.base_time = 1.0f, .max_age = 2.0f, .spread = 0.0f, .time = Time::clock},
                       [&now] { return now; }};
    culler.cull(look_ahead(), device);
    seconds_to_next_test(culler, device, NodeId{0u}, now, 0.125); // two visible results
    now += 10.0;                                                  // looked elsewhere
    device.clear_trace();
    culler.cull(look_ahead(), device);
    EXPECT_EQ(culler.drawn_items().size(), 1u);
    // As after a first result: if the two old results counted, it would be 1.875 s.
    EXPECT_DOUBLE_EQ(seconds_to_next_test(culler, device, NodeId{0u}, now, 0.125), 1.5);
}

TEST(Statistical, WithoutAClockFramesAreTime)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device(nearest_leaf_visible());
    Statistical culler{tree, {.base_time = 0.5f, .spread = 0.0f, .frames_per_second = 8.0f}};
    for (uint64_t frame = 0; frame < 8; ++frame) {
        culler.cull(look_ahead(), device);
    }
    // One visible result: 0.75 s are six frames. Meanwhile only the hidden boundary is tested.
    const std::vector<uint32_t> boundary{4, 2};
    for (uint64_t frame = 1; frame < 6; ++frame) {
        EXPECT_EQ(tested(device, frame), boundary) << frame;
    }
    EXPECT_EQ(tested(device, 6), (std::vector<uint32_t>{0, 1, 2, 3, 4}));
    EXPECT_EQ(tested(device, 7), boundary);
}

TEST(Statistical, ABaseTimeOfZeroTestsEveryNodeInEveryFrame)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device(nearest_leaf_visible());
    Statistical culler{tree, {.base_time = 0.0f}};
    for (uint64_t frame = 0; frame < 3; ++frame) {
        EXPECT_EQ(culler.cull(look_ahead(), device).counters.queries, 5u);
    }
}

TEST(Statistical, OnASmoothPathItAsksAtMostHalfOfWhatStopAndWaitAsks)
{
    const Hierarchy tree = test::random_bvh(600, 23);
    uint64_t epoch = 0; // what is visible changes slowly, by some items
    ScriptedDevice device({.boxes = test::consistent_visibility(tree, 7, epoch, 0.2f)});
    Statistical statistical{tree};
    StopAndWait stop_and_wait{tree};
    FrameCounters asked;
    FrameCounters baseline;
    for (uint64_t frame = 0; frame < 240; ++frame) {
        epoch = frame / 8;
        const View view = look({0.0f, 0.0f, 110.0f - 0.05f * static_cast<float>(frame)}, {});
        asked += statistical.cull(view, device).counters;
        baseline += stop_and_wait.cull(view, device).counters;
    }
    EXPECT_LE(2 * asked.queries, baseline.queries);
    EXPECT_LE(10 * asked.state_changes, baseline.state_changes);
    // Items that turn hidden are drawn for some frames more.
    EXPECT_GE(asked.triangles_drawn, baseline.triangles_drawn);
    EXPECT_LE(asked.triangles_drawn, 4 * baseline.triangles_drawn);
}

TEST(Statistical, ItemsOfAnInnerNodeAreDrawnWithItBeforeItsChildren)
{
    // Item 0 lies across the plane between 1 (near) and 2 (far).
    const auto box = [](float near, float far) {
        return ItemBounds{{{-1.0f, -1.0f, -far}, {1.0f, 1.0f, -near}}, 10};
    };
    const std::vector<ItemBounds> items{box(18.0f, 22.0f), box(10.0f, 12.0f), box(28.0f, 30.0f)};
    const Hierarchy tree =
        build_bsp(items, {.split = BspOptions::Split::middle, .leaf_triangles = 0});
    ASSERT_EQ(tree.own_items(tree.root()).size(), 1u);
    ASSERT_EQ(tree.own_items(NodeId{1u})[0], ItemId{2u}); // the low side of z is the far one
    ScriptedDevice device;
    Statistical culler{tree};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0), "query [0]\nflush\npoll 0 -> 1000\ndraw 0\n"
                                    "query [2] [1]\nflush\npoll 2 -> 1000\npoll 1 -> 1000\n"
                                    "draw 1 2\n");
}

TEST(Statistical, NodesThatTheNearPlaneMayTouchAreOpenedWithoutATest)
{
    const Hierarchy tree = row_tree(1);
    ScriptedDevice device;
    Statistical culler{tree};
    culler.cull(look({0.0f, 0.0f, -10.0f}, {0.0f, 0.0f, -20.0f}), device);
    EXPECT_EQ(device.frame_text(0), "draw 0\nquery [2]\nflush\npoll 2 -> 1000\ndraw 1\n");
}

TEST(Statistical, ALostAnswerDrawsTheNodeButIsNoStatistic)
{
    const Hierarchy tree = row_tree(0);
    ScriptedDevice device(
        {.latency = [](uint64_t test) { return test == 0 ? Latency::lost() : Latency{}; }});
    Statistical culler{tree};
    EXPECT_EQ(culler.cull(look_ahead(), device).counters.lost_answers, 1u);
    EXPECT_EQ(culler.drawn_items().size(), 1u);
    EXPECT_EQ(culler.cull(look_ahead(), device).counters.queries, 1u);
    EXPECT_EQ(culler.cull(look_ahead(), device).counters.queries, 0u);
}

TEST(Statistical, AResetOrANewStructureForgetsTheStatistics)
{
    Hierarchy tree = row_tree(0);
    ScriptedDevice device;
    Statistical culler{tree};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(culler.cull(look_ahead(), device).counters.queries, 0u);
    culler.reset();
    EXPECT_EQ(culler.cull(look_ahead(), device).counters.queries, 1u);
    EXPECT_EQ(culler.cull(look_ahead(), device).counters.queries, 0u);
    tree.set_virtual_leaves(0);
    EXPECT_EQ(culler.cull(look_ahead(), device).counters.queries, 1u);
}

TEST(Statistical, AThresholdIsReportedAsApproximate)
{
    const Hierarchy tree = row_tree(1);
    ScriptedDevice device({.boxes = [](auto) { return uint64_t{20}; }});
    Statistical exact{tree};
    Statistical approximate{tree, {.threshold = 20}};
    EXPECT_EQ(to_string(exact.cull(look_ahead(), device).guarantee), "exact");
    EXPECT_EQ(exact.drawn_items().size(), 2u);
    EXPECT_EQ(to_string(approximate.cull(look_ahead(), device).guarantee), "approximate(20)");
    EXPECT_TRUE(approximate.drawn_items().empty());
}

} // namespace
} // namespace occlude
