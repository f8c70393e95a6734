#include <occlude/hierarchy/builders/bvh_builder.h>

#include "hierarchy/scenes.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <set>

namespace occlude {
namespace {

using test::kInf;
using test::kNan;
using test::random_items;

constexpr BvhOptions kOneEach{.max_leaf_items = 1};

/// Holds for every tree, whatever the boxes: all items once, in leaves of the allowed size.
void expect_good(const Hierarchy& tree, std::span<const ItemBounds> items, uint32_t max_leaf_items)
{
    ASSERT_EQ(validate(tree), "");
    ASSERT_EQ(tree.items().size(), items.size());
    std::set<uint32_t> seen;
    for (size_t i = 0; i < items.size(); ++i) {
        const ItemId id = tree.items()[i];
        seen.insert(id.value);
        ASSERT_EQ(tree.item_bounds()[i].box, sanitized(items[id.value].box));
        ASSERT_EQ(tree.item_bounds()[i].triangles, items[id.value].triangles);
    }
    ASSERT_EQ(seen.size(), items.size());
    ASSERT_EQ(*seen.rbegin(), items.size() - 1);
    for (const Node& node : tree.nodes()) {
        ASSERT_TRUE(node.child_count == 0 || node.own_items == 0);
        if (node.child_count == 0) {
            ASSERT_GE(node.own_items, 1u);
            ASSERT_TRUE(node.own_items <= max_leaf_items || !node.box.is_bounded());
        }
    }
}

size_t depth(const Hierarchy& tree)
{
    std::vector<size_t> depths(tree.nodes().size(), 1);
    for (size_t i = 1; i < depths.size(); ++i) {
        depths[i] = depths[tree.nodes()[i].parent.value] + 1;
    }
    return *std::max_element(depths.begin(), depths.end());
}

/// The leaf that holds `item`.
NodeId leaf_of(const Hierarchy& tree, uint32_t item)
{
    for (uint32_t n = 0; n < tree.nodes().size(); ++n) {
        for (const ItemId id : tree.own_items(NodeId{n})) {
            if (id.value == item) {
                return NodeId{n};
            }
        }
    }
    return {};
}

/// Halves at the median centre of the widest axis: a tree that the heuristic must beat.
void median_node(std::vector<Node>& nodes, size_t node, std::span<uint32_t> order,
                 uint32_t first_item, std::span<const ItemBounds> items)
{
    nodes[node].first_item = first_item;
    if (order.size() == 1) {
        nodes[node].own_items = 1;
        return;
    }
    Aabb box;
    for (const uint32_t i : order) {
        box = merge(box, items[i].box);
    }
    const glm::vec3 e = box.extent();
    const int axis = e.x >= e.y && e.x >= e.z ? 0 : e.y >= e.z ? 1 : 2;
    std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
        return items[a].box.center()[axis] < items[b].box.center()[axis];
    });
    const size_t half = order.size() / 2;
    const size_t child = nodes.size();
    nodes[node].first_child = NodeId{child};
    nodes[node].child_count = 2;
    nodes.resize(child + 2);
    median_node(nodes, child, order.first(half), first_item, items);
    median_node(nodes, child + 1, order.subspan(half), first_item + static_cast<uint32_t>(half),
                items);
}

Hierarchy median_tree(std::span<const ItemBounds> items)
{
    std::vector<uint32_t> order(items.size());
    for (uint32_t i = 0; i < order.size(); ++i) {
        order[i] = i;
    }
    std::vector<Node> nodes(1);
    median_node(nodes, 0, order, 0, items);
    std::vector<ItemId> ids;
    std::vector<ItemBounds> bounds;
    for (const uint32_t i : order) {
        ids.push_back(ItemId{i});
        bounds.push_back(items[i]);
    }
    return Hierarchy::from_arrays(nodes, ids, bounds);
}

TEST(BvhBuilder, NoItemsMakeAnEmptyHierarchy)
{
    EXPECT_TRUE(build_bvh({}).empty());
}

