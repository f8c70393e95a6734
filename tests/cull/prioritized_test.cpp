#include <occlude/cull/prioritized.h>

#include "support/trees.h"

#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

#include <algorithm>

namespace occlude {
namespace {

using test::look_ahead;
using test::row_tree;

// row_tree(2): items 0 to 3 at z = -10, -20, -30, -40, 100 triangles each, one in each of four
// cells along z.

TEST(Prioritized, LessMatterBeforeACellComesFirst)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device;
    Prioritized culler{tree, {.cell_triangles = 100}};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0), "draw 0 1 2 3\n"); // along the row, each behind the last
}

TEST(Prioritized, AThinCellPromisesMoreBehindItThanAFullOne)
{
    // Two rows of two cells: on the left a full cell before a hidden one, on the right a thin one.
    //      back   2 3
    //      front  0 1     the eye is before the front row, between 0 and 1
    const auto at = [](float x, float z, uint32_t triangles) {
        const glm::vec3 center{x, 0.0f, z};
        return ItemBounds{{center - 1.0f, center + 1.0f}, triangles};
    };
    const std::vector<ItemBounds> items{at(-4, -10, 1000), at(4, -10, 10), at(-4, -18, 500),
                                        at(4, -18, 490)};
    const Hierarchy tree = build_bvh(items);
    ScriptedDevice device;
    Prioritized culler{tree, {.cell_triangles = 500}};
    culler.cull(look_ahead(), device);
    const std::vector<ItemId> order(culler.drawn_items().begin(), culler.drawn_items().end());
    const auto position = [&](uint32_t item) {
        return std::find(order.begin(), order.end(), ItemId{item}) - order.begin();
    };
    EXPECT_LT(position(3), position(2));
    EXPECT_EQ(order.size(), 4u);
}

TEST(Prioritized, TheTriangleBudgetIsOverrunByAtMostACell)
{
    const Hierarchy tree = row_tree(3); // 8 items of 100 triangles
    ScriptedDevice device;
    for (const uint64_t budget : {1u, 100u, 101u, 350u, 10000u}) {
        Prioritized culler{tree, {.budget_triangles = budget, .cell_triangles = 100}};
        const FrameReport report = culler.cull(look_ahead(), device);
        const uint64_t expected = std::min<uint64_t>((budget + 99) / 100 * 100, 800);
        EXPECT_GE(report.counters.triangles_drawn, expected);
        EXPECT_LE(report.counters.triangles_drawn, expected + 100);
        EXPECT_EQ(to_string(report.guarantee), "approximate");
        EXPECT_EQ(report.counters.queries, 0u);
    }
}

TEST(Prioritized, TheTimeBudgetIsReadFromTheInjectedClock)
{
    const Hierarchy tree = row_tree(3);
    ScriptedDevice device;
    // Every item takes a tenth of a second.
    const auto clock = [&device] {
        return 0.1 * static_cast<double>(device.items_drawn_this_frame().size());
    };
    Prioritized culler{tree,
                       {.budget_triangles = 0,
                        .budget_time = 300.0,
                        .cell_triangles = 100,
                        .chunk_triangles = 100},
                       clock};
    device.begin_frame(look_ahead()); // so that the clock starts from an empty frame
    device.end_frame();
    const FrameReport report = culler.cull(look_ahead(), device);
    EXPECT_GE(report.counters.triangles_drawn, 300u);
    EXPECT_LE(report.counters.triangles_drawn, 400u);
    EXPECT_GT(report.counters.draw_calls, 1u);

    Prioritized without_clock{tree, {.budget_triangles = 0, .budget_time = 300.0}};
    EXPECT_EQ(without_clock.cull(look_ahead(), device).counters.triangles_drawn, 800u);
}

TEST(Prioritized, TheFinishTestsWhatTheBudgetLeftOut)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device({.boxes = [](std::span<const QueryBox> boxes) {
        return boxes[0].box.max.z > -25.0f ? uint64_t{7} : uint64_t{0};
    }});
    Prioritized culler{tree, {.budget_triangles = 100, .finish = true, .cell_triangles = 100}};
    const FrameReport report = culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0), "draw 0\nquery [?] [?] [?]\nflush\n"
                                    "wait ? -> 7\nwait ? -> 0\nwait ? -> 0\ndraw 1\n");
    EXPECT_EQ(report.guarantee, Guarantee::exact());
    const std::vector<Decision> expected{Decision::drawn, Decision::drawn_revealed,
                                         Decision::hidden, Decision::hidden};
    EXPECT_EQ(culler.decisions().by_item(tree), expected);
}

TEST(Prioritized, BatchesOfTheFinishSeeWhatEarlierOnesRevealed)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device;
    Prioritized culler{
        tree, {.budget_triangles = 100, .finish = true, .cell_triangles = 100, .batch_size = 2}};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0), "draw 0\nquery [?] [?]\nflush\nwait ? -> 1000\n"
                                    "wait ? -> 1000\ndraw 1 2\n"
                                    "query [?]\nflush\nwait ? -> 1000\ndraw 3\n");
}

TEST(Prioritized, WhatIsBehindTheViewerIsNotDrawn)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device;
    Prioritized culler{tree, {.cell_triangles = 100}};
    culler.cull(test::look({0.0f, 0.0f, -25.0f}, {0.0f, 0.0f, -26.0f}), device);
    EXPECT_EQ(device.frame_text(0), "draw 2 3\n");
}

} // namespace
} // namespace occlude
