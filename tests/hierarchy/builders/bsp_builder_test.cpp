#include <occlude/hierarchy/builders/bsp_builder.h>

#include "hierarchy/scenes.h"

#include <occlude/hierarchy/builders/bvh_builder.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include <gtest/gtest.h>

#include <cfloat>
#include <set>

namespace occlude {
namespace {

using test::kInf;
using test::kNan;
using test::random_items;

// A box from (low, 0, 0) to (high, 1, 1).
ItemBounds on_x(float low, float high, uint32_t triangles = 1)
{
    return {{{low, 0.0f, 0.0f}, {high, 1.0f, 1.0f}}, triangles};
}

std::vector<uint32_t> own(const Hierarchy& tree, uint32_t node)
{
    std::vector<uint32_t> ids;
    for (const ItemId item : tree.own_items(NodeId{node})) {
        ids.push_back(item.value);
    }
    return ids;
}

void expect_apart(const Aabb& low, const Aabb& high)
{
    bool apart = false;
    for (int axis = 0; axis < 3; ++axis) {
        apart = apart || low.max[axis] <= high.min[axis];
    }
    ASSERT_TRUE(apart);
}

// Valid, every item once.
void expect_valid(const Hierarchy& tree, std::span<const ItemBounds> items)
{
    ASSERT_EQ(validate(tree), "");
    ASSERT_EQ(tree.items().size(), items.size());
    std::set<uint32_t> seen;
    for (size_t i = 0; i < items.size(); ++i) {
        seen.insert(tree.items()[i].value);
        ASSERT_EQ(tree.item_bounds()[i].box, sanitized(items[tree.items()[i].value].box));
    }
    ASSERT_EQ(seen.size(), items.size());
}

// Siblings are apart: some axis has a plane between them.
void expect_good(const Hierarchy& tree, std::span<const ItemBounds> items)
{
    expect_valid(tree, items);
    for (const Node& node : tree.nodes()) {
        ASSERT_LE(node.child_count, 2u);
        if (node.child_count == 2) {
            expect_apart(tree.nodes()[node.first_child.value].box,
                         tree.nodes()[node.first_child.value + 1].box);
        }
    }
}

TEST(BspBuilder, AnItemThatStraddlesThePlaneStaysInTheNode)
{
    //   0: [0 1]   1: [2 3]   2: [4 5]   3: [6 7], and 4: [2.5 4.5] across the middle
    const std::vector<ItemBounds> items{on_x(0, 1), on_x(2, 3), on_x(4, 5), on_x(6, 7),
                                        on_x(2.5f, 4.5f)};
    const Hierarchy tree =
        build_bsp(items, {.split = BspOptions::Split::middle, .leaf_triangles = 0});
    expect_good(tree, items);
    // The plane of the root is x = 3.5, those of its children are x = 1.5 and x = 5.5.
    ASSERT_EQ(tree.nodes().size(), 7u);
    EXPECT_EQ(own(tree, 0), std::vector<uint32_t>{4});
    EXPECT_EQ(tree.nodes()[1].box, merge(items[0].box, items[1].box));
    EXPECT_EQ(tree.nodes()[2].box, merge(items[2].box, items[3].box));
    EXPECT_EQ(tree.nodes()[0].box, merge(items[0].box, items[3].box));
    std::vector<uint32_t> leaves;
    for (uint32_t node = 3; node < 7; ++node) {
        leaves.push_back(own(tree, node)[0]);
    }
    EXPECT_EQ(leaves, (std::vector<uint32_t>{0, 1, 2, 3}));
}

TEST(BspBuilder, ItemsThatStraddleThePlaneCanHaveANodeOfTheirOwn)
{
    // Two items across the first plane, x = 3.5, one above the other: a plane across y parts them.
    std::vector<ItemBounds> items{on_x(0, 1), on_x(2, 3), on_x(4, 5),
                                  on_x(6, 7), on_x(3, 4), on_x(3, 4)};
    items[5].box.min.y = 4.0f;
    items[5].box.max.y = 5.0f;
    const Hierarchy tree = build_bsp(items, {.split = BspOptions::Split::middle,
                                             .straddling = BspOptions::Straddling::child,
                                             .leaf_triangles = 0});
    expect_valid(tree, items);
    EXPECT_TRUE(own(tree, 0).empty());
    ASSERT_EQ(tree.nodes()[0].child_count, 3u);
    EXPECT_EQ(tree.nodes()[1].box, merge(items[4].box, items[5].box));
    EXPECT_EQ(tree.nodes()[2].box, merge(items[0].box, items[1].box));
    EXPECT_EQ(tree.nodes()[3].box, merge(items[2].box, items[3].box));
    EXPECT_EQ(tree.nodes()[1].child_count, 2u);
    for (const Node& node : tree.nodes()) {
        EXPECT_EQ(node.own_items, node.child_count > 0 ? 0u : 1u);
    }
}

TEST(BspBuilder, WithThreeChildrenRandomBoxesMakeGoodTreesToo)
{
    const std::vector<ItemBounds> items = random_items(3000, 11);
    for (const auto split :
         {BspOptions::Split::cost, BspOptions::Split::middle, BspOptions::Split::median}) {
        const auto tree_with = [&](BspOptions::Straddling straddling) {
            return build_bsp(items,
                             {.split = split, .straddling = straddling, .leaf_triangles = 0});
        };
        const Hierarchy tree = tree_with(BspOptions::Straddling::child);
        expect_valid(tree, items);
        size_t with_three = 0;
        for (const Node& node : tree.nodes()) {
            EXPECT_TRUE(node.child_count == 0 || node.own_items == 0);
            if (node.child_count == 3) {
                ++with_three;
                expect_apart(tree.nodes()[node.first_child.value + 1].box,
                             tree.nodes()[node.first_child.value + 2].box);
            }
        }
        EXPECT_GT(with_three, items.size() / 100);
        EXPECT_LT(sah_cost(tree), sah_cost(tree_with(BspOptions::Straddling::own)));
    }
}

TEST(BspBuilder, TheCostKeepsTheHeavyItemOffThePlane)
{
    // The middle, x = 4, would cut the heavy item in two; x = 2 separates it from the others.
    const std::vector<ItemBounds> items{on_x(0, 1), on_x(1, 2), on_x(2, 8, 1000)};
    const Hierarchy tree = build_bsp(items, {.leaf_triangles = 0});
    expect_good(tree, items);
    EXPECT_TRUE(own(tree, 0).empty());
    EXPECT_EQ(own(tree, 2), std::vector<uint32_t>{2});
    const Hierarchy middle =
        build_bsp(items, {.split = BspOptions::Split::middle, .leaf_triangles = 0});
    expect_good(middle, items);
    EXPECT_EQ(own(middle, 0), std::vector<uint32_t>{2});
}

TEST(BspBuilder, ItemsThatNoPlanePartsShareALeaf)
{
    std::vector<ItemBounds> nested;
    for (int i = 0; i < 9; ++i) {
        const float half = 1.0f + static_cast<float>(i);
        nested.push_back({{glm::vec3{-half}, glm::vec3{half}}, 5});
    }
    const std::vector<ItemBounds> same(9, nested[0]);
    for (const auto split :
         {BspOptions::Split::cost, BspOptions::Split::middle, BspOptions::Split::median}) {
        const Hierarchy tree = build_bsp(same, {.split = split, .leaf_triangles = 0});
        expect_good(tree, same);
        EXPECT_EQ(tree.nodes().size(), 1u);
        expect_good(build_bsp(nested, {.split = split, .leaf_triangles = 0}), nested);
    }
    // The middle is within all of them.
    EXPECT_EQ(build_bsp(nested, {.split = BspOptions::Split::middle}).nodes().size(), 1u);
}

TEST(BspBuilder, FlatBoxesInThePlaneAreOnOneSideOnly)
{
    std::vector<ItemBounds> walls;
    for (int i = 0; i < 40; ++i) {
        const float x = static_cast<float>(i / 4);
        walls.push_back(on_x(x, x));
    }
    const Hierarchy tree = build_bsp(walls, {.max_leaf_items = 4, .leaf_triangles = 0});
    expect_good(tree, walls);
    EXPECT_EQ(tree.nodes().size(),
              19u); // ten leaves: no wall straddles a plane, none is apart from its cluster
}

TEST(BspBuilder, RandomBoxesMakeGoodTrees)
{
    const std::vector<ItemBounds> items = random_items(3000, 11);
    for (const auto split :
         {BspOptions::Split::cost, BspOptions::Split::middle, BspOptions::Split::median}) {
        const Hierarchy tree = build_bsp(items, {.split = split, .leaf_triangles = 0});
        expect_good(tree, items);
        // The case is representative: most items are below inner nodes, some in them.
        size_t in_inner_nodes = 0;
        for (const Node& node : tree.nodes()) {
            in_inner_nodes += node.child_count > 0 ? node.own_items : 0;
        }
        EXPECT_GT(in_inner_nodes, items.size() / 100);
        EXPECT_LT(in_inner_nodes, items.size() / 2);
    }
}

TEST(BspBuilder, ItsCostIsNearThatOfABvh)
{
    const std::vector<ItemBounds> items = random_items(3000, 12);
    const double bvh = sah_cost(build_bvh(items));
    const double by_cost = sah_cost(build_bsp(items));
    EXPECT_LT(by_cost, 2.0 * bvh);
    EXPECT_LT(by_cost, sah_cost(build_bsp(items, {.split = BspOptions::Split::middle})));
}

TEST(BspBuilder, TheOrderOfEqualInputDoesNotMatter)
{
    const std::vector<ItemBounds> items = random_items(500, 13);
    EXPECT_TRUE(test::same_tree(build_bsp(items), build_bsp(items)));
    // The boxes in reverse order give nodes with the same boxes.
    const std::vector<ItemBounds> reversed(items.rbegin(), items.rend());
    const Hierarchy a = build_bsp(items);
    const Hierarchy b = build_bsp(reversed);
    ASSERT_EQ(a.nodes().size(), b.nodes().size());
    for (size_t i = 0; i < a.nodes().size(); ++i) {
        EXPECT_EQ(a.nodes()[i].box, b.nodes()[i].box);
    }
}

TEST(BspBuilder, OddBoxesAreItemsOfTheRoot)
{
    std::vector<ItemBounds> items = random_items(50, 14);
    items[7].box = Aabb::everything();
    items[8].box.min.y = kNan;
    items[9].box = Aabb::empty();
    items[10].box.max.x = kInf;
    const Hierarchy tree = build_bsp(items, {.leaf_triangles = 0});
    expect_good(tree, items);
    EXPECT_EQ(own(tree, 0), (std::vector<uint32_t>{7, 8, 9, 10}));
    EXPECT_TRUE(tree.nodes()[1].box.is_bounded());
    for (const std::vector<ItemBounds>& few :
         {std::vector<ItemBounds>{}, {items[7]}, {items[9]}, {items[0]}, {items[9], items[0]}}) {
        expect_good(build_bsp(few), few);
    }
}

TEST(BspBuilder, HugeBoxesAndDepthsAreHarmless)
{
    std::vector<ItemBounds> items;
    for (int i = 0; i < 200; ++i) { // each twice as far as the last one: a long thin tree
        const float x = std::ldexp(1.0f, i - 100);
        items.push_back(on_x(x, 1.5f * x));
    }
    items.push_back({{glm::vec3{-FLT_MAX}, glm::vec3{FLT_MAX}}, 1});
    for (const auto split :
         {BspOptions::Split::cost, BspOptions::Split::middle, BspOptions::Split::median}) {
        expect_good(build_bsp(items, {.split = split, .max_depth = 1000, .leaf_triangles = 0}),
                    items);
    }
    const Hierarchy shallow = build_bsp(items, {.max_depth = 2, .leaf_triangles = 0});
    expect_good(shallow, items);
    EXPECT_LE(shallow.nodes().size(), 7u);
}

TEST(BspBuilder, NodesOfFewTrianglesAreVirtualLeaves)
{
    const std::vector<ItemBounds> items = random_items(500, 15);
    const Hierarchy tree = build_bsp(items, {.leaf_triangles = 5000});
    expect_good(tree, items);
    size_t virtual_leaves = 0;
    for (const Node& node : tree.nodes()) {
        virtual_leaves += node.leaf != 0 && node.child_count > 0 ? 1 : 0;
        EXPECT_TRUE(node.leaf == 0 || node.child_count == 0 || node.subtree_triangles <= 5000);
    }
    EXPECT_GT(virtual_leaves, 10u);
}

TEST(BspBuilder, RefittingKeepsItValid)
{
    std::vector<ItemBounds> items = random_items(300, 16);
    Hierarchy tree = build_bsp(items);
    for (ItemBounds& item : items) {
        item.box.min += 3.0f;
        item.box.max += 3.0f;
    }
    tree.refit(items);
    EXPECT_EQ(validate(tree), "");
}

TEST(HierarchyKinds, EveryKindBuildsAValidTreeWithVirtualLeaves)
{
    const std::vector<ItemBounds> items = random_items(300, 17);
    for (const HierarchyKind& kind : hierarchy_kinds()) {
        SCOPED_TRACE(kind.name);
        EXPECT_EQ(find_hierarchy_kind(kind.name), &kind);
        EXPECT_FALSE(kind.summary.empty());
        const Hierarchy deep = kind.build(items, 0);
        EXPECT_EQ(validate(deep), "");
        EXPECT_EQ(deep.items().size(), items.size());
        EXPECT_FALSE(deep.is_leaf(deep.root()));
        size_t in_inner_nodes = 0;
        for (uint32_t n = 0; n < deep.nodes().size(); ++n) {
            in_inner_nodes += deep.is_leaf(NodeId{n}) ? 0 : deep.own_items(NodeId{n}).size();
        }
        EXPECT_EQ(in_inner_nodes > 0, kind.items_in_inner_nodes);
        EXPECT_TRUE(kind.build(items, 1000000).is_leaf(NodeId{0u}));
        EXPECT_TRUE(kind.build({}, 0).empty());
        EXPECT_FALSE(kind.options().empty());
    }
    EXPECT_EQ(hierarchy_kinds().front().name, "bvh");
    EXPECT_EQ(find_hierarchy_kind("tree"), nullptr);
}

TEST(HierarchyKinds, OptionsAreSetByNameAndErrorsNameThem)
{
    const std::vector<ItemBounds> items = random_items(300, 17);
    const std::vector<OptionValue> shallow{{"max_depth", "1"}};
    for (const char* name : {"bsp", "octree", "grid"}) {
        const HierarchyKind& kind = *find_hierarchy_kind(name);
        const auto tree = kind.build_with(items, 0, shallow);
        ASSERT_TRUE(tree) << name;
        EXPECT_LT(tree->nodes().size(), kind.build(items, 0).nodes().size()) << name;
        const auto whole =
            kind.build_with(items, 0, std::vector<OptionValue>{{"leaf_triangles", "1000000"}});
        EXPECT_TRUE(whole->is_leaf(NodeId{0u})) << name;
    }
    for (const HierarchyKind& kind : hierarchy_kinds()) {
        const auto wrong = kind.build_with(items, 0, std::vector<OptionValue>{{"colour", "1"}});
        ASSERT_FALSE(wrong) << kind.name;
        EXPECT_NE(wrong.error().message.find("'colour'"), std::string::npos);
        for (const OptionInfo& option : kind.options()) {
            EXPECT_NE(wrong.error().message.find(option.name), std::string::npos) << kind.name;
        }
    }
    const auto options = two_level_options(
        7, std::vector<OptionValue>{{"rebuild_share", "0.25"}, {"quiet_frames", "3"}});
    ASSERT_TRUE(options);
    EXPECT_EQ(options->leaf_triangles, 7u);
    EXPECT_EQ(options->rebuild_share, 0.25f);
    EXPECT_EQ(options->quiet_frames, 3u);
}

} // namespace
} // namespace occlude
