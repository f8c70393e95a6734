#include <occlude/cull/batch_and_wait.h>

#include "support/trees.h"

#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

namespace occlude {
namespace {

using test::look;
using test::look_ahead;
using test::row_tree;

TEST(BatchAndWait, TestsNObjectsAndThenReadsNResults)
{
    const Hierarchy tree = row_tree(2); // objects: nodes 3 to 6, near to far
    ScriptedDevice device({.boxes = visible_subjects({NodeId{3u}, NodeId{5u}})});
    BatchAndWait culler{tree, {.batch_size = 3}};
    const FrameReport report = culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0), "query [3] [4] [5]\nflush\n"
                                    "wait 3 -> 1000\nwait 4 -> 0\nwait 5 -> 1000\n"
                                    "draw 0 2\n"
                                    "query [6]\nflush\nwait 6 -> 0\n");
    EXPECT_EQ(report.counters.queries, 4u);
    EXPECT_EQ(report.counters.batches, 2u);
    EXPECT_EQ(to_string(report.guarantee), "exact");
}

TEST(BatchAndWait, ADepthOnlyPassIsTestedAgainstAndWhatWasDrawnIsShadedOnceInTheEnd)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device({.boxes = visible_subjects({NodeId{3u}, NodeId{5u}})});
    BatchAndWait culler{tree, {.batch_size = 3, .depth_only_pass = true}};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0), "query [3] [4] [5]\nflush\n"
                                    "wait 3 -> 1000\nwait 4 -> 0\nwait 5 -> 1000\n"
                                    "draw depth_only 0 2\n"
                                    "query [6]\nflush\nwait 6 -> 0\n"
                                    "draw shade_equal 0 2\n");
}

TEST(BatchAndWait, WhatIsLargeOnTheScreenIsDrawnFirstUntested)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device;
    // Item 0 is 2 wide at 9 before a 90 degree camera: (2 / 18)^2 = 0.0123 of the screen.
    BatchAndWait culler{tree, {.batch_size = 0, .occluder_share = 0.012f}};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0).substr(0, 25), "draw 0\nquery [4] [5] [6]\n");
}

TEST(BatchAndWait, ABoxAtTheNearPlaneIsDrawnUntested)
{
    const Hierarchy tree = row_tree(1); // nodes 1, 2 at z = -10, -20
    ScriptedDevice device({.boxes = visible_subjects({})});
    BatchAndWait culler{tree, {.occluder_share = 2.0f}};
    culler.cull(look({0.0f, 0.0f, -10.0f}, {0.0f, 0.0f, -20.0f}), device);
    EXPECT_EQ(device.frame_text(0), "draw 0\nquery [2]\nflush\nwait 2 -> 0\n");
}

TEST(BatchAndWait, SkipsTestsThatTheChapterAdvisesAgainst)
{
    const Hierarchy tree = row_tree(2);
    const auto queries = [&](const ObjectTestOptions& tests) {
        ScriptedDevice device;
        BatchAndWait culler{tree, {.occluder_share = 2.0f, .tests = tests}};
        const FrameReport report = culler.cull(look_ahead(), device);
        EXPECT_EQ(culler.drawn_items().size(), 4u);
        return report.counters.queries;
    };
    EXPECT_EQ(queries({}), 4u);
    EXPECT_EQ(queries({.skip_triangles_below = 100}), 4u); // each has 100
    EXPECT_EQ(queries({.skip_triangles_below = 101}), 0u);
    EXPECT_EQ(queries({.skip_nearer_than = 20.0f}), 2u); // they begin at 9, 19, 29, 39
    EXPECT_EQ(queries({.skip_larger_than = 0.012f}), 3u);
    EXPECT_EQ(queries({.skip_larger_than = 0.012f, .high_resolution = 64 * 64}), 3u);
    EXPECT_EQ(queries({.skip_larger_than = 0.012f, .high_resolution = 64 * 64 + 1}), 4u);
}

