#include <occlude/hierarchy/builders/local_tree.h>

#include <gtest/gtest.h>

namespace occlude {
namespace {

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

} // namespace
} // namespace occlude
