#include <occlude/hierarchy/builders/grid_builder.h>
#include <occlude/hierarchy/builders/octree_builder.h>

#include "hierarchy/scenes.h"

#include <occlude/hierarchy/builders/hierarchy_kinds.h>
#include <occlude/hierarchy/lattice.h>

#include <gtest/gtest.h>

#include <cfloat>
#include <set>

namespace occlude {
namespace {

using test::kInf;
using test::kNan;
using test::random_items;
using test::same_tree;

// A unit cube around (x, y, z).
ItemBounds cube(float x, float y, float z, uint32_t triangles = 1)
{
    const glm::vec3 center{x, y, z};
    return {{center - 0.5f, center + 0.5f}, triangles};
}

std::vector<uint32_t> subtree(const Hierarchy& tree, uint32_t node)
{
    std::vector<uint32_t> ids;
    for (const ItemId item : tree.subtree_items(NodeId{node})) {
        ids.push_back(item.value);
    }
    return ids;
}

// Valid, every item once, leaves no larger than allowed unless no plane separates their centres.
void expect_good(const Hierarchy& tree, std::span<const ItemBounds> items, uint32_t max_leaf_items)
{
    ASSERT_EQ(validate(tree), "");
    ASSERT_EQ(tree.items().size(), items.size());
    std::set<uint32_t> seen;
    for (size_t i = 0; i < items.size(); ++i) {
        seen.insert(tree.items()[i].value);
        ASSERT_EQ(tree.item_bounds()[i].box, sanitized(items[tree.items()[i].value].box));
    }
    ASSERT_EQ(seen.size(), items.size());
    for (size_t n = 0; n < tree.nodes().size(); ++n) {
        const Node& node = tree.nodes()[n];
        ASSERT_TRUE(n == 0 || node.child_count == 0 || node.own_items == 0);
        ASSERT_NE(node.child_count, n == 0 && node.own_items > 0 ? 2u : 1u);
        if (n > 0 && node.child_count == 0 && node.own_items > max_leaf_items) {
            Aabb centers;
            for (const ItemId item : tree.own_items(NodeId{n})) {
                const glm::vec3 center = items[item.value].box.center();
                centers = merge(centers, {center, center});
            }
            ASSERT_LE(glm::length(centers.extent()), 1e-3f);
        }
    }
}

TEST(OctreeBuilder, ItemsAreInTheOctantOfTheirCentre)
{
    // Two items near the low corner, one in each of two other octants.
    const std::vector<ItemBounds> items{cube(9, 1, 1), cube(0, 0, 0), cube(8, 8, 9), cube(2, 0, 0)};
    const Hierarchy tree = build_octree(items, {.leaf_triangles = 0});
    expect_good(tree, items, 1);
    ASSERT_EQ(tree.nodes().size(), 6u); // root, three octants, two in the first of them
    EXPECT_EQ(tree.node(tree.root()).child_count, 3u);
    EXPECT_EQ(subtree(tree, 1), (std::vector<uint32_t>{1, 3}));
    EXPECT_EQ(subtree(tree, 2), std::vector<uint32_t>{0});
    EXPECT_EQ(subtree(tree, 3), std::vector<uint32_t>{2});
    EXPECT_EQ(tree.nodes()[1].box, merge(items[1].box, items[3].box));
}

TEST(OctreeBuilder, TwoItemsCloseTogetherNeedOneNodeNotTwenty)
{
    const std::vector<ItemBounds> items{cube(0, 0, 0), cube(0.01f, 0, 0), cube(1000, 0, 0)};
    const Hierarchy tree = build_octree(items, {.leaf_triangles = 0});
    expect_good(tree, items, 1);
    EXPECT_EQ(tree.nodes().size(), 5u);
}

TEST(OctreeBuilder, TheDepthLimitMakesLargerLeaves)
{
    const std::vector<ItemBounds> items = random_items(1000, 3);
    const Hierarchy tree = build_octree(items, {.max_depth = 2, .leaf_triangles = 0});
    ASSERT_EQ(validate(tree), "");
    EXPECT_EQ(tree.nodes().size(), 1u + 8u + 64u); // 1000 items leave no octant empty.
    EXPECT_EQ(build_octree(items, {.max_depth = 0}).nodes().size(), 1u);
}

TEST(GridBuilder, OccupiedCellsAreChildrenOfTheRoot)
{
    // Centres from 0 to 15, four cells asked for: 3.75 wide.
    std::vector<ItemBounds> items;
    for (int i = 0; i < 16; ++i) {
        items.push_back(cube(static_cast<float>(i), 0, 0));
    }
    const Hierarchy tree =
        build_grid(items, {.items_per_cell = 4, .max_leaf_items = 4, .leaf_triangles = 0});
    expect_good(tree, items, 4);
    EXPECT_EQ(tree.node(tree.root()).child_count, 4u);
    EXPECT_EQ(tree.nodes().size(), 5u);
    EXPECT_EQ(subtree(tree, 1), (std::vector<uint32_t>{0, 1, 2, 3}));
}

TEST(GridBuilder, AFullCellIsAGridAgain)
{
    std::vector<ItemBounds> items;
    for (int i = 0; i < 64; ++i) { // 64 in one corner
        items.push_back(
            cube(0.1f * static_cast<float>(i % 8), 0, 0.1f * static_cast<float>(i / 8)));
    }
    items.push_back(cube(100, 0, 0));
    const Hierarchy tree = build_grid(items, {.leaf_triangles = 0});
    expect_good(tree, items, 1);
    EXPECT_EQ(tree.node(tree.root()).child_count, 2u);
    EXPECT_EQ(tree.nodes()[1].subtree_items, 64u);
    EXPECT_GE(tree.nodes()[1].child_count, 8u);
    const Hierarchy flat = build_grid(items, {.max_depth = 1, .leaf_triangles = 0});
    EXPECT_EQ(flat.nodes().size(), 3u);
}

TEST(Lattice, CellsFillTheBoxAndFlatAxesHaveOne)
{
    const Lattice lattice = Lattice::over({{0, 0, 0}, {8, 0, 4}}, 32);
    EXPECT_EQ(lattice.count.y, 1u);
    EXPECT_GE(lattice.cell_count(), 32u);
    EXPECT_LE(lattice.cell_count(), 60u);
    EXPECT_DOUBLE_EQ(lattice.cell_size.x * lattice.count.x, 8.0);
    EXPECT_EQ(lattice.cell({0, 0, 0}), (glm::uvec3{0, 0, 0}));
    EXPECT_EQ(lattice.cell({8, 0, 4}), lattice.count - 1u);
    EXPECT_EQ(lattice.cell({-5, 90, 2}).x, 0u); // outside: the nearest
    EXPECT_EQ(Lattice::over({{3, 3, 3}, {3, 3, 3}}, 100).cell_count(), 1u);
    EXPECT_LE(Lattice::over({{0, 0, 0}, {1, 0, 0}}, 1u << 20).count.x, Lattice::kMaxPerAxis);
    const float huge = FLT_MAX;
    EXPECT_GE(Lattice::over({glm::vec3{-huge}, glm::vec3{huge}}, 100).cell_count(), 100u);
}

class CellTrees : public ::testing::TestWithParam<std::string> {
protected:
    Hierarchy build(std::span<const ItemBounds> items, uint32_t leaf_triangles = 0) const
    {
        return find_hierarchy_kind(GetParam())->build(items, leaf_triangles);
    }
};

TEST_P(CellTrees, OfRandomItemsAreValid)
{
    for (const size_t count : {0u, 1u, 2u, 3u, 17u, 1000u, 20000u}) {
        const std::vector<ItemBounds> items = random_items(count, count);
        expect_good(build(items), items, 1);
        EXPECT_EQ(build(items).empty(), count == 0);
    }
    const std::vector<ItemBounds> items = random_items(1000, 9);
    for (const uint32_t leaf_items : {1u, 3u, 50u}) {
        expect_good(build_octree(items, {.max_leaf_items = leaf_items}), items, leaf_items);
        expect_good(build_grid(items, {.max_leaf_items = leaf_items}), items, leaf_items);
    }
}

TEST_P(CellTrees, AreTheSameForTheSameItems)
{
    const std::vector<ItemBounds> items = random_items(3000, 5);
    EXPECT_TRUE(same_tree(build(items, 4096), build(items, 4096)));
}

TEST_P(CellTrees, DegenerateItemsAreHarmless)
{
    std::vector<ItemBounds> items = random_items(200, 6);
    items[3].box.min.x = kNan;
    items[4].box = Aabb::everything();
    items[5].box = Aabb::empty();
    items[6].box.max = items[6].box.min;
    items[7].box = {glm::vec3{-FLT_MAX}, glm::vec3{FLT_MAX}};
    items[8].box.max.z = kInf;
    for (size_t i = 20; i < 120; ++i) {
        items[i].box = items[19].box; // in one place
    }
    const Hierarchy tree = build(items);
    expect_good(tree, items, 1);
    EXPECT_EQ(subtree(tree, 0)[0], 3u); // items that no cell can hold are the root's own
    EXPECT_EQ(tree.node(tree.root()).own_items, 4u);
    for (const size_t only : {4u, 5u}) {
        const std::vector<ItemBounds> one{items[only]};
        expect_good(build(one), one, 1);
    }
}

TEST_P(CellTrees, ItemsInALineOrPlaneArePartedToo)
{
    for (const int axes : {1, 2}) {
        std::vector<ItemBounds> items = random_items(500, 7);
        for (ItemBounds& item : items) {
            for (int axis = axes; axis < 3; ++axis) {
                item.box.min[axis] = item.box.max[axis] = 5.0f;
            }
        }
        const Hierarchy tree = build(items);
        expect_good(tree, items, 1);
        EXPECT_GT(tree.nodes().size(), items.size());
    }
}

TEST_P(CellTrees, VirtualLeavesHaveAtMostTheTrianglesAskedFor)
{
    const std::vector<ItemBounds> items = random_items(2000, 8);
    const Hierarchy tree = build(items, 4000);
    ASSERT_EQ(validate(tree), "");
    size_t leaves = 0;
    for (const Node& node : tree.nodes()) {
        if (node.leaf != 0 && node.child_count > 0) {
            EXPECT_LE(node.subtree_triangles, 4000u);
            ++leaves;
        }
    }
    EXPECT_GT(leaves, 100u);
}

INSTANTIATE_TEST_SUITE_P(Hierarchy, CellTrees, ::testing::Values("octree", "grid"),
                         [](const auto& info) { return info.param; });

} // namespace
} // namespace occlude
