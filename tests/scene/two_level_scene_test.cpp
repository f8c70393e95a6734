#include <occlude/scene/two_level_scene.h>

#include <glm/ext/matrix_transform.hpp>

#include <gtest/gtest.h>

#include <algorithm>

namespace occlude {
namespace {

std::vector<ItemDesc> row(uint32_t parts)
{
    std::vector<ItemDesc> items;
    for (uint32_t i = 0; i < parts; ++i) {
        const glm::vec3 low{static_cast<float>(i), 0.0f, 0.0f};
        items.push_back({.local_box = {low, low + 1.0f}, .triangles = 12});
    }
    return items;
}

std::vector<ItemId> sorted_items(const Hierarchy& hierarchy)
{
    std::vector<ItemId> items(hierarchy.items().begin(), hierarchy.items().end());
    std::sort(items.begin(), items.end());
    return items;
}

TEST(TwoLevelScene, FollowsWhatComesGoesAndMoves)
{
    Scene scene;
    TwoLevelScene tree;
    const glm::mat4 here{1.0f};
    const glm::mat4 there = glm::translate(here, glm::vec3{50, 0, 0});
    const ObjectId a = scene.add(here, row(1));
    const ObjectId b = scene.add(there, row(3));
    tree.sync(scene);
    EXPECT_EQ(tree.tree().check(), "");
    EXPECT_EQ(sorted_items(tree.hierarchy()).size(), 4u);

    scene.move(b, glm::rotate(there, 0.5f, glm::vec3{0, 1, 0}));
    tree.sync(scene);
    EXPECT_EQ(tree.tree().check(), "");
    EXPECT_EQ(tree.hierarchy().node(NodeId{0u}).box,
              merge(scene.item_bounds()[0].box,
                    merge(scene.item_bounds()[1].box,
                          merge(scene.item_bounds()[2].box, scene.item_bounds()[3].box))));

    scene.remove(a);
    const ObjectId c = scene.add(there, row(1)); // takes the slots of `a`
    tree.sync(scene);
    EXPECT_EQ(tree.tree().check(), "");
    EXPECT_EQ(sorted_items(tree.hierarchy()).size(), 4u);
    EXPECT_TRUE(scene.alive(c));

    scene.remove(b);
    scene.remove(c);
    tree.sync(scene);
    EXPECT_TRUE(tree.hierarchy().empty());
}

TEST(TwoLevelScene, AStandingSceneKeepsItsStructure)
{
    Scene scene;
    TwoLevelScene tree;
    for (int i = 0; i < 10; ++i) {
        const glm::vec3 at{5.0f * static_cast<float>(i), 0.0f, 0.0f};
        scene.add(glm::translate(glm::mat4{1.0f}, at), row(2));
    }
    tree.sync(scene);
    const uint64_t version = tree.hierarchy().structure_version();
    for (int frame = 0; frame < 9; ++frame) {
        tree.sync(scene);
    }
    EXPECT_EQ(tree.hierarchy().structure_version(), version);
}

} // namespace
} // namespace occlude
