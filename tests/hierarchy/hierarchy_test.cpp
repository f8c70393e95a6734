#include <occlude/hierarchy/hierarchy.h>

#include <occlude/core/assert.h>
#include <occlude/hierarchy/builders/bvh_builder.h>

#include "hierarchy/scenes.h"

#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>

namespace occlude {
namespace {

using test::kInf;
using test::kNan;
using test::random_items;

ItemBounds unit_item(float x, uint32_t triangles)
{
    return {{glm::vec3{x, 0.0f, 0.0f}, glm::vec3{x + 1.0f, 1.0f, 1.0f}}, triangles};
}

/// The layout of the header's picture, with an item in an inner node:
///
///   0 (item 5) ── 1 (items 3, 4)
///              └─ 2 ── 3 (item 0)
///                   ├─ 4 (item 1)
///                   └─ 5 (item 2)
///
/// Item i covers x in [i, i + 1] and has 10^i triangles.
struct Parts {
    std::vector<Node> nodes = std::vector<Node>(6);
    std::vector<ItemId> items;
    std::vector<ItemBounds> bounds;

    Parts()
    {
        for (const uint32_t i : {5u, 3u, 4u, 0u, 1u, 2u}) {
            items.push_back(ItemId{i});
            uint32_t triangles = 1;
            for (uint32_t k = 0; k < i; ++k) {
                triangles *= 10;
            }
            bounds.push_back(unit_item(static_cast<float>(i), triangles));
        }
        shape(0, 0, 1, 1, 2);
        shape(1, 1, 2, 0, 0);
        shape(2, 3, 0, 3, 3);
        shape(3, 3, 1, 0, 0);
        shape(4, 4, 1, 0, 0);
        shape(5, 5, 1, 0, 0);
    }
    void shape(size_t node, uint32_t first_item, uint32_t own, uint32_t first_child,
               uint32_t children)
    {
        nodes[node].first_item = first_item;
        nodes[node].own_items = own;
        nodes[node].first_child = children > 0 ? NodeId{first_child} : NodeId{};
        nodes[node].child_count = children;
    }
    Hierarchy build() const { return Hierarchy::from_arrays(nodes, items, bounds); }
};

/// The bounds of Parts, indexed by ItemId.
std::vector<ItemBounds> by_item(const Hierarchy& tree)
{
    std::vector<ItemBounds> result(tree.items().size());
    for (size_t i = 0; i < result.size(); ++i) {
        result[tree.items()[i].value] = tree.item_bounds()[i];
    }
    return result;
}

TEST(Hierarchy, NoNodesMakeAnEmptyHierarchy)
{
    const Hierarchy tree = Hierarchy::from_arrays({}, {}, {});
    EXPECT_TRUE(tree.empty());
    EXPECT_EQ(validate(tree), "");
    EXPECT_EQ(validate(Hierarchy{}), "");
    EXPECT_EQ(sah_cost(tree), 0.0);
}

TEST(Hierarchy, FromArraysDerivesParentsBoxesSumsAndLeaves)
{
    const Hierarchy tree = Parts{}.build();
    EXPECT_EQ(validate(tree), "");
    EXPECT_FALSE(tree.node(tree.root()).parent.valid());
    EXPECT_EQ(tree.node(NodeId{2u}).parent, NodeId{0u});
    EXPECT_EQ(tree.node(NodeId{5u}).parent, NodeId{2u});
    EXPECT_EQ(tree.node(NodeId{0u}).box, (Aabb{glm::vec3{0.0f}, glm::vec3{6.0f, 1.0f, 1.0f}}));
    EXPECT_EQ(tree.node(NodeId{2u}).box, (Aabb{glm::vec3{0.0f}, glm::vec3{3.0f, 1.0f, 1.0f}}));
    EXPECT_EQ(tree.node(NodeId{0u}).subtree_items, 6u);
    EXPECT_EQ(tree.node(NodeId{0u}).subtree_triangles, 111111u);
    EXPECT_EQ(tree.node(NodeId{1u}).subtree_triangles, 11000u);
    EXPECT_EQ(tree.node(NodeId{2u}).subtree_triangles, 111u);
    EXPECT_FALSE(tree.is_leaf(NodeId{0u}));
    EXPECT_TRUE(tree.is_leaf(NodeId{1u}));
    EXPECT_FALSE(tree.is_leaf(NodeId{2u}));
}

TEST(Hierarchy, ItemsOfASubtreeAreContiguous)
{
    const Hierarchy tree = Parts{}.build();
    ASSERT_EQ(tree.own_items(NodeId{0u}).size(), 1u);
    EXPECT_EQ(tree.own_items(NodeId{0u})[0], ItemId{5u});
    ASSERT_EQ(tree.subtree_items(NodeId{2u}).size(), 3u);
    EXPECT_EQ(tree.subtree_items(NodeId{2u})[0], ItemId{0u});
    EXPECT_EQ(tree.subtree_items(NodeId{2u})[2], ItemId{2u});
    EXPECT_EQ(tree.subtree_items(tree.root()).size(), 6u);
}

TEST(Hierarchy, NanBoxesBecomeEverything)
{
    Parts parts;
    parts.bounds[4].box.min.y = kNan;
    const Hierarchy tree = parts.build();
    EXPECT_EQ(validate(tree), "");
    EXPECT_EQ(tree.item_bounds()[4].box, Aabb::everything());
    EXPECT_EQ(tree.node(NodeId{2u}).box, Aabb::everything());
    EXPECT_TRUE(tree.node(NodeId{1u}).box.is_bounded());
}

TEST(Hierarchy, TriangleCountsStopAtTheLargestNumber)
{
    Parts parts;
    parts.bounds[0].triangles = 4000000000u;
    parts.bounds[1].triangles = 4000000000u;
    const Hierarchy tree = parts.build();
    EXPECT_EQ(tree.node(tree.root()).subtree_triangles, 0xffffffffu);
    EXPECT_EQ(validate(tree), "");
}

TEST(Hierarchy, VirtualLeavesAreTheTopmostNodesThatAreSmallEnough)
{
    Hierarchy tree = Parts{}.build();
    tree.set_virtual_leaves(110);
    EXPECT_FALSE(tree.is_leaf(NodeId{2u}));
    tree.set_virtual_leaves(111);
    EXPECT_TRUE(tree.is_leaf(NodeId{2u}));
    EXPECT_FALSE(tree.is_leaf(NodeId{0u}));
    EXPECT_EQ(validate(tree), "");
    tree.set_virtual_leaves(111111);
    EXPECT_TRUE(tree.is_leaf(NodeId{0u}));
    EXPECT_FALSE(tree.is_leaf(NodeId{2u})); // its parent is one already
    EXPECT_EQ(validate(tree), "");
}

TEST(Hierarchy, ZeroTrianglesLeavesOnlyTheRealLeaves)
{
    Parts parts;
    for (ItemBounds& item : parts.bounds) {
        item.triangles = 0;
    }
    Hierarchy tree = parts.build();
    tree.set_virtual_leaves(10);
    EXPECT_TRUE(tree.is_leaf(tree.root()));
    tree.set_virtual_leaves(0);
    for (uint32_t i = 0; i < 6; ++i) {
        EXPECT_EQ(tree.is_leaf(NodeId{i}), i != 0 && i != 2);
    }
}

TEST(Hierarchy, UnboundedAndEmptyChildrenAreKeptOutOfVirtualLeaves)
{
    Parts unbounded;
    unbounded.bounds[3].box.max.x = kInf;
    Hierarchy tree = unbounded.build();
    tree.set_virtual_leaves(1000000);
    EXPECT_FALSE(tree.is_leaf(NodeId{0u}));
    EXPECT_FALSE(tree.is_leaf(NodeId{2u}));

    Parts empty;
    empty.bounds[3].box = Aabb::empty();
    tree = empty.build();
    tree.set_virtual_leaves(111);
    EXPECT_FALSE(tree.is_leaf(NodeId{2u}));
    EXPECT_EQ(validate(tree), "");
}

TEST(Hierarchy, StructureVersionChangesWithTheStructureOnly)
{
    Hierarchy tree = Parts{}.build();
    const Hierarchy copy = tree;
    EXPECT_EQ(copy.structure_version(), tree.structure_version());
    tree.refit(by_item(tree));
    EXPECT_EQ(copy.structure_version(), tree.structure_version());
    tree.set_virtual_leaves(111);
    EXPECT_NE(copy.structure_version(), tree.structure_version());
    EXPECT_NE(Parts{}.build().structure_version(), Parts{}.build().structure_version());
    EXPECT_NE(Parts{}.build().structure_version(), Hierarchy{}.structure_version());
}

TEST(Hierarchy, RefitTakesNewBoxesCountsAndFlagsByItemIdAndKeepsTheStructure)
{
    Hierarchy tree = Parts{}.build();
    tree.set_virtual_leaves(111);
    std::vector<ItemBounds> moved = by_item(tree);
    moved[2].box = {glm::vec3{50.0f}, glm::vec3{51.0f}};
    moved[2].triangles = 77; // the id now belongs to another object
    moved[2].flags = ItemFlags::translucent;
    moved[3].box = Aabb::empty();
    moved[4].box.max.z = kNan;
    tree.refit(moved);
    EXPECT_EQ(validate(tree), "");
    EXPECT_EQ(tree.node(NodeId{5u}).box, moved[2].box);
    EXPECT_EQ(tree.node(NodeId{2u}).box, (Aabb{glm::vec3{0.0f}, glm::vec3{51.0f}}));
    EXPECT_EQ(tree.node(NodeId{1u}).box, Aabb::everything());
    EXPECT_EQ(tree.node(NodeId{5u}).subtree_triangles, 77u);
    ASSERT_EQ(tree.flagged_items().size(), 1u);
    EXPECT_EQ(tree.flagged_items()[0].item, ItemId{2u});
    EXPECT_EQ(tree.item(tree.flagged_items()[0].position), ItemId{2u});
    EXPECT_TRUE(tree.is_leaf(NodeId{2u}));
}

TEST(Hierarchy, RefitShrinksAsWellAsGrows)
{
    const std::vector<ItemBounds> items = random_items(3000, 5);
    Hierarchy tree = build_bvh(items);
    std::vector<ItemBounds> moved = random_items(3000, 6);
    tree.refit(moved);
    EXPECT_EQ(validate(tree), "");
    EXPECT_GT(sah_cost(tree), 5.0 * sah_cost(build_bvh(moved))); // the order has changed
    tree.refit(items);
    EXPECT_TRUE(test::same_tree(tree, build_bvh(items)));
}

/// `tree` with node `id` changed without its knowledge.
std::string damaged(const std::function<void(Node&)>& damage, uint32_t id, Hierarchy tree)
{
    damage(const_cast<Node&>(tree.node(NodeId{id})));
    return validate(tree);
}

TEST(Hierarchy, ValidateNamesEveryKindOfDamage)
{
    struct Damage {
        uint32_t node;
        std::function<void(Node&)> change;
        const char* sentence;
    };
    const std::vector<Damage> damages{
        {0, [](Node& n) { n.parent = NodeId{3u}; }, "node 0 is the root but has a parent"},
        {0, [](Node& n) { n.first_item = 1; }, "node 0 is the root but does not cover all items"},
        {0, [](Node& n) { n.subtree_items = 5; },
         "node 0 is the root but does not cover all items"},
        {4, [](Node& n) { n.parent = NodeId{4u}; }, "node 4 does not name its parent"},
        {4, [](Node& n) { n.parent = NodeId{}; }, "node 4 does not name its parent"},
        {1, [](Node& n) { n.parent = NodeId{1u}; }, "node 1 does not name its parent"},
        {2, [](Node& n) { n.child_count = 2; }, "node 2 does not count the items of its subtree"},
        {2, [](Node& n) { n.child_count = 4; },
         "node 2 has children outside of the nodes after it"},
        {2, [](Node& n) { n.first_child = NodeId{2u}; },
         "node 2 has children outside of the nodes after it"},
        {2, [](Node& n) { n.first_child = NodeId{}; },
         "node 2 has children outside of the nodes after it"},
        {4, [](Node& n) { n.first_child = NodeId{5u}; },
         "node 4 names a first child but has no children"},
        {4, [](Node& n) { n.first_item = 3; },
         "node 4 does not begin where its sibling's or parent's items end"},
        {4, [](Node& n) { n.own_items = 2; }, "node 4 does not count the items of its subtree"},
        {4, [](Node& n) { n.subtree_items = 2; },
         "node 5 does not begin where its sibling's or parent's items end"},
        {2, [](Node& n) { n.box.max.x = 2.5f; },
         "node 2 does not have the box around its items and children"},
        {2, [](Node& n) { n.box.max.x = 3.5f; },
         "node 2 does not have the box around its items and children"},
        {2, [](Node& n) { n.box.max.x = kNan; },
         "node 0 does not have the box around its items and children"},
        {1, [](Node& n) { n.subtree_triangles = 1; },
         "node 0 does not count the triangles of its subtree"},
        {0, [](Node& n) { n.subtree_triangles = 1; },
         "node 0 does not count the triangles of its subtree"},
        {5, [](Node& n) { n.leaf = 0; }, "node 5 has no children but is not a leaf"},
        {2, [](Node& n) { n.leaf = 2; }, "node 2 has a leaf mark that is neither 0 nor 1"},
    };
    for (const Damage& damage : damages) {
        EXPECT_EQ(damaged(damage.change, damage.node, Parts{}.build()), damage.sentence);
    }
}

TEST(Hierarchy, ValidateFindsANodeWithoutItemsThatItsParentForgot)
{
    Parts parts; // a seventh node, child of node 2, without items
    parts.nodes.emplace_back();
    parts.shape(6, 6, 0, 0, 0);
    parts.nodes[2].child_count = 4;
    const Hierarchy tree = parts.build();
    EXPECT_EQ(validate(tree), "");
    EXPECT_EQ(damaged([](Node& n) { n.child_count = 3; }, 2, tree),
              "node 6 is not among the children of its parent");
    Hierarchy orphan = tree;
    const_cast<Node&>(orphan.node(NodeId{6u})).parent = NodeId{};
    EXPECT_EQ(damaged([](Node& n) { n.child_count = 3; }, 2, orphan),
              "node 6 does not come after its parent");
}

TEST(Hierarchy, ValidateFindsAVirtualLeafBelowAVirtualLeaf)
{
    Hierarchy tree = Parts{}.build();
    tree.set_virtual_leaves(111111);
    EXPECT_EQ(damaged([](Node& n) { n.leaf = 1; }, 2, tree),
              "node 2 is a virtual leaf below a virtual leaf");
}

TEST(Hierarchy, ValidateFindsDamagedItems)
{
    const auto damaged_items = [](const std::function<void(Hierarchy&)>& damage) {
        Hierarchy tree = Parts{}.build();
        damage(tree);
        return validate(tree);
    };
    EXPECT_EQ(damaged_items([](Hierarchy& t) { const_cast<ItemId&>(t.items()[0]) = ItemId{2u}; }),
              "item 2 is in the tree more than once");
    EXPECT_EQ(damaged_items([](Hierarchy& t) { const_cast<ItemId&>(t.items()[0]) = ItemId{}; }),
              "an item id is invalid");
    EXPECT_EQ(damaged_items([](Hierarchy& t) {
                  const_cast<ItemBounds&>(t.item_bounds()[3]).box.min.x = kNan;
              }),
              "the box of item 0 is NaN");
    EXPECT_EQ(damaged_items([](Hierarchy& t) {
                  const_cast<ItemBounds&>(t.item_bounds()[3]).box.max.x = 1.5f;
              }),
              "node 3 does not have the box around its items and children");
}

TEST(Hierarchy, SahCostIsTheSumOverNodesOfRelativeAreas)
{
    const Hierarchy tree = Parts{}.build();
    // Areas of 1x1xn bars: 2 + 4n. Root 26, node 1: 10, node 2: 14, its leaves: 6 each.
    const double expected = (26.0 * 2 + 10.0 * 2 + 14.0 * 1 + 3 * 6.0) / 26.0;
    EXPECT_NEAR(sah_cost(tree), expected, 1e-12);
}

TEST(Hierarchy, SahCostIsFiniteForOddBoxes)
{
    Parts parts;
    parts.bounds[0].box = Aabb::everything();
    parts.bounds[1].box = Aabb::empty();
    EXPECT_TRUE(std::isfinite(sah_cost(parts.build())));
    for (ItemBounds& item : parts.bounds) {
        item.box = {glm::vec3{1.0f}, glm::vec3{1.0f}};
    }
    EXPECT_EQ(sah_cost(parts.build()), 2.0 + 2.0 + 1.0 + 3.0);
}

#if OCCLUDE_ASSERTS
TEST(Hierarchy, BrokenLayoutIsACallersBug)
{
    const AssertHandler before =
        set_assert_handler([](std::string_view, std::string_view message, std::string_view, int) {
            throw std::logic_error(std::string(message));
        });
    Parts far_child;
    far_child.nodes[2].first_child = NodeId{1000u};
    EXPECT_THROW(far_child.build(), std::logic_error);
    Parts overlapping;
    overlapping.nodes[4].first_item = 3;
    EXPECT_THROW(overlapping.build(), std::logic_error);
    Parts orphan;
    orphan.nodes.emplace_back();
    EXPECT_THROW(orphan.build(), std::logic_error);
    Hierarchy tree = Parts{}.build();
    EXPECT_THROW(tree.refit({}), std::logic_error);
    set_assert_handler(before);
}
#else
TEST(Hierarchy, ItemsWithoutNewBoundsBecomeUnbounded)
{
    Hierarchy tree = Parts{}.build();
    std::vector<ItemBounds> too_few = by_item(tree);
    too_few.pop_back();
    tree.refit(too_few);
    EXPECT_EQ(validate(tree), "");
    EXPECT_EQ(tree.node(tree.root()).box, Aabb::everything());
    EXPECT_TRUE(tree.node(NodeId{2u}).box.is_bounded());
}
#endif

} // namespace
} // namespace occlude
