#include <occlude/core/bounding_sphere.h>

#include <occlude/core/rng.h>

#include <glm/ext/matrix_clip_space.hpp>
#include <gtest/gtest.h>

#include <limits>

namespace occlude {
namespace {

Frustum ahead()
{
    return Frustum::from_clip(glm::perspectiveRH_NO(glm::radians(90.0f), 1.0f, 1.0f, 100.0f), {});
}

TEST(FrustumSphere, IsInsideOutsideOrIntersects)
{
    const Frustum frustum = ahead();
    EXPECT_EQ(frustum.classify_sphere({0.0f, 0.0f, -50.0f}, 10.0f), Containment::inside);
    EXPECT_EQ(frustum.classify_sphere({0.0f, 0.0f, 20.0f}, 10.0f), Containment::outside);
    EXPECT_EQ(frustum.classify_sphere({50.0f, 0.0f, -50.0f}, 10.0f), Containment::intersects);
    EXPECT_EQ(frustum.classify_sphere({0.0f, 0.0f, -105.0f}, 4.9f), Containment::outside);
    EXPECT_EQ(frustum.classify_sphere({0.0f, 0.0f, -105.0f}, 5.1f), Containment::intersects);
}

TEST(FrustumSphere, OddBallsAreSafe)
{
    const Frustum frustum = ahead();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(frustum.classify_sphere({0.0f, 0.0f, 20.0f}, -1.0f), Containment::outside);
    EXPECT_EQ(frustum.classify_sphere({nan, 0.0f, 20.0f}, 1.0f), Containment::intersects);
    EXPECT_EQ(frustum.classify_sphere({0.0f, 0.0f, 20.0f}, Aabb::kInfinity),
              Containment::intersects);
    EXPECT_EQ(Frustum{}.classify_sphere({0.0f, 0.0f, 20.0f}, 1.0f), Containment::inside);
}

TEST(BoundingSphere, ContainsTheCorners)
{
    Rng rng{3};
    for (int i = 0; i < 1000; ++i) {
        const glm::vec3 low{rng.range(-1e4f, 1e4f), rng.range(-10.0f, 10.0f),
                            rng.range(-1.0f, 1.0f)};
        const Aabb box{low, low + glm::vec3{rng.range(0.0f, 9.0f), rng.range(0.0f, 1e3f), 0.1f}};
        const BoundingSphere ball = bounding_sphere(box);
        for (int c = 0; c < 8; ++c) {
            const glm::dvec3 corner{(c & 1) != 0 ? box.max.x : box.min.x,
                                    (c & 2) != 0 ? box.max.y : box.min.y,
                                    (c & 4) != 0 ? box.max.z : box.min.z};
            ASSERT_LE(glm::length(corner - glm::dvec3{ball.center}), double{ball.radius});
        }
    }
    EXPECT_LT(bounding_sphere(Aabb::empty()).radius, 0.0f);
    EXPECT_EQ(bounding_sphere(Aabb::everything()).radius, Aabb::kInfinity);
}

TEST(BoundingSphere, APillarIsElongatedAndAPlateIsNot)
{
    EXPECT_TRUE(is_elongated({glm::vec3{0.0f}, {1.0f, 9.0f, 1.0f}}));
    EXPECT_FALSE(is_elongated({glm::vec3{0.0f}, {9.0f, 0.1f, 9.0f}}));
    EXPECT_FALSE(is_elongated({glm::vec3{0.0f}, {1.0f, 2.0f, 1.0f}}));
    EXPECT_FALSE(is_elongated(Aabb::everything()));
}

TEST(BoundingSphere, ABoxIsAskedOnlyIfItIsElongated)
{
    const Frustum frustum = ahead();
    // Just right of the frustum, whose right plane is x = -z: a tall pillar and a cube with a ball
    // that reaches in.
    const Aabb pillar{{52.0f, -20.0f, -50.0f}, {53.0f, 20.0f, -49.0f}};
    EXPECT_EQ(
        frustum.classify_sphere(bounding_sphere(pillar).center, bounding_sphere(pillar).radius),
        Containment::intersects);
    EXPECT_EQ(classify_sphere_first(frustum, bounding_sphere(pillar), pillar),
              Containment::outside);
    const Aabb cube{{50.4f, -2.0f, -50.0f}, {54.4f, 2.0f, -46.0f}};
    EXPECT_EQ(frustum.classify(cube), Containment::outside);
    EXPECT_EQ(classify_sphere_first(frustum, bounding_sphere(cube), cube), Containment::intersects);
}

TEST(BoundingSphere, NeverContradictsTheBox)
{
    const Frustum frustum = ahead();
    Rng rng{11};
    int decided = 0;
    for (int i = 0; i < 20000; ++i) {
        const glm::vec3 low{rng.range(-120.0f, 120.0f), rng.range(-120.0f, 120.0f),
                            rng.range(-130.0f, 20.0f)};
        const Aabb box{low, low + glm::vec3{rng.range(0.1f, 9.0f), rng.range(0.1f, 60.0f),
                                            rng.range(0.1f, 9.0f)}};
        const Containment found = classify_sphere_first(frustum, bounding_sphere(box), box);
        if (found != Containment::intersects) {
            ++decided;
            ASSERT_EQ(found, frustum.classify(box));
        }
    }
    EXPECT_GT(decided, 10000);
}

TEST(BoundingSphere, ClearsOnlyPlanesThatTheWholeBoxIsInsideOf)
{
    const Frustum frustum = ahead();
    Rng rng{12};
    int cleared_some = 0;
    for (int i = 0; i < 20000; ++i) {
        const glm::vec3 low{rng.range(-60.0f, 60.0f), rng.range(-60.0f, 60.0f),
                            rng.range(-90.0f, 10.0f)};
        const Aabb box{low, low + glm::vec3{rng.range(0.1f, 9.0f), rng.range(0.1f, 60.0f),
                                            rng.range(0.1f, 9.0f)}};
        PlaneMask by_box = Frustum::kAllPlanes;
        PlaneMask by_ball = Frustum::kAllPlanes;
        if (frustum.classify(box, by_box) == Containment::outside) {
            continue;
        }
        classify_sphere_first(frustum, bounding_sphere(box), box, by_ball);
        ASSERT_EQ(by_box & ~by_ball, 0) << "a plane that cuts the box was cleared";
        cleared_some += by_ball != Frustum::kAllPlanes && by_ball != 0 ? 1 : 0;
    }
    EXPECT_GT(cleared_some, 1000);
}

TEST(BoundingSphere, PlanesThatAreNotAskedDoNotCull)
{
    const Frustum frustum = ahead();
    const Aabb behind{glm::vec3{-1.0f, -1.0f, 5.0f}, glm::vec3{1.0f, 1.0f, 7.0f}};
    PlaneMask none = 0;
    EXPECT_EQ(classify_sphere_first(frustum, bounding_sphere(behind), behind, none),
              Containment::inside);
}

} // namespace
} // namespace occlude
