#include <occlude/hierarchy/item_shapes.h>

#include <gtest/gtest.h>

#include <glm/ext/matrix_transform.hpp>

namespace occlude {
namespace {

std::shared_ptr<const Shape> two_boxes()
{
    return std::make_shared<const Shape>(
        Shape{{glm::vec3{0.0f}, glm::vec3{1.0f}}, {glm::vec3{2.0f}, glm::vec3{3.0f}}});
}

TEST(ItemShapes, AreFoundByItemWhereTheyWereMoved)
{
    ItemShapes shapes;
    EXPECT_TRUE(shapes.empty());
    EXPECT_EQ(shapes.find(ItemId{0u}), nullptr);
    const auto shape = two_boxes();
    shapes.place(ItemId{5u}, shape, glm::mat4{1.0f});
    EXPECT_FALSE(shapes.empty());
    EXPECT_EQ(shapes.find(ItemId{4u}), nullptr);
    EXPECT_EQ(shapes.find(ItemId{6u}), nullptr);
    ASSERT_NE(shapes.find(ItemId{5u}), nullptr);
    EXPECT_EQ(shapes.find(ItemId{5u})->shape, shape);
    const glm::mat4 moved = glm::translate(glm::mat4{1.0f}, glm::vec3{1.0f, 2.0f, 3.0f});
    shapes.move(ItemId{5u}, moved);
    shapes.move(ItemId{4u}, moved); // nothing
    shapes.move(ItemId{400u}, moved);
    EXPECT_EQ(shapes.find(ItemId{5u})->world_from_shape, moved);
    EXPECT_EQ(shapes.find(ItemId{4u}), nullptr);
}

TEST(ItemShapes, ARemovedShapeIsGoneAndItsMemoryGivenBack)
{
    ItemShapes shapes;
    const auto shape = two_boxes();
    shapes.place(ItemId{0u}, shape, glm::mat4{1.0f});
    shapes.place(ItemId{1u}, shape, glm::mat4{1.0f});
    EXPECT_EQ(shape.use_count(), 3);
    shapes.remove(ItemId{0u});
    shapes.remove(ItemId{0u});
    shapes.remove(ItemId{77u});
    EXPECT_EQ(shapes.find(ItemId{0u}), nullptr);
    EXPECT_EQ(shape.use_count(), 2);
    shapes.place(ItemId{2u}, two_boxes(), glm::mat4{2.0f});
    EXPECT_EQ(shapes.find(ItemId{0u}), nullptr);
    EXPECT_EQ(shapes.find(ItemId{1u})->shape, shape);
    EXPECT_NE(shapes.find(ItemId{2u})->shape, shape);
    shapes.remove(ItemId{1u});
    shapes.remove(ItemId{2u});
    EXPECT_TRUE(shapes.empty());
}

TEST(ItemShapes, AnEmptyShapeIsNone)
{
    ItemShapes shapes;
    shapes.place(ItemId{0u}, two_boxes(), glm::mat4{1.0f});
    shapes.place(ItemId{0u}, std::make_shared<const Shape>(), glm::mat4{1.0f});
    EXPECT_EQ(shapes.find(ItemId{0u}), nullptr);
    shapes.place(ItemId{0u}, nullptr, glm::mat4{1.0f});
    EXPECT_TRUE(shapes.empty());
}

} // namespace
} // namespace occlude
