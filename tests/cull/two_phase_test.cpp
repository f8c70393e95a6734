#include <occlude/cull/two_phase.h>

#include "support/culler_probe.h"
#include "support/trees.h"

#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

#include <algorithm>

namespace occlude {
namespace {

using test::look;
using test::look_ahead;
using test::row_tree;

// Tree of row_tree(2): 0 (1 (3 4) 2 (5 6)). The nearest points of its items have window depth
// 0.98899, 0.99484, 0.99665 and 0.99754.
constexpr float kBeyondItem0 = 0.992f;
constexpr float kBeyondItem1 = 0.9955f;

DeviceScript depth_everywhere(const float& depth)
{
    DeviceScript script;
    script.depth = [&depth](const PixelRect&, std::span<float> out) {
        std::fill(out.begin(), out.end(), depth);
        return true;
    };
    script.caps.read_depth = true;
    return script;
}

TEST(TwoPhase, ColdStartDrawsEverythingThenKeepsWhatItsOwnDepthShows)
{
    const Hierarchy tree = row_tree(2);
    float depth = kBeyondItem0;
    ScriptedDevice device(depth_everywhere(depth));
    TwoPhase culler{tree};
    for (int frame = 0; frame < 3; ++frame) {
        culler.cull(look_ahead(), device);
    }
    EXPECT_EQ(device.frame_text(0), "draw 0 1 2 3\n"); // nothing drawn yet: no depth to read
    EXPECT_EQ(device.frame_text(1), "draw 0 1 2 3\nflush\nread_depth 0 0 64x64\n");
    EXPECT_EQ(device.frame_text(2), "draw 0\nflush\nread_depth 0 0 64x64\n");
    EXPECT_TRUE(CullerProbe::visible(culler, NodeId{3u}));
    EXPECT_FALSE(CullerProbe::visible(culler, NodeId{4u}));
    EXPECT_FALSE(CullerProbe::visible(culler, NodeId{2u}));
    const std::vector<Decision> expected{Decision::drawn_tested, Decision::hidden, Decision::hidden,
                                         Decision::hidden};
    EXPECT_EQ(culler.decisions().by_item(tree), expected);
}

TEST(TwoPhase, ReadsTilesWhereTheDeviceHasThemAndPixelsElsewhere)
{
    const Hierarchy tree = row_tree(2);
    float depth = kBeyondItem0;
    DeviceScript script = depth_everywhere(depth);
    script.caps.depth_reads = {{.tile_px = 1}, {.tile_px = 8}, {.tile_px = 128}};
    script.depth_tiles = [&](int tile_px, std::span<float> out) {
        const glm::ivec2 tiles = tiles_in({64, 64}, tile_px);
        EXPECT_EQ(out.size(), static_cast<size_t>(tiles.x * tiles.y));
        std::fill(out.begin(), out.end(), depth);
        return true;
    };
    ScriptedDevice device(script);
    const auto third_frame = [&](uint32_t tile) {
        device.clear_trace();
        TwoPhase culler{tree, {.tile = tile}};
        for (int frame = 0; frame < 3; ++frame) {
            culler.cull(look_ahead(), device);
        }
        return device.frame_text(device.trace().back().frame);
    };
    EXPECT_EQ(third_frame(8), "draw 0\nflush\nread_depth_tiles 8\n");
    EXPECT_EQ(third_frame(16), "draw 0\nflush\nread_depth 0 0 64x64\n") << "no such tiles";
    EXPECT_EQ(third_frame(128), "draw 0\nflush\nread_depth_tiles 128\n") << "one for all";
    EXPECT_EQ(third_frame(0), "draw 0\nflush\nread_depth 0 0 64x64\n");
    device.script().depth_tiles = [](int, std::span<float>) { return false; };
    EXPECT_EQ(third_frame(8), "draw 0\nflush\nread_depth_tiles 8\nread_depth 0 0 64x64\n")
        << "a read of tiles that fails";
}

TEST(TwoPhase, PhaseTwoDrawsWhatTheDepthOfPhaseOneReveals)
{
    const Hierarchy tree = row_tree(2);
    float depth = kBeyondItem0;
    ScriptedDevice device(depth_everywhere(depth));
    TwoPhase culler{tree};
    for (int frame = 0; frame < 3; ++frame) {
        culler.cull(look_ahead(), device);
    }
    depth = kBeyondItem1;
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(3), "draw 0\nflush\nread_depth 0 0 64x64\ndraw 1\n");
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(4), "draw 0 1\nflush\nread_depth 0 0 64x64\n");
}

TEST(TwoPhase, HiddenSiblingsBecomeOneEntryThatIsTestedOnce)
{
    const Hierarchy tree = row_tree(4); // 16 leaves
    float depth = kBeyondItem0;
    ScriptedDevice device(depth_everywhere(depth));
    TwoPhase culler{tree};
    for (int frame = 0; frame < 200; ++frame) { // a node is tried in one frame of 16
        culler.cull(look_ahead(), device);
    }
    const FrameReport report = culler.cull(look_ahead(), device);
    // The first leaf, and the sibling of each node on the path to it.
    EXPECT_EQ(report.counters.nodes_visited, 5u);
    EXPECT_EQ(CullerProbe::cut(culler).entries().size(), 5u);
    EXPECT_EQ(report.counters.queries, 0u);
    EXPECT_EQ(report.counters.depth_reads, 1u);
    EXPECT_EQ(report.counters.pixels_read, 64u * 64u);
}

