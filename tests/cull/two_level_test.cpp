#include <occlude/cull/two_level.h>

#include "support/culler_probe.h"
#include "support/trees.h"

#include <occlude/cull/registry.h>
#include <occlude/device/scripted_device.h>
#include <occlude/hierarchy/builders/two_level.h>

#include <gtest/gtest.h>

#include <algorithm>

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

TEST(TwoLevel, BoxesThatOverlapOnTheScreenAreTestedOneAfterTheOther)
{
    const Hierarchy tree = row_tree(2); // in a row along the line of sight
    ScriptedDevice device(nearest_leaf_visible());
    TwoLevel culler{tree};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0), "query [0]\nflush\npoll 0 -> 1000\n"
                                    "query [1]\nflush\npoll 1 -> 1000\n"
                                    "query [3]\nflush\npoll 3 -> 1000\ndraw 0\n"
                                    "query [4]\nflush\npoll 4 -> 0\n"
                                    "query [2]\nflush\npoll 2 -> 0\n");
    EXPECT_TRUE(CullerProbe::idle(culler));
}

TEST(TwoLevel, AllAtOnceIfAskedTo)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device(nearest_leaf_visible());
    TwoLevel culler{tree, {.disjoint = false}};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0), "query [0]\nflush\npoll 0 -> 1000\n"
                                    "query [1] [2]\nflush\npoll 1 -> 1000\npoll 2 -> 0\n"
                                    "query [3] [4]\nflush\npoll 3 -> 1000\npoll 4 -> 0\ndraw 0\n");
}

TEST(TwoLevel, BoxesBesideEachOtherAreTestedTogether)
{
    // A root over four leaves side by side.
    std::vector<ItemBounds> items;
    for (int i = 0; i < 4; ++i) {
        const glm::vec3 center{4.0f * static_cast<float>(i) - 6.0f, 0.0f, -10.0f};
        items.push_back({{center - 1.0f, center + 1.0f}, 10});
    }
    const Hierarchy tree = build_bvh(items, {.max_leaf_items = 1, .leaf_triangles = 0});
    ScriptedDevice device;
    TwoLevel culler{tree};
    const FrameReport report = culler.cull(look_ahead(), device);
    EXPECT_EQ(report.counters.queries, 7u);
    EXPECT_EQ(report.counters.batches, 3u); // one per level of the tree
    EXPECT_EQ(report.counters.items_drawn, 4u);
}

TEST(TwoLevel, AtMostMaxPendingTestsArePending)
{
    std::vector<ItemBounds> items;
    for (int i = 0; i < 8; ++i) {
        const glm::vec3 center{2.5f * static_cast<float>(i) - 9.0f, 0.0f, -12.0f};
        items.push_back({{center - 1.0f, center + 1.0f}, 10});
    }
    const Hierarchy tree = build_bvh(items, {.max_leaf_items = 1, .leaf_triangles = 0});
    ScriptedDevice device({.latency = [](uint64_t) { return Latency::never(); }});
    TwoLevel culler{tree, {.disjoint = false, .max_pending = 3}};
    culler.cull(look_ahead(), device);
    size_t most = 0;
    size_t now = 0;
    for (const ScriptedDevice::Event& event : device.trace()) {
        now += event.test_ends.size();
        now -= event.verb == ScriptedDevice::Verb::wait ? 1 : 0;
        most = std::max(most, now);
    }
    EXPECT_EQ(most, 3u);
    EXPECT_EQ(culler.drawn_items().size(), 8u);
}

TEST(TwoLevel, TheMoreOftenANodeWasVisibleTheLongerItsTestWaits)
{
    const Hierarchy tree = row_tree(0); // one leaf
    ScriptedDevice device;
    TwoLevel culler{
        tree, {.history_length = 4, .frames_per_visible = 1, .max_postponed = 3, .spread = false}};
    std::string tested;
    for (int frame = 0; frame < 20; ++frame) {
        tested += culler.cull(look_ahead(), device).counters.queries > 0 ? 'q' : '.';
        EXPECT_EQ(culler.drawn_items().size(), 1u);
    }
    EXPECT_EQ(tested, "q.q..q...q...q...q..");
}