TEST(BvhBuilder, OneItemMakesOneLeaf)
{
    const std::vector<ItemBounds> items = random_items(1, 1);
    const Hierarchy tree = build_bvh(items, kOneEach);
    expect_good(tree, items, 1);
    EXPECT_EQ(tree.nodes().size(), 1u);
    EXPECT_EQ(tree.node(tree.root()).box, items[0].box);
    EXPECT_TRUE(tree.is_leaf(tree.root()));
}

TEST(BvhBuilder, TreesOfRandomItemsAreValid)
{
    for (const size_t count : {2u, 3u, 4u, 5u, 17u, 100u, 1000u, 20000u}) {
        for (const uint32_t leaf_items : {1u, 2u, 5u, 64u}) {
            for (const uint32_t bins : {2u, 16u, 1000u}) {
                const std::vector<ItemBounds> items = random_items(count, count);
                const Hierarchy tree =
                    build_bvh(items, {.max_leaf_items = leaf_items, .bins = bins});
                expect_good(tree, items, leaf_items);
                if (leaf_items == 1) {
                    EXPECT_EQ(tree.nodes().size(), 2 * count - 1);
                }
            }
        }
    }
}

TEST(BvhBuilder, OptionsOfZeroCountAsTheLeastThatMakeSense)
{
    const std::vector<ItemBounds> items = random_items(100, 2);
    const Hierarchy tree = build_bvh(items, {.max_leaf_items = 0, .leaf_triangles = 0, .bins = 0});
    expect_good(tree, items, 1);
}

Hierarchy build_with_threads(size_t threads, std::span<const ItemBounds> items,
                             const BvhOptions& options)
{
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return build_bvh(items, options);
}

TEST(BvhBuilder, TreeDoesNotDependOnTheNumberOfThreads)
{
    // Large enough for parallel binning. Some boxes are identical, so that ids break ties.
    std::vector<ItemBounds> items = random_items(150000, 3);
    std::fill(items.begin(), items.begin() + 20000, items[0]);
    for (const uint32_t leaf_items : {1u, 4u}) {
        const BvhOptions options{.max_leaf_items = leaf_items};
        const Hierarchy one = build_with_threads(1, items, options);
        EXPECT_EQ(validate(one), "");
        for (int run = 0; run < 3; ++run) {
            EXPECT_TRUE(test::same_tree(one, build_with_threads(2, items, options)));
        }
        EXPECT_TRUE(test::same_tree(one, build_with_threads(7, items, options)));
    }
}

TEST(BvhBuilder, CostIsBelowThatOfMedianSplits)
{
    // Boxes evenly spread, and clustered with a few large boxes among small ones.
    const std::vector<ItemBounds> even = random_items(10000, 4);
    std::vector<ItemBounds> clustered = random_items(10000, 5);
    for (size_t i = 0; i < clustered.size(); ++i) {
        Aabb& box = clustered[i].box;
        const glm::vec3 shrink = i % 3 == 0 ? glm::vec3{0.01f} : glm::vec3{1.0f, 0.01f, 1.0f};
        box.min *= shrink;
        box.max = i % 100 == 0 ? box.min + 100.0f : box.max * shrink;
    }
    // One triangle each, so that the builder's measure is that of sah_cost.
    for (std::vector<ItemBounds> items : {even, clustered}) {
        for (ItemBounds& item : items) {
            item.triangles = 1;
        }
        EXPECT_LT(sah_cost(build_bvh(items, kOneEach)), sah_cost(median_tree(items)));
    }
}

TEST(BvhBuilder, SplitsApartWhatIsApart)
{
    // Two clusters far apart: they must be the root's children.
    std::vector<ItemBounds> items = random_items(100, 6);
    for (size_t i = 0; i < 30; ++i) {
        items[i].box.min.y += 1e5f;
        items[i].box.max.y += 1e5f;
    }
    const Hierarchy tree = build_bvh(items, kOneEach);
    EXPECT_EQ(tree.nodes()[1].subtree_items, 70u);
    EXPECT_EQ(tree.nodes()[2].subtree_items, 30u);
}

