// Moving objects in a two-level tree.
#include "hierarchy/scenes.h"
#include "support/loose_boxes.h"
#include "two_level_world.h"

#include <occlude/core/rng.h>

#include <gtest/gtest.h>

namespace occlude {
namespace {

using test::at;
using test::World;

TEST(TwoLevelTree, AMovedObjectIsRelinkedAndItsNodesKeepTheirKeys)
{
    World world({.leaf_triangles = 0, .rebuild_period = 1000});
    std::vector<TwoLevelTree::Slot> slots;
    for (int i = 0; i < 16; ++i) {
        slots.push_back(world.add({3.0f * static_cast<float>(i), 0, 0}, 2));
    }
    world.update();
    EXPECT_EQ(world.tree.rebuild_count(), 1u);
    const auto key_of = [&](uint32_t item) {
        return world.tree.hierarchy().object_nodes().key[world.node_of(item).value];
    };
    const uint32_t key = key_of(0);
    const uint32_t other = key_of(9);
    const uint64_t version = world.tree.hierarchy().structure_version();
    const uint64_t lineage = world.tree.hierarchy().object_nodes().lineage;

    world.move(slots[0], at(0.01f, 0, 0)); // stays in its cell: no new structure
    world.update();
    EXPECT_EQ(world.tree.relink_count(), 0u);
    EXPECT_EQ(world.tree.hierarchy().structure_version(), version);
    EXPECT_EQ(world.tree.check(), "");

    world.move(slots[0], at(40.0f, 0, 0));
    world.update();
    EXPECT_EQ(world.tree.relink_count(), 1u);
    EXPECT_NE(world.tree.hierarchy().structure_version(), version);
    EXPECT_EQ(world.tree.hierarchy().object_nodes().lineage, lineage);
    EXPECT_EQ(world.tree.check(), "");
    EXPECT_EQ(key_of(0), key);
    EXPECT_EQ(key_of(9), other);
}

TEST(TwoLevelTree, TheLayoutWaitsForOneIn64ObjectsToBeRelinked)
{
    World world({.leaf_triangles = 0, .rebuild_period = 1000});
    std::vector<TwoLevelTree::Slot> slots;
    for (int i = 0; i < 200; ++i) {
        slots.push_back(world.add({3.0f * static_cast<float>(i), 0, 0}));
    }
    world.update();
    const uint64_t version = world.tree.hierarchy().structure_version();
    for (size_t moved = 0; moved < 4; ++moved) { // to the other end
        EXPECT_EQ(world.tree.hierarchy().structure_version(), version);
        const NodeId old = world.node_of(static_cast<uint32_t>(moved));
        world.move(slots[moved], at(597.0f - 3.0f * static_cast<float>(moved), 0, 0));
        world.update();
        EXPECT_EQ(world.tree.relink_count(), moved + 1);
        EXPECT_EQ(world.tree.check(), "");
        if (moved < 3) {
            EXPECT_EQ(world.node_of(static_cast<uint32_t>(moved)), old);
        }
    }
    EXPECT_NE(world.tree.hierarchy().structure_version(), version);
}

TEST(TwoLevelTree, FewMovedObjectsLeaveTheTreeThatAFullRefitGives)
{
    World world({.complex_triangles = 50, .leaf_triangles = 0, .rebuild_period = 1000});
    Rng rng{5};
    std::vector<TwoLevelTree::Slot> slots;
    for (int i = 0; i < 400; ++i) {
        const uint32_t parts = i % 4 == 0 ? 4 : 1;
        slots.push_back(world.add({3.0f * static_cast<float>(i), 0, 0}, parts, 12));
    }
    world.update();
    std::vector<bool> turned(slots.size(), false);
    uint32_t in_own_space = 0;
    uint64_t versions_seen = 0;
    uint64_t version = 0;
    for (int frame = 0; frame < 40; ++frame) {
        for (int i = 0; i < 8; ++i) {
            const uint32_t slot = rng.below(400);
            const float step = rng.below(10) == 0 ? 300.0f : 0.3f;
            const glm::mat4 place =
                at(3.0f * static_cast<float>(slot) + rng.range(-step, step), 0, 0);
            if (frame % 4 == 3) { // in the other frames no object starts or stops being turned
                turned[slot] = !turned[slot];
            }
            world.move(slots[slot],
                       turned[slot] ? glm::rotate(place, rng.range(0.1f, 1.0f), glm::vec3{0, 0, 1})
                                    : place);
        }
        world.update();
        ASSERT_EQ(world.tree.check(), "") << "frame " << frame;
        const Hierarchy& tree = world.tree.hierarchy();
        Hierarchy expected = tree;
        expected.refit(world.bounds);
        ASSERT_TRUE(test::same_tree(tree, expected)) << "frame " << frame;
        const ObjectNodes& info = tree.object_nodes();
        for (const auto& [slot, object] : world.objects) {
            ASSERT_EQ(info.frames[slot].world_from_object, world.places[slot]);
        }
        for (size_t i = 0; i < tree.nodes().size(); ++i) {
            const bool oriented =
                info.object[i] != ObjectNodes::kScene && info.frames[info.object[i]].oriented;
            in_own_space += oriented ? 1 : 0;
            if (oriented) { // rows of cubes from the origin, in their own space
                ASSERT_EQ(info.box[i].min.y, 0.0f);
                ASSERT_EQ(info.box[i].max.y, 1.0f);
            } else {
                ASSERT_EQ(info.box[i], tree.nodes()[i].box) << "frame " << frame << " node " << i;
            }
        }
        versions_seen += version != tree.structure_version() ? 1 : 0;
        version = tree.structure_version();
    }
    EXPECT_GT(in_own_space, 0u);
    EXPECT_GT(versions_seen, 1u);
    EXPECT_LT(versions_seen, 40u);
}

TEST(TwoLevelTree, ASubtreeWhoseLinksHaveChangedEnoughIsRebuilt)
{
    World world({.leaf_triangles = 0, .rebuild_period = 1});
    std::vector<TwoLevelTree::Slot> slots;
    for (int i = 0; i < 64; ++i) {
        slots.push_back(world.add({2.0f * static_cast<float>(i), 0, 0}));
    }
    world.update();
    EXPECT_EQ(world.tree.rebuild_count(), 1u);
    // All of them go far away, onto another axis, so that their old cells do not fit any more.
    for (int i = 0; i < 64; ++i) {
        world.move(slots[static_cast<size_t>(i)], at(500, 2.0f * static_cast<float>(i), 0));
    }
    for (int frame = 0; frame < 30; ++frame) {
        world.update();
        EXPECT_EQ(world.tree.check(), "");
    }
    EXPECT_GT(world.tree.rebuild_count(), 1u);
    // Parted again: no node keeps more than a few objects.
    for (const Node& node : world.tree.hierarchy().nodes()) {
        EXPECT_LE(node.own_items, 2u);
    }
    // Nothing moves any more, so that nothing is updated.
    const uint64_t rebuilds = world.tree.rebuild_count();
    const uint64_t version = world.tree.hierarchy().structure_version();
    for (int frame = 0; frame < 8; ++frame) {
        world.update();
    }
    EXPECT_EQ(world.tree.rebuild_count(), rebuilds);
    EXPECT_EQ(world.tree.hierarchy().structure_version(), version);
}

TEST(TwoLevelTree, RestlessNodesAreTestedAsCellsUntilTheyAreQuiet)
{
    World world({.leaf_triangles = 0, .rebuild_period = 1000, .quiet_frames = 3});
    std::vector<TwoLevelTree::Slot> slots;
    for (int i = 0; i < 8; ++i) {
        slots.push_back(world.add({10.0f * static_cast<float>(i), 0, 0}));
    }
    const auto is_tight = [&](uint32_t item) {
        const NodeId node = world.node_of(item);
        const Hierarchy& tree = world.tree.hierarchy();
        return tree.object_nodes().box[node.value] == tree.node(node).box;
    };
    for (int frame = 0; frame < 5; ++frame) {
        world.update();
        EXPECT_EQ(world.tree.check(), "");
    }
    EXPECT_TRUE(is_tight(3));
    world.move(slots[3], at(30.1f, 0.2f, 0));
    world.update();
    EXPECT_FALSE(is_tight(3));
    EXPECT_TRUE(is_tight(7)); // nothing moved there
    EXPECT_EQ(world.tree.check(), "");
    world.update();
    world.update();
    EXPECT_FALSE(is_tight(3));
    world.update();
    EXPECT_TRUE(is_tight(3));
}

TEST(TwoLevelTree, ASubtreeThatIsRebuiltWhenAllIsQuietBecomesTightToo)
{
    World world({.leaf_triangles = 0, .rebuild_period = 16, .quiet_frames = 2});
    std::vector<TwoLevelTree::Slot> slots;
    for (int i = 0; i < 64; ++i) {
        slots.push_back(world.add({2.0f * static_cast<float>(i), 0, 0}));
    }
    world.update();
    for (int i = 0; i < 64; ++i) {
        world.move(slots[static_cast<size_t>(i)], at(500, 2.0f * static_cast<float>(i), 0));
    }
    const uint64_t rebuilds = world.tree.rebuild_count();
    for (int frame = 2; frame <= 17; ++frame) { // rebuilt in the last of them
        EXPECT_EQ(world.tree.rebuild_count(), rebuilds);
        world.update();
    }
    EXPECT_EQ(world.tree.rebuild_count(), rebuilds + 1);
    EXPECT_GT(test::loose_boxes(world.tree.hierarchy()), 10u);
    world.update();
    world.update();
    EXPECT_EQ(test::loose_boxes(world.tree.hierarchy()), 0u);
}

} // namespace
} // namespace occlude
