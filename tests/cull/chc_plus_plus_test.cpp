#include <occlude/cull/chc_plus_plus.h>

#include "support/culler_probe.h"
#include "support/trees.h"
#include "support/visibility_script.h"

#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

namespace occlude {
namespace {

using test::look;
using test::look_ahead;
using test::row_tree;
using Multiqueries = ChcPlusPlusOptions::Multiqueries;

// Tree of row_tree(2): 0 (1 (3 4) 2 (5 6)); only the nearest leaf, 3, is visible. No tight bounds,
// so that traces are short.
DeviceScript nearest_leaf_visible(Latency latency = {})
{
    return {.boxes = visible_subjects({NodeId{0u}, NodeId{1u}, NodeId{3u}}),
            .latency = [latency](uint64_t) { return latency; }};
}

TEST(ChcPlusPlus, QueriesAreBatchedAndTheVQueueFillsTheWait)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device(nearest_leaf_visible(Latency::after_polls(2)));
    ChcPlusPlus culler{tree,
                       {.assume_visible_frames = 1,
                        .tight_bounds_depth = 0,
                        .multiqueries = Multiqueries::analytic}};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0),
              "query [0]\nflush\npoll 0 pending\nwait 0 -> 1000\n"
              // Both children wait in the i-queue until there is nothing to traverse: one batch.
              "query [1] [2]\nflush\npoll 1 pending\nwait 1 -> 1000\n"
              // 3 and 4 are to be traversed, so the pending 2 is left alone, not waited for.
              "poll 2 pending\npoll 2 -> 0\n"
              "query [3] [4]\nflush\npoll 3 pending\nwait 3 -> 1000\npoll 4 pending\nwait 4 -> 0\n"
              "draw 0\n");
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(1),
              "draw 0\n"                               // the render queue, before the tests
              "query [4 2]\nflush\npoll 4 2 pending\n" // a multiquery over the hidden boundary
              "query [3]\nflush\n"                     // the v-queue fills the wait
              "poll 4 2 pending\nwait 4 2 -> 0\n"
              "poll 3 pending\nwait 3 -> 1000\n"); // read before the frame ends
}

TEST(ChcPlusPlus, WithoutLatencyTheVQueueComesLastInOneBatch)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device; // everything is visible, every answer is there at once
    ChcPlusPlus culler{tree, {.assume_visible_frames = 1, .tight_bounds_depth = 0}};
    culler.cull(look_ahead(), device);
    const FrameReport report = culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(1),
              "draw 0 1 2 3\nquery [3] [4] [5] [6]\nflush\n"
              "poll 3 -> 1000\npoll 4 -> 1000\npoll 5 -> 1000\npoll 6 -> 1000\n");
    EXPECT_EQ(report.counters.state_changes, 1u);
}

TEST(ChcPlusPlus, AFailedMultiqueryIsFollowedByOneTestPerNodeAtOnce)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device(nearest_leaf_visible());
    ChcPlusPlus culler{tree, {.tight_bounds_depth = 0, .multiqueries = Multiqueries::analytic}};
    for (int frame = 0; frame < 3; ++frame) {
        culler.cull(look_ahead(), device);
    }
    device.script().boxes = visible_subjects({NodeId{4u}});
    const FrameReport report = culler.cull(look_ahead(), device);
    EXPECT_EQ(report.counters.multiqueries, 1u);
    EXPECT_EQ(report.counters.multiqueries_failed, 1u);
    const std::string text = device.frame_text(3);
    EXPECT_NE(text.find("query [4 2]\nflush\npoll 4 2 -> 1000\n"
                        "query [4] [2]\nflush\npoll 4 -> 1000\npoll 2 -> 0\n"),
              std::string::npos)
        << text;
    EXPECT_NE(text.find("draw 1\n"), std::string::npos) << text; // the leaf that turned visible
}

TEST(ChcPlusPlus, EveryNodeIsTestedAtMostTwiceAFrame)
{
    // If nodes of failed groups went back into the i-queue, the same group could form for ever.
    const Hierarchy tree = test::random_bvh(400, 3);
    uint64_t frame = 0;
    ScriptedDevice device({.boxes = test::consistent_visibility(tree, 5, frame, 0.5f)});
    ChcPlusPlus culler{tree};
    for (; frame < 40; ++frame) {
        device.clear_trace();
        culler.cull(look({0, 0, 120}, {0, 0, 0}), device);
        std::map<NodeId, int> tests_of;
        for (const auto& event : device.trace()) {
            uint32_t first = 0;
            for (const uint32_t end : event.test_ends) {
                std::vector<NodeId> nodes(event.subjects.begin() + first,
                                          event.subjects.begin() + end);
                nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
                for (const NodeId node : nodes) {
                    ++tests_of[node];
                }
                first = end;
            }
        }
        for (const auto& [node, count] : tests_of) {
            ASSERT_LE(count, 2) << "node " << node.value << " in frame " << frame;
        }
    }
}

