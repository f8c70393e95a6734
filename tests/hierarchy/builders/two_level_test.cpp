#include <occlude/hierarchy/builders/two_level.h>

#include "hierarchy/scenes.h"
#include "two_level_world.h"

#include <occlude/core/rng.h>
#include <occlude/hierarchy/item_shapes.h>

#include <glm/ext/matrix_transform.hpp>

#include <gtest/gtest.h>

#include <map>

namespace occlude {
namespace {

using test::at;
using test::World;

TEST(TwoLevelTree, SimpleObjectsAreItemsAndComplexOnesAreSubtrees)
{
    World world({.leaf_triangles = 0});
    world.add({0, 0, 0});
    const auto row = world.add({10, 0, 0}, 4);
    world.update();
    const Hierarchy& tree = world.tree.hierarchy();
    EXPECT_EQ(world.tree.check(), "");
    // 0 (1 item | 2 (3 (4 5) 6 (7 8))): the planes separate the two objects.
    EXPECT_EQ(tree.items().size(), 5u);
    const ObjectNodes& info = tree.object_nodes();
    size_t of_row = 0;
    for (const uint32_t object : info.object) {
        of_row += object == row ? 1 : 0;
    }
    EXPECT_EQ(of_row, 7u);
    EXPECT_FALSE(info.frames[row].oriented);
    const NodeId leaf = world.node_of(1);
    EXPECT_EQ(tree.node(leaf).own_items, 1u);
    EXPECT_EQ(info.object[leaf.value], row);
    EXPECT_EQ(info.object[world.node_of(0).value], ObjectNodes::kScene);
}

TEST(TwoLevelTree, AStraddlingObjectStaysInTheInnerNode)
{
    World world({.leaf_triangles = 0});
    for (const float x : {0.0f, 2.0f, 20.0f, 22.0f}) {
        world.add({x, 0, 0});
    }
    const auto long_one = world.add({-1, 0, 0}, 30); // from -1 to 29, over all planes along x
    world.update();
    EXPECT_EQ(world.tree.check(), "");
    const ObjectNodes& info = world.tree.hierarchy().object_nodes();
    NodeId root_of_long;
    for (size_t i = info.object.size(); i-- > 0;) {
        root_of_long = info.object[i] == long_one ? NodeId{i} : root_of_long;
    }
    EXPECT_EQ(world.tree.hierarchy().node(root_of_long).parent, NodeId{0u});
}

TEST(TwoLevelTree, ATurnedObjectIsTestedInItsOwnSpace)
{
    World world;
    const auto row = world.add({0, 0, 0}, 4);
    world.update();
    world.move(row, glm::rotate(glm::mat4{1.0f}, 0.7f, glm::vec3{0, 0, 1}));
    world.update();
    EXPECT_EQ(world.tree.check(), "");
    const ObjectNodes& info = world.tree.hierarchy().object_nodes();
    ASSERT_TRUE(info.frames[row].oriented);
    bool found = false;
    for (size_t i = 0; i < info.object.size(); ++i) {
        found = found || (info.object[i] == row && info.box[i] == Aabb{{0, 0, 0}, {4, 1, 1}});
    }
    EXPECT_TRUE(found);
}

// Between layouts only the ancestors of moved objects are updated. The result equals a full update.
TEST(TwoLevelTree, StaysSoundWhileObjectsComeGoAndMove)
{
    World world({.complex_triangles = 50, .leaf_triangles = 100, .rebuild_period = 2});
    Rng rng{11};
    std::vector<TwoLevelTree::Slot> slots;
    const auto place = [&] {
        return glm::rotate(at(rng.range(-50, 50), rng.range(-50, 50), rng.range(-50, 50)),
                           rng.range(0.0f, 6.0f), glm::vec3{0, 1, 0});
    };
    uint64_t relinks = 0;
    for (int frame = 0; frame < 60; ++frame) {
        for (int i = 0; i < 6; ++i) {
            const uint32_t parts = rng.below(3) == 0 ? 1 + rng.below(9) : 1;
            slots.push_back(world.add({rng.range(-50, 50), 0, 0}, parts, 1 + rng.below(100)));
        }
        for (size_t i = 0; i < slots.size(); i += 2) {
            world.move(slots[i], place());
        }
        if (frame > 30) {
            for (int i = 0; i < 9; ++i) {
                const size_t victim = rng.below(static_cast<uint32_t>(slots.size()));
                world.remove(slots[victim]);
                slots.erase(slots.begin() + static_cast<std::ptrdiff_t>(victim));
            }
        }
        world.update();
        ASSERT_EQ(world.tree.check(), "") << "frame " << frame;
        relinks = world.tree.relink_count();
    }
    EXPECT_GT(relinks, 500u);
    while (!slots.empty()) {
        world.remove(slots.back());
        slots.pop_back();
    }
    world.update();
    EXPECT_TRUE(world.tree.hierarchy().empty());
    EXPECT_EQ(world.tree.check(), "");
}

// Cullers keep a reference to hierarchy(): a tree with new contents must stay in its place.
TEST(TwoLevelTree, KeepsItsHierarchyInPlaceWhenAnotherTreeIsMovedIntoIt)
{
    World world({.leaf_triangles = 0});
    world.add({0, 0, 0});
    world.update();
    World other({.leaf_triangles = 0});
    other.add({0, 0, 0});
    other.add({10, 0, 0}, 3);
    other.update();
    const Hierarchy* const place = &world.tree.hierarchy();
    const uint64_t structure = place->structure_version();
    world.tree = std::move(other.tree);
    EXPECT_EQ(&world.tree.hierarchy(), place);
    EXPECT_NE(place->structure_version(), structure);
    EXPECT_EQ(place->items().size(), 4u);
    EXPECT_EQ(world.tree.check(), "");
}

TEST(TwoLevelTree, ShapesOutliveEveryLayout)
{
    World world;
    const ItemShapes shapes;
    world.tree.set_shapes(&shapes);
    world.add({0.0f, 0.0f, 0.0f});
    world.update();
    ASSERT_EQ(world.tree.hierarchy().items().size(), 1u);
    EXPECT_EQ(world.tree.hierarchy().shapes(), &shapes);
    const uint64_t structure = world.tree.hierarchy().structure_version();
    world.add({9.0f, 0.0f, 0.0f});
    world.update();
    EXPECT_NE(world.tree.hierarchy().structure_version(), structure) << "there is a new layout";
    EXPECT_EQ(world.tree.hierarchy().shapes(), &shapes);
}

TEST(TwoLevelTree, UnboundedAndEmptyObjectsAreHarmless)
{
    std::vector<ItemBounds> items(40);
    for (size_t i = 0; i < items.size(); ++i) {
        const glm::vec3 low{static_cast<float>(i), 0.0f, 0.0f};
        items[i] = {{low, low + 0.5f}, 12};
    }
    items[3].box = Aabb::everything();
    items[4].box.min.x = std::numeric_limits<float>::quiet_NaN();
    items[5].box = Aabb{};
    const Hierarchy tree = build_two_level(items, {.leaf_triangles = 0});
    EXPECT_EQ(validate(tree), "");
    EXPECT_EQ(tree.items().size(), 40u);
    EXPECT_GT(tree.nodes().size(), 40u);
}

} // namespace
} // namespace occlude
