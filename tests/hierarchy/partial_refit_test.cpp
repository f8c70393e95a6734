// Refits of only the moved items equal refits of all items bit for bit.
#include "hierarchy/scenes.h"

#include <occlude/hierarchy/builders/bvh_builder.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include <gtest/gtest.h>

namespace occlude {
namespace {

// In every frame some items move, disappear, come back, or become unbounded.
void move_some(std::vector<ItemBounds>& items, std::vector<ItemId>& moved, Rng& rng, size_t count)
{
    moved.clear();
    for (size_t i = 0; i < count; ++i) {
        const ItemId item{rng.below(static_cast<uint32_t>(items.size()))};
        const glm::vec3 low{rng.range(0.0f, 1000.0f), rng.range(0.0f, 1000.0f),
                            rng.range(0.0f, 1000.0f)};
        ItemBounds& bounds = items[item.value];
        bounds = {{low, low + rng.range(0.0f, 4.0f)}, rng.below(1000)};
        switch (rng.below(20)) {
        case 0:
            bounds.box = Aabb::empty();
            break;
        case 1:
            bounds.box.max.y = test::kNan;
            break;
        case 2:
            bounds.flags = ItemFlags::translucent;
            break;
        default:
            break;
        }
        moved.push_back(item);
    }
}

class PartialRefit : public ::testing::TestWithParam<std::string> {};

TEST_P(PartialRefit, GivesWhatAFullOneGivesWhileEverythingMoves)
{
    const HierarchyKind* kind = find_hierarchy_kind(GetParam());
    ASSERT_NE(kind, nullptr);
    std::vector<ItemBounds> items = test::random_items(3000, 5);
    Hierarchy partly = kind->build(items, 1024);
    Hierarchy fully = partly;
    Rng rng(11);
    std::vector<ItemId> moved;
    for (int frame = 0; frame < 60; ++frame) {
        move_some(items, moved, rng, frame % 7 == 0 ? 1 : 200);
        partly.refit(moved, items);
        fully.refit(items);
        ASSERT_EQ(validate(partly), "") << "frame " << frame;
        ASSERT_TRUE(test::same_tree(partly, fully)) << "frame " << frame;
        ASSERT_TRUE(std::ranges::equal(partly.flagged_items(), fully.flagged_items()));
    }
    EXPECT_EQ(partly.structure_version(), fully.structure_version());
}

TEST_P(PartialRefit, FollowsAHierarchyThatIsReplaced)
{
    const HierarchyKind* kind = find_hierarchy_kind(GetParam());
    std::vector<ItemBounds> items = test::random_items(400, 5);
    Hierarchy tree = kind->build(items, 0);
    Rng rng(3);
    std::vector<ItemId> moved;
    move_some(items, moved, rng, 40);
    tree.refit(moved, items);
    items = test::random_items(700, 6);
    tree = kind->build(items, 0);
    move_some(items, moved, rng, 40);
    tree.refit(moved, items);
    Hierarchy expected = tree;
    expected.refit(items);
    EXPECT_TRUE(test::same_tree(tree, expected));
}

TEST(PartialRefitReport, NamesTheNodesThatChangedAndNoOthers)
{
    std::vector<ItemBounds> items = test::random_items(500, 5);
    Hierarchy tree = build_bvh(items);
    const Hierarchy before = tree;
    Rng rng(3);
    std::vector<ItemId> moved;
    move_some(items, moved, rng, 10);
    std::vector<NodeId> changed;
    tree.refit(moved, items, &changed);
    std::vector<bool> named(tree.nodes().size(), false);
    for (const NodeId node : changed) {
        EXPECT_FALSE(named[node.value]);
        named[node.value] = true;
    }
    for (size_t i = 0; i < tree.nodes().size(); ++i) {
        const Node& now = tree.nodes()[i];
        const Node& then = before.nodes()[i];
        EXPECT_EQ(named[i], now.box != then.box || now.subtree_triangles != then.subtree_triangles);
    }
    EXPECT_FALSE(changed.empty());
}

INSTANTIATE_TEST_SUITE_P(Hierarchy, PartialRefit, ::testing::Values("bvh", "bsp", "octree", "grid"),
                         [](const auto& param) { return param.param; });

TEST(HierarchyMemory, CountsNodesItemsAndBounds)
{
    const Hierarchy tree = build_bvh(test::random_items(1000, 1), {.max_leaf_items = 1});
    EXPECT_EQ(tree.nodes().size(), 1999u);
    EXPECT_EQ(tree.memory_bytes(),
              1999 * sizeof(Node) + 1000 * (sizeof(ItemId) + sizeof(ItemBounds)));
}

} // namespace
} // namespace occlude
