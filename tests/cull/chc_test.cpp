#include <occlude/cull/chc.h>

#include "support/culler_probe.h"
#include "support/trees.h"

#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

namespace occlude {
namespace {

using test::look;
using test::look_ahead;
using test::row_tree;

// Tree of row_tree(2): 0 (1 (3 4) 2 (5 6)); only the nearest leaf, 3, is visible.
DeviceScript nearest_leaf_visible(Latency latency = {})
{
    return {.boxes = visible_subjects({NodeId{0u}, NodeId{1u}, NodeId{3u}}),
            .latency = [latency](uint64_t) { return latency; }};
}

TEST(Chc, FirstFrameIsDrivenByQueriesAndTraversesWhileTheyArePending)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device(nearest_leaf_visible(Latency::after_polls(2)));
    Chc culler{tree};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0), "query [0]\nflush\nwait 0 -> 1000\n"
                                    "query [1]\nflush\npoll 1 pending\n"
                                    "query [2]\nflush\nwait 1 -> 1000\n"
                                    "poll 2 pending\n"
                                    "query [3]\nflush\npoll 2 pending\n"
                                    "query [4]\nflush\nwait 2 -> 0\n"
                                    "wait 3 -> 1000\ndraw 0\nwait 4 -> 0\n");
}

TEST(Chc, LaterFramesTestOnlyVisibleLeavesAndTheHiddenBoundary)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device(nearest_leaf_visible());
    Chc culler{tree};
    culler.cull(look_ahead(), device);
    culler.cull(look_ahead(), device);
    // Nodes 0 and 1 are visible inner nodes: opened untested. 3 is drawn at once, and its test is
    // for a later frame. 4 and 2 are the hidden boundary; 5 and 6 below it are not tested.
    EXPECT_EQ(device.frame_text(1), "query [3]\nflush\ndraw 0\npoll 3 -> 1000\n"
                                    "query [4]\nflush\npoll 4 -> 0\n"
                                    "query [2]\nflush\nwait 2 -> 0\n");
}

TEST(Chc, AGeometryTestDrawsTheLeafOnce)
{
    const Hierarchy tree = row_tree(2);
    DeviceScript script = nearest_leaf_visible();
    script.caps.draw_and_query = true;
    ScriptedDevice device(script);
    Chc culler{tree, {.visible_test = ChcOptions::VisibleTest::geometry}};
    culler.cull(look_ahead(), device);
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(1), "draw_and_query 0\npoll item 0 -> 1000\n"
                                    "query [4]\nflush\npoll 4 -> 0\n"
                                    "query [2]\nflush\nwait 2 -> 0\n");
    EXPECT_EQ(culler.drawn_items().size(), 1u);
}

TEST(Chc, ALeafFoundVisibleIsAssumedVisibleForSomeFrames)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device(nearest_leaf_visible());
    Chc culler{tree, {.assume_visible_frames = 2}};
    std::vector<uint64_t> queries;
    for (int frame = 0; frame < 7; ++frame) {
        queries.push_back(culler.cull(look_ahead(), device).counters.queries);
    }
    // Two boundary nodes each frame, and the leaf in every third.
    EXPECT_EQ(queries, (std::vector<uint64_t>{5, 2, 2, 3, 2, 2, 3}));
}

TEST(Chc, AVisibleLeafFoundHiddenIsTestedBeforeItIsDrawnAgain)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device(nearest_leaf_visible());
    Chc culler{tree};
    culler.cull(look_ahead(), device);
    device.script().boxes = visible_subjects({});
    culler.cull(look_ahead(), device);
    EXPECT_EQ(culler.drawn_items().size(), 1u); // drawn while its test is under way
    EXPECT_FALSE(CullerProbe::visible(culler, NodeId{3u}));
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(2), "query [0]\nflush\nwait 0 -> 0\n");
}

TEST(Chc, NodesOutsideTheFrustumAreNotTraversed)
{
    // The listing as printed would traverse them: its `else` is one level too far to the left.
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device;
    Chc culler{tree};
    const FrameReport report = culler.cull(look({0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}), device);
    EXPECT_EQ(report.counters.nodes_visited, 1u);
    EXPECT_EQ(device.frame_text(0), "");
}

TEST(Chc, ANodeThatComesBackIntoTheFrustumIsTestedNotDrawnFromOldNews)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device;
    Chc culler{tree};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(culler.drawn_items().size(), 4u);
    culler.cull(look({0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}), device); // looks away
    device.script().boxes = visible_subjects({});
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(2), "query [0]\nflush\nwait 0 -> 0\n");
}

TEST(Chc, AResultThatIsNeverReadyIsWaitedForOnlyWhenNothingIsLeftToTraverse)
{
    const Hierarchy tree = row_tree(3);
    ScriptedDevice device({.latency = [](uint64_t) { return Latency::never(); }});
    Chc culler{tree};
    culler.cull(look_ahead(), device); // everything becomes visible
    const FrameReport report = culler.cull(look_ahead(), device);
    // All 8 leaves are drawn before the first wait.
    const std::string text = device.frame_text(1);
    const std::string before_wait = text.substr(0, text.find("wait"));
    for (int item = 0; item < 8; ++item) {
        EXPECT_NE(before_wait.find("draw " + std::to_string(item) + "\n"), std::string::npos);
    }
    EXPECT_EQ(report.counters.waits, 8u);
}

} // namespace
} // namespace occlude
