#include <occlude/cull/uniform_grid.h>

#include "support/trees.h"

#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

#include <set>

namespace occlude {
namespace {

using test::look;
using test::look_ahead;
using test::row_tree;

// row_tree(2): items 0 to 3 at z = -10, -20, -30, -40, 100 triangles each. Four cells of
// 8 units, one item each; the view goes along -z, so that a slab is one cell.
constexpr UniformGridOptions kOneItemACell{.cell_triangles = 100, .nested_levels = 0};

TEST(UniformGrid, SlabsComeFrontToBackAndEachIsDrawnBeforeTheNextIsTested)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device;
    UniformGrid culler{tree, kOneItemACell};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0), "query [?]\nflush\nwait ? -> 1000\ndraw 0\n"
                                    "query [?]\nflush\nwait ? -> 1000\ndraw 1\n"
                                    "query [?]\nflush\nwait ? -> 1000\ndraw 2\n"
                                    "query [?]\nflush\nwait ? -> 1000\ndraw 3\n");
}

TEST(UniformGrid, AllCellsOfASlabAreAskedBeforeAnyAnswerIsRead)
{
    // Three items side by side, one slab.
    std::vector<ItemBounds> items;
    for (int i = 0; i < 3; ++i) {
        const glm::vec3 center{10.0f * static_cast<float>(i - 1), 0.0f, -20.0f};
        items.push_back({{center - 1.0f, center + 1.0f}, 100});
    }
    const Hierarchy tree = build_bvh(items);
    ScriptedDevice device;
    UniformGrid culler{tree, kOneItemACell};
    const FrameReport report = culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0), "query [?] [?] [?]\nflush\nwait ? -> 1000\nwait ? -> 1000\n"
                                    "wait ? -> 1000\ndraw 1 0 2\n"); // nearest first
    EXPECT_EQ(report.counters.batches, 1u);
    EXPECT_EQ(report.counters.nodes_visited, 3u);
}

TEST(UniformGrid, AnItemInSeveralCellsIsDrawnOnceAndItsCellsAreNotTestedForItAgain)
{
    // A wall along the row: one item in all four cells.
    std::vector<ItemBounds> items{{{{-1.0f, -1.0f, -41.0f}, {1.0f, 1.0f, -9.0f}}, 400},
                                  {{{-0.5f, -0.5f, -40.0f}, {0.5f, 0.5f, -39.0f}}, 0}};
    const Hierarchy tree = build_bvh(items);
    ScriptedDevice device;
    UniformGrid culler{tree, {.cell_triangles = 200, .nested_levels = 0}};
    const FrameReport report = culler.cull(look_ahead(), device);
    EXPECT_EQ(culler.drawn_items().size(), 2u);
    EXPECT_EQ(report.counters.items_drawn, 2u);
    // The near cell draws the wall; the far one still has something of its own.
    EXPECT_EQ(report.counters.queries, 2u);
}

TEST(UniformGrid, AnItemIsHiddenOnlyIfAllItsCellsAre)
{
    std::vector<ItemBounds> items{{{{-1.0f, -1.0f, -41.0f}, {1.0f, 1.0f, -9.0f}}, 400},
                                  {{{-0.5f, -0.5f, -40.0f}, {0.5f, 0.5f, -39.0f}}, 0}};
    const Hierarchy tree = build_bvh(items);
    for (const bool far_is_visible : {false, true}) {
        ScriptedDevice device({.boxes = [far_is_visible](std::span<const QueryBox> boxes) {
            return far_is_visible && boxes[0].box.min.z < -40.0f ? uint64_t{1} : uint64_t{0};
        }});
        UniformGrid culler{tree, {.cell_triangles = 200, .nested_levels = 0}};
        culler.cull(look_ahead(), device);
        EXPECT_EQ(culler.drawn_items().size(), far_is_visible ? 2u : 0u);
        const Decision expected = far_is_visible ? Decision::drawn_revealed : Decision::hidden;
        EXPECT_EQ(culler.decisions().by_item(tree), (std::vector<Decision>{expected, expected}));
    }
}

TEST(UniformGrid, ACrowdedCellIsOpenedOnlyIfItIsVisible)
{
    const Hierarchy tree = row_tree(3); // 8 items, 800 triangles
    std::vector<uint64_t> queries;
    for (const uint64_t samples : {0u, 5u}) {
        ScriptedDevice device({.boxes = [samples](auto) { return samples; }});
        UniformGrid culler{tree, {.cell_triangles = 100, .nested_levels = 1}};
        queries.push_back(culler.cull(look_ahead(), device).counters.queries);
    }
    UniformGrid nested{tree, {.cell_triangles = 150, .nested_levels = 1}};
    UniformGrid uniform{tree, {.cell_triangles = 150, .nested_levels = 0}};
    ScriptedDevice device;
    EXPECT_GE(nested.cull(look_ahead(), device).counters.queries,
              uniform.cull(look_ahead(), device).counters.queries);
    EXPECT_GE(queries[1], queries[0]);
    EXPECT_EQ(nested.drawn_items().size(), 8u);
}

TEST(UniformGrid, ACellThatTheNearPlaneMayTouchIsDrawnUntested)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device({.boxes = [](auto) { return uint64_t{0}; }});
    UniformGrid culler{tree, kOneItemACell};
    culler.cull(look({0.0f, 0.0f, -10.0f}, {0.0f, 0.0f, -11.0f}), device); // inside item 0
    EXPECT_EQ(device.frame_text(0).find("draw 0\nquery [?]\n"), 0u);
    EXPECT_EQ(culler.drawn_items().size(), 1u);
}

TEST(UniformGrid, ADeviceWithFewTestsInFlightGetsTheRestDrawn)
{
    const Hierarchy tree = build_bvh(test::random_boxes(300, 15));
    DeviceScript script{.boxes = [](auto) { return uint64_t{0}; }};
    script.caps.max_outstanding = 2;
    ScriptedDevice device(script);
    UniformGrid culler{tree, {.cell_triangles = 100}};
    const FrameReport report = culler.cull(look({0, 0, 90}, {0, 0, 0}), device);
    EXPECT_EQ(report.counters.lost_answers, 0u);
    EXPECT_GT(culler.drawn_items().size(), 0u);
}

} // namespace
} // namespace occlude