TEST(ChcPlusPlus, PendingAnswersDoNotStopTheTraversalOfVisibleNodes)
{
    const Hierarchy tree = row_tree(3); // leaves 7 .. 14
    std::vector<NodeId> visible;
    for (uint32_t node = 0; node < 15; ++node) {
        if (node != 7) {
            visible.push_back(NodeId{node}); // all but the nearest leaf
        }
    }
    ScriptedDevice device(
        {.boxes = visible_subjects(visible), .latency = [](uint64_t) { return Latency::never(); }});
    ChcPlusPlus culler{tree, {.batch_size = 1, .tight_bounds_depth = 0}};
    culler.cull(look_ahead(), device);
    culler.cull(look_ahead(), device);
    // Node 7 is tested first. Everything else is drawn before the culler waits for it.
    const std::string text = device.frame_text(1);
    const std::string before_wait = text.substr(0, text.find("wait"));
    EXPECT_EQ(before_wait.find("query [7]"), 0u) << text;
    EXPECT_NE(before_wait.find("draw 1 2 3 4 5 6 7\n"), std::string::npos) << text;
}

TEST(ChcPlusPlus, NoAnswerIsLeftForTheNextFrame)
{
    // Reading v-queue results a frame late would classify the visible tree as hidden: a query
    // storm.
    const Hierarchy tree = row_tree(4);
    ScriptedDevice device({.latency = [](uint64_t) { return Latency::never(); }});
    ChcPlusPlus culler{tree, {.assume_visible_frames = 1}};
    for (int frame = 0; frame < 6; ++frame) {
        const FrameReport report = culler.cull(look_ahead(), device);
        EXPECT_EQ(device.outstanding(), 0u);
        EXPECT_TRUE(CullerProbe::idle(culler));
        if (frame > 0) {
            EXPECT_EQ(report.counters.queries, 16u); // the visible leaves, no more
        }
    }
}

TEST(ChcPlusPlus, TheFirstRetestIsUniformAndLaterOnesAreRegular)
{
    constexpr uint32_t kFrames = 8;
    const Hierarchy tree = test::random_bvh(4000, 11, 1);
    ScriptedDevice device;
    ChcPlusPlus culler{tree, {.assume_visible_frames = kFrames}};
    const View view = look({0, 0, 200}, {0, 0, 0});
    std::map<uint32_t, std::vector<uint32_t>> tested; // by node: the frames that tested it
    for (uint32_t frame = 0; frame < 4 * kFrames; ++frame) {
        culler.cull(view, device);
        for (const DecisionLog::Entry& entry : culler.decisions().entries()) {
            if (entry.decision == Decision::drawn_tested) {
                tested[entry.node.value].push_back(frame);
            }
        }
    }
    ASSERT_GT(tested.size(), 1000u);
    std::vector<size_t> first(kFrames + 1);
    for (const auto& [node, frames] : tested) {
        ASSERT_GE(frames.front(), 1u);
        ASSERT_LE(frames.front(), kFrames);
        ++first[frames.front()];
        for (size_t i = 1; i < frames.size(); ++i) {
            ASSERT_EQ(frames[i] - frames[i - 1], kFrames);
        }
    }
    const double expected = static_cast<double>(tested.size()) / kFrames;
    for (uint32_t frame = 1; frame <= kFrames; ++frame) {
        EXPECT_NEAR(static_cast<double>(first[frame]), expected, 0.2 * expected);
    }
}

TEST(ChcPlusPlus, WithoutJitterAllAreRetestedTogether)
{
    const Hierarchy tree = row_tree(3);
    ScriptedDevice device;
    ChcPlusPlus culler{tree, {.assume_visible_frames = 4, .jitter = false}};
    std::vector<uint64_t> queries;
    for (int frame = 0; frame < 9; ++frame) {
        queries.push_back(culler.cull(look_ahead(), device).counters.queries);
    }
    EXPECT_EQ(queries, (std::vector<uint64_t>{15, 0, 0, 0, 8, 0, 0, 0, 8}));
}