// One leaf of three items, of which the first hides the others.
TEST(TwoPhase, TheItemsOfALeafAreTestedOneByOne)
{
    std::vector<Node> nodes(1);
    nodes[0].own_items = 3;
    std::vector<ItemBounds> bounds;
    for (const float z : {-10.0f, -20.0f, -30.0f}) {
        const glm::vec3 center{0.0f, 0.0f, z};
        bounds.push_back({{center - 1.0f, center + 1.0f}, 12});
    }
    const Hierarchy tree = Hierarchy::from_arrays(
        std::move(nodes), {ItemId{0u}, ItemId{1u}, ItemId{2u}}, std::move(bounds));
    float depth = kBeyondItem0;
    ScriptedDevice device(depth_everywhere(depth));
    TwoPhase culler{tree};
    for (int frame = 0; frame < 3; ++frame) {
        culler.cull(look_ahead(), device);
    }
    EXPECT_EQ(device.frame_text(2), "draw 0\nflush\nread_depth 0 0 64x64\n");
    const std::vector<Decision> expected{Decision::drawn_tested, Decision::hidden,
                                         Decision::hidden};
    EXPECT_EQ(culler.decisions().by_item(tree), expected);
    depth = kBeyondItem1;
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(3), "draw 0\nflush\nread_depth 0 0 64x64\ndraw 1\n");
}

TEST(TwoPhase, AfterACutDepthIsReadAgainBeforeEverythingIsDrawn)
{
    const Hierarchy tree = row_tree(2);
    float depth = kBeyondItem0;
    ScriptedDevice device(depth_everywhere(depth));
    TwoPhase culler{tree, {.reread_triangles = 100}};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0), "draw 0\nread_depth 0 0 64x64\n");
}

TEST(TwoPhase, TheFinalDepthDropsWhatPhaseTwoHasHidden)
{
    const Hierarchy tree = row_tree(2);
    float depth = kBeyondItem0;
    ScriptedDevice device(depth_everywhere(depth));
    TwoPhase culler{tree, {.reread_triangles = 0, .final_depth = true}};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0), "draw 0 1 2 3\nread_depth 0 0 64x64\n");
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(1), "draw 0\nflush\nread_depth 0 0 64x64\nread_depth 0 0 64x64\n");
}

TEST(TwoPhase, VirtualLeavesAreTestedAndDrawnAsOne)
{
    Hierarchy tree = row_tree(2);
    tree.set_virtual_leaves(200);
    float depth = kBeyondItem0;
    ScriptedDevice device(depth_everywhere(depth));
    TwoPhase culler{tree, {.virtual_leaves = true}};
    for (int frame = 0; frame < 3; ++frame) {
        culler.cull(look_ahead(), device);
    }
    EXPECT_EQ(device.frame_text(2), "draw 0 1\nflush\nread_depth 0 0 64x64\n");
}

TEST(TwoPhase, OneFarPixelBesideTheBoxDecidesOnlyWithoutRefinement)
{
    const Hierarchy tree = row_tree(0);
    DeviceScript script;
    script.caps.read_depth = true;
    // Item 0 covers the pixels from 27 to 34, whose coarse texels reach from 24 to 35.
    script.depth = [](const PixelRect& rect, std::span<float> out) {
        std::fill(out.begin(), out.end(), 0.5f);
        out[static_cast<size_t>(32 * rect.width + 26)] = 1.0f;
        return true;
    };
    for (const bool refine : {true, false}) {
        ScriptedDevice device(script);
        TwoPhase culler{tree, {.refine = refine}};
        for (int frame = 0; frame < 2; ++frame) {
            culler.cull(look({0.3f, 0.0f, 0.0f}, {0.3f, 0.0f, -1.0f}), device);
        }
        EXPECT_EQ(CullerProbe::visible(culler, tree.root()), !refine);
    }
}

TEST(TwoPhase, WithoutDepthEverythingInTheFrustumIsDrawnInOneBatch)
{
    const Hierarchy tree = row_tree(3);
    float depth = 0.0f;
    for (const bool announced : {false, true}) {
        DeviceScript script = depth_everywhere(depth);
        script.caps.read_depth = announced;
        if (announced) {
            script.depth = [](const PixelRect&, std::span<float>) { return false; }; // it fails
        }
        ScriptedDevice device(script);
        TwoPhase culler{tree};
        for (int frame = 0; frame < 3; ++frame) {
            const FrameReport report = culler.cull(look_ahead(), device);
            EXPECT_EQ(culler.drawn_items().size(), 8u);
            EXPECT_EQ(report.counters.draw_calls, 1u);
            EXPECT_EQ(report.counters.depth_reads, 0u);
            EXPECT_EQ(report.guarantee, Guarantee::exact());
        }
    }
}

TEST(TwoPhase, ANodeThatComesBackIntoTheFrustumIsTestedNotDrawnFromOldNews)
{
    const Hierarchy tree = row_tree(2);
    float depth = 1.0f;
    ScriptedDevice device(depth_everywhere(depth));
    TwoPhase culler{tree};
    culler.cull(look_ahead(), device);
    EXPECT_TRUE(CullerProbe::visible(culler, tree.root()));
    culler.cull(look({0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}), device); // looks away
    EXPECT_FALSE(CullerProbe::visible(culler, tree.root()));
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(2), "draw 0 1 2 3\n"); // as after a cold start
}

TEST(TwoPhase, WhatTheNearPlaneTouchesIsDrawnWhateverTheDepth)
{
    const Hierarchy tree = row_tree(0);
    float depth = 0.0f; // would hide everything
    ScriptedDevice device(depth_everywhere(depth));
    TwoPhase culler{tree};
    for (int frame = 0; frame < 3; ++frame) {
        culler.cull(look({0.0f, 0.0f, -10.0f}, {0.0f, 0.0f, -11.0f}), device); // inside the box
        EXPECT_EQ(culler.drawn_items().size(), 1u);
    }
}

} // namespace
} // namespace occlude
