#include <occlude/cull/stop_and_wait.h>

#include "support/trees.h"

#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

#include <algorithm>

namespace occlude {
namespace {

using test::look_ahead;
using test::row_tree;

// Tree of row_tree(2): 0 (1 (3 4) 2 (5 6)); only the nearest leaf, 3, is visible.
TEST(StopAndWait, AsksEachNodeAndWaitsBeforeGoingOn)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device({.boxes = visible_subjects({NodeId{0u}, NodeId{1u}, NodeId{3u}})});
    StopAndWait culler{tree};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0), "query [0]\nflush\nwait 0 -> 1000\n"
                                    "query [1]\nflush\nwait 1 -> 1000\n"
                                    "query [3]\nflush\nwait 3 -> 1000\n"
                                    "draw 0\n"
                                    "query [4]\nflush\nwait 4 -> 0\n"
                                    "query [2]\nflush\nwait 2 -> 0\n");
}

TEST(StopAndWait, NodesThatTheNearPlaneMayTouchAreOpenedWithoutATest)
{
    const Hierarchy tree = row_tree(1);
    ScriptedDevice device;
    StopAndWait culler{tree};
    // The eye stands inside the nearer leaf's box.
    const FrameReport report =
        culler.cull(test::look({0.0f, 0.0f, -10.0f}, {0.0f, 0.0f, -20.0f}), device);
    EXPECT_EQ(device.frame_text(0), "draw 0\nquery [2]\nflush\nwait 2 -> 1000\ndraw 1\n");
    EXPECT_EQ(report.counters.queries, 1u);
}

TEST(StopAndWait, CountsWhatItSaidToTheDevice)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device({.boxes = visible_subjects({NodeId{0u}, NodeId{1u}, NodeId{3u}})});
    StopAndWait culler{tree};
    const FrameCounters c = culler.cull(look_ahead(), device).counters;
    EXPECT_EQ(c.queries, 5u);
    EXPECT_EQ(c.boxes, 5u);
    EXPECT_EQ(c.waits, 5u);
    EXPECT_EQ(c.batches, 5u);
    EXPECT_EQ(c.nodes_visited, 5u);
    EXPECT_EQ(c.draw_calls, 1u);
    EXPECT_EQ(c.items_drawn, 1u);
    EXPECT_EQ(c.triangles_drawn, 100u);
    EXPECT_EQ(c.state_changes, 3u); // to testing, to drawing, to testing
}

TEST(StopAndWait, ALostAnswerIsVisibleAndReported)
{
    const Hierarchy tree = row_tree(1);
    ScriptedDevice device({.boxes = visible_subjects({}), .latency = [](uint64_t test) {
                               return test == 0 ? Latency::lost() : Latency{};
                           }});
    StopAndWait culler{tree};
    const FrameReport report = culler.cull(look_ahead(), device);
    EXPECT_EQ(report.counters.lost_answers, 1u);
    EXPECT_EQ(report.counters.queries, 3u); // the lost root was opened
}

TEST(StopAndWait, AThresholdIsReportedAsApproximate)
{
    const Hierarchy tree = row_tree(1);
    ScriptedDevice device({.boxes = [](auto) { return uint64_t{20}; }});
    StopAndWait exact{tree};
    StopAndWait approximate{tree, {.threshold = 20}};
    EXPECT_EQ(to_string(exact.cull(look_ahead(), device).guarantee), "exact");
    EXPECT_EQ(exact.drawn_items().size(), 2u);
    EXPECT_EQ(to_string(approximate.cull(look_ahead(), device).guarantee), "approximate(20)");
    EXPECT_TRUE(approximate.drawn_items().empty());
}

TEST(StopAndWait, AThresholdAsksForQueriesWhereTheDefaultMethodDoesNotCount)
{
    const Hierarchy tree = row_tree(1);
    ScriptedDevice device({.boxes = [](auto) { return uint64_t{20}; }});
    DeviceCaps& caps = device.script().caps;
    caps.methods = {{.method = TestMethod::raster, .exact_counts = false}, TestCost{}};
    caps.exact_counts = false;
    const auto first_method = [&](StopAndWait culler) {
        device.clear_trace();
        culler.cull(look_ahead(), device);
        const auto query =
            std::ranges::find(device.trace(), DeviceVerb::query, &ScriptedDevice::Event::verb);
        return query->method;
    };
    EXPECT_EQ(first_method(StopAndWait{tree}), TestMethod::automatic);
    EXPECT_EQ(first_method(StopAndWait{tree, {.threshold = 20}}), TestMethod::queries);
    caps.methods.pop_back(); // a device that cannot count
    EXPECT_EQ(first_method(StopAndWait{tree, {.threshold = 20}}), TestMethod::automatic);
    StopAndWait culler{tree, {.threshold = 20}};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(culler.drawn_items().size(), 2u) << "some is more than any threshold";
}

} // namespace
} // namespace occlude