TEST(TwoLevel, AHiddenNodeIsTestedInEveryFrame)
{
    const Hierarchy tree = row_tree(0);
    ScriptedDevice device({.boxes = visible_subjects({})});
    TwoLevel culler{tree};
    for (int frame = 0; frame < 5; ++frame) {
        EXPECT_EQ(culler.cull(look_ahead(), device).counters.queries, 1u);
        EXPECT_TRUE(culler.drawn_items().empty());
    }
}

// Six leaves side by side. The test decides which of them are visible.
Hierarchy side_by_side()
{
    std::vector<ItemBounds> items;
    for (int i = 0; i < 6; ++i) {
        const glm::vec3 center{3.0f * static_cast<float>(i) - 7.5f, 0.0f, -10.0f};
        items.push_back({{center - 1.0f, center + 1.0f}, 10});
    }
    return build_bvh(items, {.max_leaf_items = 1, .leaf_triangles = 0});
}

TEST(TwoLevel, LongHiddenNodesShareOneTestWhichIsHalvedIfItFails)
{
    const Hierarchy tree = side_by_side();
    uint64_t frame = 0;
    std::vector<bool> seen{true, false, false, false, false, false};
    ScriptedDevice device({.boxes = [&](std::span<const QueryBox> boxes) {
        uint64_t samples = 0;
        for (const QueryBox& box : boxes) {
            const bool inner = !tree.is_leaf(box.subject); // inner boxes are loose
            samples += inner ? 1 : 0;
            for (const ItemId item : tree.subtree_items(box.subject)) {
                samples += seen[item.value] ? 1 : 0;
            }
        }
        return samples;
    }});
    TwoLevel culler{tree};
    for (; frame < 40; ++frame) {
        culler.cull(look_ahead(), device);
        EXPECT_EQ(culler.drawn_items().size(), 1u);
    }
    // In most frames, one test of the five hidden leaves and nothing else.
    FrameReport report = culler.cull(look_ahead(), device);
    while (report.counters.queries > 1) {
        report = culler.cull(look_ahead(), device);
    }
    EXPECT_EQ(report.counters.multiqueries, 1u);
    EXPECT_EQ(report.counters.boxes, 5u);
    seen[4] = true;
    report = culler.cull(look_ahead(), device);
    // The test of five fails. Then three are hidden, and the test of the other two fails, so that
    // they are tested one by one.
    EXPECT_EQ(report.counters.multiqueries_failed, 2u);
    EXPECT_EQ(report.counters.queries, 1u + 2u + 2u);
    EXPECT_EQ(culler.drawn_items().size(), 2u);
}

TEST(TwoLevel, AnInnerNodeIsTestedAgainOnlyWhenAllItsChildrenAreHidden)
{
    const Hierarchy tree = side_by_side();
    bool leaves_seen = true;
    ScriptedDevice device({.boxes = [&](std::span<const QueryBox> boxes) {
        return uint64_t{leaves_seen || !tree.is_leaf(boxes[0].subject) ? 1u : 0u};
    }});
    TwoLevel culler{tree, {.max_postponed = 0, .multiqueries = false}};
    EXPECT_EQ(culler.cull(look_ahead(), device).counters.queries, 11u); // 6 leaves, 5 inner nodes
    EXPECT_EQ(culler.cull(look_ahead(), device).counters.queries, 6u);
    leaves_seen = false;
    EXPECT_EQ(culler.cull(look_ahead(), device).counters.queries, 6u);
    // The inner nodes above leaves: their boxes are visible, so that the leaves are tested, too.
    const uint64_t queries = culler.cull(look_ahead(), device).counters.queries;
    EXPECT_GT(queries, 6u);
    EXPECT_LT(queries, 11u); // the visible leaves show that the nodes above are visible
    leaves_seen = true;
    culler.cull(look_ahead(), device);
    EXPECT_EQ(culler.cull(look_ahead(), device).counters.queries, 6u);
}

