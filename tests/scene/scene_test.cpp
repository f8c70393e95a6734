#include <occlude/scene/scene.h>

#include <gtest/gtest.h>

#include <glm/ext/matrix_transform.hpp>

#include <array>

namespace occlude {
namespace {

const Aabb kUnitBox{glm::vec3{-1.0f}, glm::vec3{1.0f}};

glm::mat4 moved_by(float x)
{
    return glm::translate(glm::mat4{1.0f}, glm::vec3{x, 0.0f, 0.0f});
}

ItemDesc item(uint32_t triangles, ItemFlags flags = ItemFlags::none)
{
    return {.local_box = kUnitBox, .triangles = triangles, .flags = flags};
}

TEST(Scene, ShiftMovesEveryObjectAndNothingElse)
{
    Scene scene;
    const std::array items{item(10), item(20)};
    const ObjectId first = scene.add(moved_by(5.0f), items);
    const ObjectId gone = scene.add(moved_by(7.0f), items);
    const ObjectId last = scene.add(moved_by(1e7f), items);
    scene.remove(gone);
    const uint64_t content = scene.content_version();
    const uint64_t motion = scene.motion_version();
    scene.shift({-1e7, 2.0, 0.0});
    EXPECT_EQ(scene.world_from_object(first)[3], glm::vec4(5.0f - 1e7f, 2.0f, 0.0f, 1.0f));
    EXPECT_EQ(scene.world_from_object(last)[3], glm::vec4(0.0f, 2.0f, 0.0f, 1.0f));
    const Aabb& box = scene.item_bounds()[scene.first_item(last).value].box;
    EXPECT_NEAR(box.min.x, -1.0f, 1e-5f);
    EXPECT_NEAR(box.max.y, 3.0f, 1e-5f);
    EXPECT_EQ(scene.content_version(), content);
    EXPECT_NE(scene.motion_version(), motion);
}

TEST(Scene, AnObjectOwnsContiguousItemsInWorldSpace)
{
    Scene scene;
    const std::array items{item(10), item(20, ItemFlags::translucent)};
    const ObjectId object = scene.add(moved_by(5.0f), items);
    ASSERT_TRUE(scene.alive(object));
    EXPECT_EQ(scene.item_count(object), 2u);
    const uint32_t first = scene.first_item(object).value;
    for (uint32_t i = 0; i < 2; ++i) {
        EXPECT_EQ(scene.object_of(ItemId{first + i}), object);
        const Aabb& box = scene.item_bounds()[first + i].box;
        EXPECT_LE(box.min.x, 4.0f);
        EXPECT_GE(box.min.x, 3.999f);
        EXPECT_GE(box.max.x, 6.0f);
    }
    EXPECT_EQ(scene.item_bounds()[first + 1].triangles, 20u);
    EXPECT_TRUE(has_flag(scene.item_flags(ItemId{first + 1}), ItemFlags::translucent));
    EXPECT_FALSE(has_flag(scene.item_flags(ItemId{first}), ItemFlags::translucent));
    EXPECT_EQ(scene.triangle_count(), 30u);
    EXPECT_EQ(scene.object_count(), 1u);
}

TEST(Scene, MovingChangesBoxesAndTheMotionVersionOnly)
{
    Scene scene;
    const std::array items{item(1)};
    const ObjectId object = scene.add(glm::mat4{1.0f}, items);
    const uint64_t content = scene.content_version();
    const uint64_t motion = scene.motion_version();
    EXPECT_TRUE(scene.move(object, moved_by(100.0f)));
    EXPECT_GT(scene.item_bounds()[0].box.min.x, 98.0f);
    EXPECT_EQ(scene.world_from_object(object), moved_by(100.0f));
    EXPECT_EQ(scene.content_version(), content);
    EXPECT_NE(scene.motion_version(), motion);
}

TEST(Scene, ARemovedObjectLeavesEmptySlotsAndAStaleId)
{
    Scene scene;
    const std::array items{item(7)};
    const ObjectId object = scene.add(glm::mat4{1.0f}, items);
    const uint64_t content = scene.content_version();
    EXPECT_TRUE(scene.remove(object));
    EXPECT_FALSE(scene.alive(object));
    EXPECT_TRUE(scene.item_bounds()[0].box.is_empty());
    EXPECT_EQ(scene.item_bounds()[0].triangles, 0u);
    EXPECT_FALSE(scene.object_of(ItemId{0u}).valid());
    EXPECT_FALSE(scene.first_item(object).valid());
    EXPECT_EQ(scene.item_count(object), 0u);
    EXPECT_EQ(scene.triangle_count(), 0u);
    EXPECT_EQ(scene.object_count(), 0u);
    EXPECT_NE(scene.content_version(), content);
}

TEST(Scene, ShapesFollowTheirObjectsAndLeaveNothingBehind)
{
    Scene scene;
    const auto shape = std::make_shared<const Shape>(Shape{kUnitBox, kUnitBox});
    std::array items{item(7), item(8)};
    items[1].shape = shape;
    const ObjectId a = scene.add(moved_by(1.0f), items);
    const ObjectId b = scene.add(moved_by(2.0f), items);
    const ItemId of_a{scene.first_item(a).value + 1};
    const ItemId of_b{scene.first_item(b).value + 1};
    EXPECT_EQ(scene.shapes().find(scene.first_item(a)), nullptr);
    ASSERT_NE(scene.shapes().find(of_a), nullptr);
    EXPECT_EQ(scene.shapes().find(of_a)->shape, shape);
    EXPECT_EQ(scene.shapes().find(of_a)->world_from_shape, moved_by(1.0f));
    scene.move(a, moved_by(9.0f));
    EXPECT_EQ(scene.shapes().find(of_a)->world_from_shape, moved_by(9.0f));
    EXPECT_EQ(scene.shapes().find(of_b)->world_from_shape, moved_by(2.0f));

    // Another object in the same slots: without a shape where there was one.
    scene.remove(a);
    EXPECT_EQ(scene.shapes().find(of_a), nullptr);
    const std::array plain{item(7), item(8)};
    const ObjectId c = scene.add(moved_by(3.0f), plain);
    ASSERT_EQ(scene.first_item(c).value + 1, of_a.value);
    EXPECT_EQ(scene.shapes().find(of_a), nullptr);
    scene.remove(b);
    EXPECT_TRUE(scene.shapes().empty());
    const Scene copy = scene;
    EXPECT_TRUE(copy.shapes().empty());
}

TEST(Scene, ARecycledSlotNeverAnswersForItsFormerOwner)
{
    Scene scene;
    const std::array items{item(7), item(8)};
    const ObjectId old = scene.add(glm::mat4{1.0f}, items);
    scene.remove(old);
    const ObjectId fresh = scene.add(moved_by(3.0f), items);
    ASSERT_EQ(fresh.index, old.index) << "the slot should have been used again";
    EXPECT_NE(fresh.generation, old.generation);
    EXPECT_EQ(scene.item_bounds().size(), 2u) << "item slots should have been used again";
    EXPECT_FALSE(scene.alive(old));
    EXPECT_FALSE(scene.move(old, moved_by(50.0f)));
    EXPECT_FALSE(scene.remove(old));
    EXPECT_TRUE(scene.alive(fresh));
    EXPECT_EQ(scene.object_of(ItemId{0u}), fresh);
}

TEST(Scene, RemovingTwiceChangesNothing)
{
    Scene scene;
    const std::array items{item(7)};
    const ObjectId a = scene.add(glm::mat4{1.0f}, items);
    scene.add(glm::mat4{1.0f}, items);
    EXPECT_TRUE(scene.remove(a));
    EXPECT_FALSE(scene.remove(a));
    EXPECT_EQ(scene.object_count(), 1u);
    EXPECT_EQ(scene.triangle_count(), 7u);
}

TEST(Scene, ForeignIdsAreRefused)
{
    Scene scene;
    EXPECT_FALSE(scene.alive(ObjectId{}));
    EXPECT_FALSE(scene.alive(ObjectId{17, 1}));
    EXPECT_FALSE(scene.move(ObjectId{17, 1}, glm::mat4{1.0f}));
    EXPECT_FALSE(scene.object_of(ItemId{}).valid());
    EXPECT_FALSE(scene.object_of(ItemId{5u}).valid());
}

TEST(Scene, RunsOfFreeItemsAreUsedAgainOnlyForObjectsOfTheirSize)
{
    Scene scene;
    const std::array two{item(1), item(1)};
    const std::array one{item(1)};
    const ObjectId a = scene.add(glm::mat4{1.0f}, two);
    scene.remove(a);
    const ObjectId b = scene.add(glm::mat4{1.0f}, one);
    EXPECT_EQ(scene.first_item(b).value, 2u);
    const ObjectId c = scene.add(glm::mat4{1.0f}, two);
    EXPECT_EQ(scene.first_item(c).value, 0u);
    EXPECT_EQ(scene.object_of(ItemId{1u}), c);
    EXPECT_EQ(scene.object_of(ItemId{2u}), b);
}

TEST(Scene, ALocalBoxThatIsUnknownIsUnboundedInTheWorld)
{
    Scene scene;
    Aabb unknown = kUnitBox;
    unknown.max.y = std::numeric_limits<float>::quiet_NaN();
    const std::array items{ItemDesc{.local_box = unknown, .triangles = 1}};
    scene.add(glm::mat4{1.0f}, items);
    EXPECT_EQ(scene.item_bounds()[0].box, Aabb::everything());
}

} // namespace
} // namespace occlude