TEST(ChcPlusPlus, LongHiddenNodesAreGroupedBeforeRecentOnes)
{
    // A known port sorts by ascending probability, so that its groups start with the worst nodes.
    const Hierarchy tree = row_tree(4); // leaves 15 .. 30
    std::vector<NodeId> visible{NodeId{0u}};
    for (uint32_t node = 1; node < 15; ++node) {
        visible.push_back(NodeId{node});
    }
    for (uint32_t node = 15; node < 31; node += 2) {
        visible.push_back(NodeId{node}); // every second leaf, so that all inner nodes stay visible
    }
    visible.push_back(NodeId{16u}); // and this one at first
    ScriptedDevice device({.boxes = visible_subjects(visible)});
    ChcPlusPlus culler{tree,
                       {.assume_visible_frames = 1,
                        .tight_bounds_depth = 0,
                        .multiqueries = Multiqueries::analytic}};
    for (int frame = 0; frame < 6; ++frame) {
        culler.cull(look_ahead(), device);
    }
    visible.pop_back();
    device.script().boxes = visible_subjects(visible);
    culler.cull(look_ahead(), device); // 16 is found hidden, drawn for the last time
    device.clear_trace();
    culler.cull(look_ahead(), device);
    const std::string text = device.trace_text();
    // Near to far 16 comes first; by its probability it is tested last, alone.
    EXPECT_NE(text.find("query [18 20 22 24 26 28 30] [16]"), std::string::npos) << text;
}

TEST(ChcPlusPlus, MeasuredProbabilitiesGiveLargerGroupsThanElevenNodes)
{
    const Hierarchy tree = row_tree(7);
    const auto largest_group = [&](Multiqueries multiqueries) {
        std::vector<NodeId> visible;
        for (uint32_t node = 0; node < 127; ++node) {
            visible.push_back(NodeId{node});
        }
        for (uint32_t node = 127; node < 255; node += 2) {
            visible.push_back(NodeId{node});
        }
        ScriptedDevice device({.boxes = visible_subjects(visible)});
        ChcPlusPlus culler{
            tree, {.batch_size = 1000, .tight_bounds_depth = 0, .multiqueries = multiqueries}};
        for (int frame = 0; frame < 40; ++frame) {
            device.clear_trace();
            culler.cull(look_ahead(), device);
        }
        uint32_t largest = 0;
        for (const auto& event : device.trace()) {
            uint32_t first = 0;
            for (const uint32_t end : event.test_ends) {
                largest = std::max(largest, end - first);
                first = end;
            }
        }
        return largest;
    };
    EXPECT_EQ(largest_group(Multiqueries::off), 1u);
    EXPECT_EQ(largest_group(Multiqueries::analytic), 11u);
    EXPECT_GT(largest_group(Multiqueries::measured), 30u);
}

TEST(ChcPlusPlus, TightBoundsReplaceABoxByItsDescendants)
{
    // row_tree's boxes are small in a long row: node 1's children fill far less area than node 1.
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device({.boxes = visible_subjects({})});
    ChcPlusPlus tight{tree, {.tight_bounds_depth = 2, .tight_bounds_area = 1.4f}};
    EXPECT_EQ(tight.cull(look_ahead(), device).counters.boxes, 4u);
    ChcPlusPlus one_level{tree, {.tight_bounds_depth = 1, .tight_bounds_area = 1.4f}};
    EXPECT_EQ(one_level.cull(look_ahead(), device).counters.boxes, 2u);
    ChcPlusPlus off{tree, {.tight_bounds_depth = 0}};
    EXPECT_EQ(off.cull(look_ahead(), device).counters.boxes, 1u);
    ChcPlusPlus no_area{tree, {.tight_bounds_depth = 2, .tight_bounds_area = 0.1f}};
    EXPECT_EQ(no_area.cull(look_ahead(), device).counters.boxes, 1u);
}

TEST(ChcPlusPlus, VirtualLeavesAreDrawnWholeAndBoundedTightly)
{
    Hierarchy tree = row_tree(2);
    tree.set_virtual_leaves(200); // nodes 1 and 2 are leaves now
    ScriptedDevice device;
    ChcPlusPlus culler{tree, {.tight_bounds_depth = 1}};
    culler.cull(look_ahead(), device);
    EXPECT_NE(device.frame_text(0).find("query [1 1] [2 2]"), std::string::npos);
    EXPECT_NE(device.frame_text(0).find("draw 0 1 2 3"), std::string::npos);
    ChcPlusPlus real_leaves{tree, {.tight_bounds_depth = 0, .virtual_leaves = false}};
    ScriptedDevice other;
    real_leaves.cull(look_ahead(), other);
    EXPECT_NE(other.frame_text(0).find("query [3] [4] [5] [6]"), std::string::npos)
        << other.frame_text(0);
}