TEST(TwoLevel, PartsOfDifferentObjectsAreReachedByTheirDistance)
{
    // Two long objects side by side, in four parts each: no part of one is behind all parts of the
    // other.
    TwoLevelTree tree({.leaf_triangles = 0});
    std::vector<ItemBounds> bounds;
    for (int object = 0; object < 2; ++object) {
        std::vector<Aabb> parts;
        for (int part = 0; part < 4; ++part) {
            const float z = -10.0f - 4.0f * static_cast<float>(part) - static_cast<float>(object);
            const float x = object == 0 ? -2.0f : 1.0f;
            parts.push_back({{x, -1, z - 3}, {x + 1, 1, z}});
            bounds.push_back({parts.back(), 100});
        }
        tree.add({.first_item = ItemId{static_cast<uint32_t>(4 * object)}, .local_boxes = parts});
    }
    tree.update(bounds);
    ScriptedDevice device;
    TwoLevel culler{tree.hierarchy()};
    culler.cull(look_ahead(), device); // tests all; from now on all is visible
    culler.cull(look_ahead(), device);
    std::vector<uint32_t> order;
    for (const ItemId item : culler.drawn_items()) {
        order.push_back(item.value);
    }
    EXPECT_EQ(order, (std::vector<uint32_t>{0, 4, 1, 5, 2, 6, 3, 7}));
}

TEST(TwoLevel, WithoutMultiqueriesEachHiddenNodeIsTestedByItself)
{
    const Hierarchy tree = side_by_side();
    ScriptedDevice device({.boxes = [&](std::span<const QueryBox> boxes) {
        return uint64_t{tree.is_leaf(boxes[0].subject) ? 0u : 1u};
    }});
    TwoLevel culler{tree, {.multiqueries = false}};
    for (int frame = 0; frame < 30; ++frame) {
        const FrameReport report = culler.cull(look_ahead(), device);
        EXPECT_GE(report.counters.queries, 6u);
        EXPECT_EQ(report.counters.multiqueries, 0u);
    }
}

TEST(TwoLevel, WithoutPostponingItAsksWhatStopAndWaitAsks)
{
    const Hierarchy tree = test::random_bvh(400, 4);
    ScriptedDevice one;
    ScriptedDevice other;
    TwoLevel culler{tree, {.max_postponed = 0, .pull_up = false, .multiqueries = false}};
    auto reference = make_culler("stop_and_wait", tree);
    for (int frame = 0; frame < 4; ++frame) {
        const View view = look({0, 0, 90.0f - static_cast<float>(frame)}, {0, 0, 0});
        EXPECT_EQ(culler.cull(view, one).counters.queries,
                  (*reference)->cull(view, other).counters.queries);
    }
}

TEST(TwoLevel, SpreadingShortensAPostponementByAtMostAHalf)
{
    const Hierarchy tree = test::random_bvh(400, 4, 0);
    const View view = look({0, 0, 110}, {0, 0, 0});
    uint64_t most_spread = 0;
    uint64_t most_even = 0;
    for (const bool spread : {true, false}) {
        ScriptedDevice device;
        TwoLevel culler{tree, {.pull_up = false, .spread = spread}};
        for (int frame = 0; frame < 60; ++frame) {
            const uint64_t queries = culler.cull(view, device).counters.queries;
            uint64_t& most = spread ? most_spread : most_even;
            most = frame > 30 ? std::max(most, queries) : most;
        }
    }
    EXPECT_GT(most_even, 700u); // all nodes together
    EXPECT_LT(most_spread, most_even / 2);
}

TEST(TwoLevel, ANodeThatComesBackIntoTheFrustumIsTested)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device;
    TwoLevel culler{tree};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(culler.drawn_items().size(), 4u);
    culler.cull(look({0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}), device); // looks away
    device.script().boxes = visible_subjects({});
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(2), "query [0]\nflush\npoll 0 -> 0\n");
}

} // namespace
} // namespace occlude