TEST(BvhBuilder, TheCostOfALeafCountsTrianglesNotItems)
{
    // Along x: a heavy item at 0 and light ones at 3, 4, ..., 10. A cut behind the heavy one pays
    // only if its triangles count.
    std::vector<ItemBounds> items;
    for (const float x : {0.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f, 8.0f, 9.0f, 10.0f}) {
        items.push_back({{glm::vec3{x, 0.0f, 0.0f}, glm::vec3{x + 0.9f, 1.0f, 1.0f}}, 1});
    }
    const auto root_split = [&] { return build_bvh(items, kOneEach).nodes()[1].subtree_items; };
    EXPECT_GT(root_split(), 1u);
    items[0].triangles = 1000000;
    EXPECT_EQ(root_split(), 1u);
}

TEST(BvhBuilder, IdenticalBoxesMakeABalancedTree)
{
    const std::vector<ItemBounds> items(5000, random_items(1, 7)[0]);
    const Hierarchy tree = build_bvh(items, kOneEach);
    expect_good(tree, items, 1);
    EXPECT_LE(depth(tree), 14u);
}

TEST(BvhBuilder, PointsLinesAndPlanesOfBoxesMakeGoodTrees)
{
    for (int flat_axes = 1; flat_axes <= 3; ++flat_axes) {
        std::vector<ItemBounds> items = random_items(3000, 8);
        for (ItemBounds& item : items) {
            for (int axis = 0; axis < flat_axes; ++axis) {
                item.box.min[axis] = item.box.max[axis] = 5.0f;
            }
        }
        const Hierarchy tree = build_bvh(items, kOneEach);
        expect_good(tree, items, 1);
        EXPECT_LE(depth(tree), 40u);
    }
}

TEST(BvhBuilder, HugeAndTinyScenesMakeGoodTrees)
{
    for (const float scale : {1e-42f, 1e-30f, 1e-6f, 1e6f, 1e30f, 3e35f}) {
        std::vector<ItemBounds> items = random_items(1000, 9);
        for (ItemBounds& item : items) {
            item.box.min *= scale;
            item.box.max *= scale;
        }
        expect_good(build_bvh(items, kOneEach), items, 1);
    }
    // Corners whose sums and differences overflow.
    std::vector<ItemBounds> items = random_items(100, 10);
    for (size_t i = 0; i < items.size(); i += 2) {
        items[i].box = {glm::vec3{-FLT_MAX}, glm::vec3{i % 4 == 0 ? FLT_MAX : -FLT_MAX}};
        items[i + 1].box = {glm::vec3{FLT_MAX}, glm::vec3{FLT_MAX}};
    }
    expect_good(build_bvh(items, kOneEach), items, 1);
}

TEST(BvhBuilder, DepthIsBoundedForTheWorstInput)
{
    // Each box twice as far as the last one, along alternating axes: the heuristic separates one
    // box at a time.
    std::vector<ItemBounds> items;
    for (int i = 0; i < 240; ++i) {
        const float x = std::ldexp(1.0f, i - 120);
        for (int k = 0; k < 4; ++k) {
            items.push_back({{glm::vec3{x}, glm::vec3{x * (1.0f + 0.01f * static_cast<float>(k))}},
                             1u << (k * 8)});
        }
    }
    const Hierarchy tree = build_bvh(items, kOneEach);
    expect_good(tree, items, 1);
    EXPECT_LE(depth(tree), 64u + 12u);
}

TEST(BvhBuilder, UnboundedBoxesGetALeafOfTheirOwnBelowTheRoot)
{
    std::vector<ItemBounds> items = random_items(1000, 11);
    items[7].box.max.x = kInf;
    items[500].box = Aabb::everything();
    items[999].box.min.z = kNan;
    const Hierarchy tree = build_bvh(items, kOneEach);
    expect_good(tree, items, 1);
    const NodeId leaf = leaf_of(tree, 7);
    EXPECT_EQ(tree.node(leaf).parent, tree.root());
    EXPECT_EQ(tree.node(leaf).own_items, 3u);
    EXPECT_EQ(leaf_of(tree, 500), leaf);
    EXPECT_EQ(leaf_of(tree, 999), leaf);
    // The rest keeps its bounds.
    EXPECT_TRUE(tree.nodes()[1].box.is_bounded());
    EXPECT_EQ(tree.nodes()[1].subtree_items, 997u);
}