TEST(ChcPlusPlus, TheRenderQueueIsDrawnInOneBatchBeforeTests)
{
    const Hierarchy tree = row_tree(3);
    ScriptedDevice device;
    ChcPlusPlus queued{tree};
    queued.cull(look_ahead(), device);
    EXPECT_EQ(queued.cull(look_ahead(), device).counters.draw_calls, 1u);
    ChcPlusPlus unqueued{tree, {.render_queue = false}};
    unqueued.cull(look_ahead(), device);
    EXPECT_EQ(unqueued.cull(look_ahead(), device).counters.draw_calls, 8u);
}

TEST(ChcPlusPlus, AMinimumOfTrianglesHoldsTheRenderQueueBack)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device(nearest_leaf_visible());
    ChcPlusPlus culler{tree, {.min_render_triangles = 1000, .tight_bounds_depth = 0}};
    culler.cull(look_ahead(), device);
    culler.cull(look_ahead(), device);
    const std::string text = device.frame_text(1);
    EXPECT_LT(text.find("query"), text.find("draw 0")) << text; // 100 triangles wait till the end
    EXPECT_NE(text.find("draw 0"), std::string::npos);
}

TEST(ChcPlusPlus, ADepthOnlyPassIsFollowedByOneShadingBatch)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device;
    ChcPlusPlus culler{tree, {.depth_only_pass = true}};
    culler.cull(look_ahead(), device);
    culler.cull(look_ahead(), device);
    const std::string text = device.frame_text(1);
    EXPECT_EQ(text.find("draw depth_only 0 1 2 3\n"), 0u) << text;
    EXPECT_NE(text.find("draw shade_equal 0 1 2 3\n"), std::string::npos) << text;
    EXPECT_EQ(culler.drawn_items().size(), 4u); // the visible list
}

TEST(ChcPlusPlus, ABoxVisibleWithHiddenChildrenOscillatesButIsAskedEveryFrame)
{
    // Box 1 is visible, its children are not, as they do not fill it. It is opened in one frame and
    // found hidden, its own box is tested in the next frame, and so on. This costs time, and never
    // changes the image.
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device(
        {.boxes = visible_subjects({NodeId{0u}, NodeId{1u}, NodeId{2u}, NodeId{5u}})});
    ChcPlusPlus culler{tree, {.assume_visible_frames = 1, .tight_bounds_depth = 0}};
    for (int frame = 0; frame < 8; ++frame) {
        culler.cull(look_ahead(), device);
        EXPECT_EQ(culler.drawn_items().size(), 1u);
        const std::vector<Decision> decisions = culler.decisions().by_item(tree);
        EXPECT_TRUE(decisions[0] == Decision::hidden || decisions[0] == Decision::hidden_group);
        EXPECT_TRUE(decisions[1] == Decision::hidden || decisions[1] == Decision::hidden_group);
    }
}

TEST(ChcPlusPlus, ANodeThatComesBackIntoTheFrustumHasNoHistory)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device(nearest_leaf_visible());
    ChcPlusPlus culler{tree, {.tight_bounds_depth = 0}};
    for (int frame = 0; frame < 6; ++frame) {
        culler.cull(look_ahead(), device);
    }
    culler.cull(look({0, 0, 0}, {0, 0, 1}), device);
    device.clear_trace();
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.trace_text().find("frame 7\nquery [0]\n"), 0u) << device.trace_text();
    EXPECT_EQ(device.trace_text().find("query [4 2]"),
              std::string::npos); // tested on its own again
}

TEST(ChcPlusPlus, TwoViewsOverOneHierarchyDoNotDisturbEachOther)
{
    const Hierarchy tree = test::random_bvh(300, 7);
    uint64_t frame = 0;
    const auto run = [&](bool interleaved) {
        ScriptedDevice device({.boxes = test::consistent_visibility(tree, 1, frame, 0.3f)});
        ScriptedDevice other_device({.boxes = test::consistent_visibility(tree, 2, frame, 0.3f)});
        ChcPlusPlus culler{tree};
        ChcPlusPlus other{tree};
        std::vector<uint64_t> hashes;
        for (frame = 0; frame < 20; ++frame) {
            if (interleaved) {
                other.cull(look({120, 0, 0}, {0, 0, 0}), other_device);
            }
            culler.cull(look({0, 0, 120}, {0, 0, 0}), device);
            hashes.push_back(culler.decisions().hash(tree, frame));
        }
        return hashes;
    };
    EXPECT_EQ(run(false), run(true));
}

} // namespace
} // namespace occlude
