#include <occlude/hierarchy/builders/two_level.h>

#include "hierarchy/scenes.h"
#include "support/loose_boxes.h"

#include <occlude/core/rng.h>

#include <glm/ext/matrix_transform.hpp>

#include <gtest/gtest.h>

#include <map>

namespace occlude {
namespace {

/// Objects of cubes around their origins: simple ones of one cube, complex ones of a row of four.
struct World {
    explicit World(const TwoLevelOptions& options = {})
        : tree(options)
    {
    }

    TwoLevelTree::Slot add(const glm::vec3& at, uint32_t parts = 1, uint32_t triangles = 12)
    {
        std::vector<Aabb> local;
        for (uint32_t i = 0; i < parts; ++i) {
            const glm::vec3 low{static_cast<float>(i), 0.0f, 0.0f};
            local.push_back({low, low + 1.0f});
        }
        const auto first = static_cast<uint32_t>(bounds.size());
        const glm::mat4 place = glm::translate(glm::mat4{1.0f}, at);
        const TwoLevelTree::Slot slot = tree.add(
            {.first_item = ItemId{first}, .world_from_object = place, .local_boxes = local});
        objects[slot] = {first, local};
        bounds.resize(first + parts, {Aabb{}, triangles});
        put(slot, place);
        return slot;
    }
    void put(TwoLevelTree::Slot slot, const glm::mat4& place)
    {
        const auto& [first, local] = objects[slot];
        places[slot] = place;
        for (size_t i = 0; i < local.size(); ++i) {
            bounds[first + i].box = transformed(place, local[i]);
        }
    }
    void move(TwoLevelTree::Slot slot, const glm::mat4& place)
    {
        put(slot, place);
        tree.move(slot, place);
    }
    void remove(TwoLevelTree::Slot slot)
    {
        const auto& [first, local] = objects[slot];
        for (size_t i = 0; i < local.size(); ++i) {
            bounds[first + i].box = Aabb{};
        }
        objects.erase(slot);
        tree.remove(slot);
    }
    void update() { tree.update(bounds); }
    /// The node whose own items include `item`.
    NodeId node_of(uint32_t item) const
    {
        for (size_t i = 0; i < tree.hierarchy().nodes().size(); ++i) {
            for (const ItemId own : tree.hierarchy().own_items(NodeId{i})) {
                if (own.value == item) {
                    return NodeId{i};
                }
            }
        }
        return {};
    }

    TwoLevelTree tree;
    std::vector<ItemBounds> bounds;
    std::map<TwoLevelTree::Slot, std::pair<uint32_t, std::vector<Aabb>>> objects;
    std::map<TwoLevelTree::Slot, glm::mat4> places;
};

glm::mat4 at(float x, float y, float z)
{
    return glm::translate(glm::mat4{1.0f}, glm::vec3{x, y, z});
}

TEST(LocalTree, PartsInARowAreCutBetweenThem)
{
    std::vector<Aabb> boxes;
    for (int i = 0; i < 4; ++i) {
        const glm::vec3 low{static_cast<float>(i), 0.0f, 0.0f};
        boxes.push_back({low, low + 1.0f});
    }
    const LocalTree tree = build_local_tree(boxes);
    ASSERT_EQ(tree.nodes.size(), 7u);
    EXPECT_EQ(tree.nodes[0].box, (Aabb{{0, 0, 0}, {4, 1, 1}}));
    const LocalTree::Node& low = tree.nodes[tree.nodes[0].first_child];
    const LocalTree::Node& high = tree.nodes[tree.nodes[0].first_child + 1];
    EXPECT_EQ(low.box.max.x, high.box.min.x);
    EXPECT_EQ(low.box.max.x, 2.0f);
    EXPECT_TRUE(build_local_tree({}).nodes.empty());
}

TEST(TwoLevelTree, SimpleObjectsAreItemsAndComplexOnesAreSubtrees)
{
    World world({.leaf_triangles = 0});
    world.add({0, 0, 0});
    const auto row = world.add({10, 0, 0}, 4);
    world.update();
    const Hierarchy& tree = world.tree.hierarchy();
    EXPECT_EQ(world.tree.check(), "");
    // 0 (1 item | 2 (3 (4 5) 6 (7 8))): the planes part the two objects.
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

// Between layouts only what is above the moved objects is brought up to date; as if all were.
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
            if (frame % 4 == 3) { // in the others all stay turned or not
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
    // All of them go far away, onto another axis: their old cells say nothing of them any more.
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
    // Nothing moves any more: nothing is done any more.
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