TEST(BvhBuilder, EmptyBoxesGetALeafThatNoFrustumMeets)
{
    std::vector<ItemBounds> items = random_items(1000, 12);
    for (ItemBounds& item : items) {
        item.triangles = 1;
    }
    items[3].box = Aabb::empty();
    items[4].box.max.y = items[4].box.min.y - 1.0f;
    // Also where the whole scene would fit into one virtual leaf.
    const Hierarchy tree = build_bvh(items, {.max_leaf_items = 1, .leaf_triangles = 1000000});
    expect_good(tree, items, 1);
    const NodeId leaf = leaf_of(tree, 3);
    EXPECT_EQ(leaf_of(tree, 4), leaf);
    EXPECT_TRUE(tree.node(leaf).box.is_empty());
    EXPECT_FALSE(tree.is_leaf(tree.root()));
    EXPECT_TRUE(tree.is_leaf(NodeId{1u}));
}

TEST(BvhBuilder, OneKindOfOddBoxesMakesOneLeaf)
{
    for (const Aabb& box :
         {Aabb::everything(), Aabb::empty(), Aabb{glm::vec3{kNan}, glm::vec3{kNan}}}) {
        const std::vector<ItemBounds> items(10, ItemBounds{box, 5});
        const Hierarchy tree = build_bvh(items, kOneEach);
        expect_good(tree, items, 1);
        EXPECT_EQ(tree.nodes().size(), 1u);
    }
    std::vector<ItemBounds> mixed(2, ItemBounds{Aabb::empty(), 1});
    mixed[0].box = Aabb::everything();
    const Hierarchy tree = build_bvh(mixed, kOneEach);
    expect_good(tree, mixed, 1);
    EXPECT_EQ(tree.nodes().size(), 3u);
}

TEST(BvhBuilder, VirtualLeavesHoldAtMostTheGivenTriangles)
{
    const std::vector<ItemBounds> items = random_items(5000, 13);
    const Hierarchy tree = build_bvh(items, {.max_leaf_items = 1, .leaf_triangles = 4096});
    uint32_t covered = 0;
    uint32_t inner = 0;
    for (uint32_t n = 1; n < tree.nodes().size(); ++n) {
        const Node& node = tree.node(NodeId{n});
        const Node& parent = tree.node(node.parent);
        if (node.subtree_triangles <= 4096 && parent.subtree_triangles > 4096) {
            EXPECT_TRUE(tree.is_leaf(NodeId{n}));
            covered += node.subtree_items;
            inner += node.child_count > 0 ? 1 : 0;
        } else {
            EXPECT_EQ(tree.is_leaf(NodeId{n}), node.child_count == 0);
        }
    }
    EXPECT_EQ(covered, items.size());
    EXPECT_GT(inner, 100u);
}

TEST(BvhBuilder, ItemsInALeafAreInTheOrderOfTheirIds)
{
    const Hierarchy tree = build_bvh(random_items(1000, 14), {.max_leaf_items = 8});
    for (uint32_t n = 0; n < tree.nodes().size(); ++n) {
        EXPECT_TRUE(std::ranges::is_sorted(tree.own_items(NodeId{n})));
    }
}

TEST(BvhBuilder, TreeOrderKeepsNeighboursTogether)
{
    // The mean step from item to item in tree order, beside the same in the given (random) order.
    const std::vector<ItemBounds> items = random_items(5000, 15);
    const Hierarchy tree = build_bvh(items, kOneEach);
    double in_tree = 0.0;
    double given = 0.0;
    for (size_t i = 1; i < items.size(); ++i) {
        in_tree += glm::length(tree.item_bounds()[i].box.center() -
                               tree.item_bounds()[i - 1].box.center());
        given += glm::length(items[i].box.center() - items[i - 1].box.center());
    }
    EXPECT_LT(in_tree, given / 5.0);
}

} // namespace
} // namespace occlude