TEST(BatchAndWait, BallsFirstVisitsWhatTheBallTouchesAndAsksOnlyElongatedBoxes)
{
    // Balls beside the right plane, x = -z, that reach into the frustum, each with a cube that is
    // in view.
    const Aabb cube{{50.4f, -2.0f, -50.0f}, {54.4f, 2.0f, -46.0f}};
    const Aabb pillar{{52.0f, -20.0f, -50.0f}, {53.0f, 20.0f, -49.0f}};
    const auto tested_with = [](const Aabb& beside, float elongation) {
        const std::vector<ItemBounds> items{{{{-2.0f, -2.0f, -50.0f}, {2.0f, 2.0f, -46.0f}}, 10},
                                            {beside, 10}};
        const Hierarchy tree = build_bvh(items, {.max_leaf_items = 1, .leaf_triangles = 0});
        ScriptedDevice device;
        BatchAndWait culler{tree,
                            {.occluder_share = 2.0f, .tests = {.sphere_elongation = elongation}}};
        const FrameReport report = culler.cull(look_ahead(), device);
        EXPECT_EQ(culler.drawn_items().size(), 1u) << "items are held against the frustum again";
        return report.counters.queries;
    };
    EXPECT_EQ(tested_with(cube, 0.0f), 1u);
    EXPECT_EQ(tested_with(pillar, 0.0f), 1u);
    EXPECT_EQ(tested_with(cube, 2.0f), 2u);     // the ball touches, so that the box is not tested
    EXPECT_EQ(tested_with(pillar, 2.0f), 1u);   // the box is tested
    EXPECT_EQ(tested_with(pillar, 100.0f), 2u); // not elongated enough
}

TEST(BatchAndWait, ThresholdMakesItApproximate)
{
    const Hierarchy tree = row_tree(1);
    ScriptedDevice device({.boxes = [](auto) { return uint64_t{9}; }});
    BatchAndWait culler{tree, {.threshold = 9}};
    EXPECT_EQ(to_string(culler.cull(look_ahead(), device).guarantee), "approximate(9)");
    EXPECT_TRUE(culler.drawn_items().empty());
}

TEST(ObjectTests, AVirtualLeafIsTestedByItsDescendantsBoxes)
{
    // Two small boxes far apart: the sum of their surfaces is far below that of the box around
    // both.
    const std::vector<ItemBounds> pair{{{{-5.0f, -1.0f, -21.0f}, {-4.0f, 0.0f, -20.0f}}, 10},
                                       {{{4.0f, 0.0f, -31.0f}, {5.0f, 1.0f, -30.0f}}, 10}};
    const Hierarchy tree = build_bvh(pair, {.max_leaf_items = 1, .leaf_triangles = 100});
    ASSERT_TRUE(tree.is_leaf(tree.root()));
    ScriptedDevice device;
    BatchAndWait culler{tree, {.occluder_share = 2.0f}};
    EXPECT_EQ(culler.cull(look_ahead(), device).counters.boxes, 2u);
    BatchAndWait whole{tree, {.occluder_share = 2.0f, .tests = {.sub_box_depth = 0}}};
    EXPECT_EQ(whole.cull(look_ahead(), device).counters.boxes, 1u);
}

TEST(ScreenShare, IsTheAreaOfTheRectangleOnTheScreen)
{
    const View view = look_ahead();
    EXPECT_NEAR(screen_share(view, {{-5.0f, -5.0f, -10.0f}, {5.0f, 5.0f, -10.0f}}), 0.25f, 1e-5f);
    EXPECT_NEAR(screen_share(view, {{-99.0f, 0.0f, -10.0f}, {99.0f, 99.0f, -10.0f}}), 0.5f, 1e-5f);
    EXPECT_EQ(screen_share(view, {{20.0f, 0.0f, -10.0f}, {30.0f, 1.0f, -10.0f}}), 0.0f);
    EXPECT_EQ(screen_share(view, {{-1.0f, -1.0f, -10.0f}, {1.0f, 1.0f, 10.0f}}), 1.0f);
    EXPECT_EQ(screen_share(view, Aabb::everything()), 1.0f);
    EXPECT_EQ(screen_share(view, Aabb::empty()), 0.0f);
    // 1e7 units away, where the matrix to world coordinates has hardly a bit left for the screen.
    const View far = View::camera_relative(glm::mat4{view.clip_from_relative()},
                                           view.origin() + 1e7, view.size_px());
    EXPECT_NEAR(screen_share(far, {{1e7f - 5.0f, 1e7f - 5.0f, 1e7f - 10.0f},
                                   {1e7f + 5.0f, 1e7f + 5.0f, 1e7f - 10.0f}}),
                0.25f, 1e-5f);
}

} // namespace
} // namespace occlude
