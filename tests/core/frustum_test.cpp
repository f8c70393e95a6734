#include <occlude/core/frustum.h>

#include "screen/projections.h"

#include <occlude/core/rng.h>

#include <gtest/gtest.h>

namespace occlude {
namespace {

using test::Projection;

constexpr float kInf = Aabb::kInfinity;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Aabb cube(const glm::vec3& center, float half)
{
    return {center - half, center + half};
}

/// Looks down -z from the origin: 90 degrees both ways, near 1, far 100.
Frustum simple()
{
    return Frustum::from_clip(glm::perspectiveRH_NO(glm::radians(90.0f), 1.0f, 1.0f, 100.0f),
                              test::kOpenGl);
}

float signed_distance(const Frustum& frustum, Frustum::Plane which, const glm::vec3& p)
{
    return glm::dot(glm::vec3{frustum.plane(which)}, p) + frustum.plane(which).w;
}

TEST(Frustum, PlanesAreUnitNormalsPointingInward)
{
    for (const Projection& projection : test::all_projections()) {
        const Frustum frustum = Frustum::from_clip(projection.clip_from_eye, projection.convention);
        for (int i = 0; i < Frustum::plane_count; ++i) {
            const glm::vec4 plane = frustum.plane(static_cast<Frustum::Plane>(i));
            if (plane != glm::vec4{0.0f}) {
                EXPECT_NEAR(glm::length(glm::vec3{plane}), 1.0f, 1e-6f) << projection.name;
            }
        }
    }
}

// The specification of Frustum::classify for bounded boxes: one plane after the other.
Containment classify_plane_by_plane(const Frustum& frustum, const Aabb& box, PlaneMask& mask)
{
    const glm::vec3 center = box.center();
    const glm::vec3 half = 0.5f * box.extent();
    for (int i = 0; i < Frustum::plane_count; ++i) {
        const auto bit = static_cast<PlaneMask>(1u << i);
        if ((mask & bit) == 0) {
            continue;
        }
        const glm::vec4& plane = frustum.plane(static_cast<Frustum::Plane>(i));
        const glm::vec3 normal{plane};
        const float distance = glm::dot(normal, center) + plane.w;
        const float reach = glm::dot(glm::abs(normal), half);
        const float slop =
            1e-6f * (glm::dot(glm::abs(normal), glm::abs(center)) + std::abs(plane.w) + reach);
        if (distance + reach < -slop) {
            return Containment::outside;
        }
        if (distance - reach >= slop) {
            mask = static_cast<PlaneMask>(mask & ~bit);
        }
    }
    return mask == 0 ? Containment::inside : Containment::intersects;
}

TEST(Frustum, FourPlanesAtOnceAnswerAsOneByOne)
{
    Rng rng(3);
    size_t answers[3] = {};
    for (const Projection& projection : test::all_projections()) {
        const Frustum frustum = Frustum::from_clip(projection.clip_from_eye, projection.convention);
        for (int i = 0; i < 2000; ++i) {
            // Half of the boxes touch a plane, but for rounding.
            glm::vec3 center{rng.range(-40.0f, 40.0f), rng.range(-40.0f, 40.0f),
                             rng.range(-110.0f, 20.0f)};
            const float half = i % 5 == 0 ? 0.0f : rng.range(0.0f, 20.0f);
            if (i % 2 == 0) {
                const auto which = static_cast<Frustum::Plane>(rng.below(Frustum::plane_count));
                const glm::vec3 normal{frustum.plane(which)};
                const float reach =
                    half * (std::abs(normal.x) + std::abs(normal.y) + std::abs(normal.z));
                const float side = i % 4 == 0 ? 1.0f : -1.0f;
                center -= normal * (signed_distance(frustum, which, center) + side * reach);
            }
            const Aabb box = cube(center, half);
            const auto planes = static_cast<PlaneMask>(rng.below(64));
            PlaneMask mask = planes;
            PlaneMask expected_mask = planes;
            const Containment expected = classify_plane_by_plane(frustum, box, expected_mask);
            ASSERT_EQ(frustum.classify(box, mask), expected) << projection.name << ", box " << i;
            if (expected != Containment::outside) {
                ASSERT_EQ(mask, expected_mask) << projection.name << ", box " << i;
            }
            ++answers[static_cast<size_t>(expected)];
        }
    }
    for (const size_t count : answers) {
        EXPECT_GT(count, 1000u);
    }
}

TEST(Frustum, NearAndFarPlanesMeasureWorldUnits)
{
    for (const Projection& projection : test::all_projections()) {
        if (std::string_view(projection.name) == "oblique") {
            continue; // has a test of its own
        }
        const Frustum frustum = Frustum::from_clip(projection.clip_from_eye, projection.convention);
        const bool left_handed = std::string_view(projection.name).ends_with("left-handed");
        const glm::vec3 p{0.0f, 0.0f, left_handed ? 10.0f : -10.0f};
        EXPECT_NEAR(signed_distance(frustum, Frustum::near, p), 9.9f, 1e-4f) << projection.name;
        if (std::string_view(projection.name).starts_with("infinite")) {
            EXPECT_EQ(frustum.plane(Frustum::far), glm::vec4{0.0f}) << projection.name;
        } else {
            EXPECT_NEAR(signed_distance(frustum, Frustum::far, p), 90.0f, 0.05f) << projection.name;
        }
    }
}

TEST(Frustum, ObliqueNearPlaneIsTheGivenOne)
{
    const glm::vec4 plane{0.3f, 0.0f, -1.0f, -0.5f};
    const glm::mat4 clip = test::oblique(glm::perspectiveRH_ZO(1.2f, 1.5f, 0.1f, 100.0f), plane);
    const Frustum frustum = Frustum::from_clip(clip, test::kVulkan);
    const glm::vec4 expected = plane / glm::length(glm::vec3{plane});
    for (int i = 0; i < 4; ++i) {
        EXPECT_NEAR(frustum.plane(Frustum::near)[i], expected[i], 1e-5f);
    }
    EXPECT_EQ(frustum.classify(cube({2.0f, 0.0f, -0.05f}, 0.01f)), Containment::outside);
    EXPECT_NE(frustum.classify(cube({0.0f, 0.0f, -0.6f}, 0.01f)), Containment::outside);
    EXPECT_EQ(frustum.classify(cube({0.0f, 0.0f, -0.4f}, 0.01f)), Containment::outside);
}

TEST(Frustum, OffCentrePlanesFollowTheirEdges)
{
    const Frustum frustum = Frustum::from_clip(
        glm::frustumRH_NO(-0.02f, 0.15f, -0.1f, 0.03f, 0.1f, 100.0f), test::kOpenGl);
    // At distance 10 the frustum covers x in [-2, 15] and y in [-10, 3].
    EXPECT_NEAR(signed_distance(frustum, Frustum::left, {-2.0f, 0.0f, -10.0f}), 0.0f, 1e-5f);
    EXPECT_NEAR(signed_distance(frustum, Frustum::right, {15.0f, 0.0f, -10.0f}), 0.0f, 1e-5f);
    EXPECT_NEAR(signed_distance(frustum, Frustum::bottom, {0.0f, -10.0f, -10.0f}), 0.0f, 1e-5f);
    EXPECT_NEAR(signed_distance(frustum, Frustum::top, {0.0f, 3.0f, -10.0f}), 0.0f, 1e-5f);
}

TEST(Frustum, BoxJustInsideAPlaneIsNotOutside)
{
    // The right plane is x = -z; the box reaches over it by 0.001.
    EXPECT_EQ(simple().classify(cube({10.999f, 0.0f, -10.0f}, 0.5f)), Containment::intersects);
    EXPECT_EQ(simple().classify(cube({8.999f, 0.0f, -10.0f}, 0.5f)), Containment::inside);
}

TEST(Frustum, BoxJustOutsideAPlaneIsOutside)
{
    EXPECT_EQ(simple().classify(cube({11.001f, 0.0f, -10.0f}, 0.5f)), Containment::outside);
}

TEST(Frustum, BoxTouchingAPlaneIsNotOutside)
{
    EXPECT_EQ(simple().classify(cube({11.0f, 0.0f, -10.0f}, 0.5f)), Containment::intersects);
}

TEST(Frustum, BoxBehindNearPlaneIsOutside)
{
    EXPECT_EQ(simple().classify(cube({0.0f, 0.0f, -0.5f}, 0.4f)), Containment::outside);
    EXPECT_EQ(simple().classify(cube({0.0f, 0.0f, -0.5f}, 0.51f)), Containment::intersects);
    EXPECT_EQ(simple().classify(cube({0.0f, 0.0f, 10.0f}, 1.0f)), Containment::outside);
}

TEST(Frustum, BoxBeyondFarPlaneIsOutside)
{
    EXPECT_EQ(simple().classify(cube({0.0f, 0.0f, -102.0f}, 1.0f)), Containment::outside);
    EXPECT_EQ(simple().classify(cube({0.0f, 0.0f, -100.5f}, 1.0f)), Containment::intersects);
}

// Known false: the box lies wholly outside, behind the eye to the right, but crosses the lines of
// all planes. The error is on the safe side.
TEST(Frustum, BigBoxPastACornerIsFalselyCalledIntersecting)
{
    const Aabb box{glm::vec3{3.0f, -20.0f, -2.5f}, glm::vec3{40.0f, 20.0f, 30.0f}};
    // Every point has x >= 3 > 2.5 >= -z: right of the right plane, so none is visible.
    EXPECT_EQ(simple().classify(box), Containment::outside);
    // A box past the edge of two planes may be beyond neither of them alone.
    const Aabb corner{glm::vec3{-100.0f, 101.0f, -120.0f}, glm::vec3{100.0f, 150.0f, -99.0f}};
    // y <= -z <= 100 inside the frustum, so y >= 101 is never visible.
    EXPECT_EQ(simple().classify(corner), Containment::intersects);
}

TEST(Frustum, EmptyBoxIsOutsideOfEveryFrustum)
{
    EXPECT_EQ(simple().classify(Aabb::empty()), Containment::outside);
    EXPECT_EQ(Frustum{}.classify(Aabb::empty()), Containment::outside);
    const Aabb inverted{glm::vec3{0.0f, 0.0f, -10.0f}, glm::vec3{0.0f, 0.0f, -11.0f}};
    EXPECT_EQ(simple().classify(inverted), Containment::outside);
}

TEST(Frustum, UnboundedAndNanBoxesIntersectAndClearNoBit)
{
    const Aabb behind_forever{glm::vec3{0.0f, 0.0f, 5.0f}, glm::vec3{1.0f, 1.0f, kInf}};
    Aabb nan = cube({0.0f, 0.0f, 10.0f}, 1.0f);
    nan.min.x = kNan;
    for (const Aabb& box : {Aabb::everything(), behind_forever, nan}) {
        PlaneMask mask = Frustum::kAllPlanes;
        EXPECT_EQ(simple().classify(box, mask), Containment::intersects);
        EXPECT_EQ(mask, Frustum::kAllPlanes);
    }
}

TEST(Frustum, FlatBoxIsClassifiedLikeAnyOther)
{
    EXPECT_EQ(simple().classify(cube({0.0f, 0.0f, -10.0f}, 0.0f)), Containment::inside);
    EXPECT_EQ(simple().classify(cube({0.0f, 0.0f, 10.0f}, 0.0f)), Containment::outside);
}

TEST(Frustum, HugeFiniteBoxIsNotOutside)
{
    EXPECT_NE(simple().classify(cube(glm::vec3{0.0f}, 3e38f)), Containment::outside);
}

TEST(Frustum, DefaultFrustumCullsNothing)
{
    EXPECT_EQ(Frustum{}.classify(cube({1e6f, -1e6f, 1e6f}, 1.0f)), Containment::inside);
}

TEST(Frustum, PlanesOfBrokenMatricesCullNothing)
{
    for (const float broken : {kNan, kInf, 0.0f}) {
        const Frustum frustum = Frustum::from_clip(glm::mat4{broken}, test::kOpenGl);
        EXPECT_NE(frustum.classify(cube({3.0f, 4.0f, 5.0f}, 1.0f)), Containment::outside) << broken;
    }
}

/// Boxes of random size about random cameras, at a scale of `extent` world units.
void check_against_points(const Projection& projection, float extent, uint64_t seed)
{
    Rng rng(seed);
    // The projections are made for scenes of about 50 units.
    const glm::mat4 to_50 = glm::scale(glm::mat4{1.0f}, glm::vec3{50.0f / extent});
    int outside = 0;
    int seen = 0;
    constexpr int kBoxes = 1500;
    for (int i = 0; i < kBoxes; ++i) {
        const glm::mat4 clip =
            projection.clip_from_eye * test::random_eye_from_world(rng, 10.0f) * to_50;
        const Frustum frustum = Frustum::from_clip(clip, projection.convention);
        const Aabb box = test::random_box(rng, 0.6f * extent, extent);
        const Containment where = frustum.classify(box);
        bool any_inside = false;
        for (int k = 0; k < 40; ++k) {
            const glm::vec3 p =
                k < 8 ? test::corner(box, k)
                      : glm::vec3{rng.range(box.min.x, box.max.x), rng.range(box.min.y, box.max.y),
                                  rng.range(box.min.z, box.max.z)};
            const glm::dvec4 c = glm::dmat4{clip} * glm::dvec4{p, 1.0};
            const double margin = test::clip_margin(c, projection.convention);
            any_inside = any_inside || margin >= 0.0;
            if (where == Containment::inside) {
                ASSERT_GE(margin, -1e-4 * std::max(1.0, std::abs(c.w))) << projection.name;
            }
        }
        ASSERT_FALSE(any_inside && where == Containment::outside)
            << projection.name << ", seed " << seed << ", box " << i;
        outside += where == Containment::outside ? 1 : 0;
        seen += any_inside ? 1 : 0;
    }
    // Otherwise the cases prove nothing.
    EXPECT_GT(outside, kBoxes / 10) << projection.name;
    EXPECT_LT(outside, 9 * kBoxes / 10) << projection.name;
    EXPECT_GT(seen, kBoxes / 10) << projection.name;
}

TEST(Frustum, BoxWithAVisiblePointIsNeverOutside)
{
    for (const Projection& projection : test::all_projections()) {
        check_against_points(projection, 50.0f, 21);
    }
}

TEST(Frustum, BoxWithAVisiblePointIsNeverOutsideInTinyAndHugeScenes)
{
    for (const Projection& projection : test::all_projections()) {
        check_against_points(projection, 1e-3f, 22);
        check_against_points(projection, 1e6f, 23);
    }
}

// Where rounding decides: points on the boundary, rounded to float to either side of it.
TEST(Frustum, PointOnTheBoundaryThatIsVisibleIsNeverOutside)
{
    Rng rng(24);
    int visible = 0;
    int points = 0;
    for (const Projection& projection : test::all_projections()) {
        for (int i = 0; i < 1000; ++i) {
            const float extent = i % 2 == 0 ? 10.0f : 1e4f; // near and far from the origin
            const glm::mat4 clip =
                projection.clip_from_eye * test::random_eye_from_world(rng, extent);
            const Frustum frustum = Frustum::from_clip(clip, projection.convention);
            glm::dvec4 ndc{rng.range(-1, 1), rng.range(-1, 1), rng.range(0.1f, 0.9f), 1.0};
            ndc[static_cast<int>(rng.below(2))] = i % 4 < 2 ? 1.0 : -1.0;
            const glm::dvec4 world = glm::inverse(glm::dmat4{clip}) * ndc;
            const glm::vec3 p{glm::dvec3{world} / world.w};
            const glm::dvec4 c = glm::dmat4{clip} * glm::dvec4{p, 1.0};
            if (test::clip_margin(c, projection.convention) >= 0.0) {
                EXPECT_NE(frustum.classify({p, p}), Containment::outside) << projection.name;
                ++visible;
            }
            ++points;
        }
    }
    EXPECT_GT(visible, points / 10);
    EXPECT_LT(visible, 9 * points / 10);
}

TEST(Frustum, PlaneMaskingDownATreeEqualsTheFullTest)
{
    Rng rng(31);
    int outside = 0;
    int masked = 0;
    constexpr int kCases = 20000;
    for (int i = 0; i < kCases; ++i) {
        const Projection projection = test::all_projections()[static_cast<size_t>(i) % 13];
        const Frustum frustum =
            Frustum::from_clip(projection.clip_from_eye * test::random_eye_from_world(rng, 10.0f),
                               projection.convention);
        const Aabb parent = test::random_box(rng, 30.0f, 60.0f);
        Aabb child = parent;
        for (int axis = 0; axis < 3; ++axis) {
            const float a = rng.range(parent.min[axis], parent.max[axis]);
            const float b = rng.range(parent.min[axis], parent.max[axis]);
            child.min[axis] = std::min(a, b);
            child.max[axis] = std::max(a, b);
        }
        PlaneMask mask = Frustum::kAllPlanes;
        if (frustum.classify(parent, mask) == Containment::outside) {
            EXPECT_EQ(frustum.classify(child), Containment::outside);
            ++outside;
            continue;
        }
        masked += mask != Frustum::kAllPlanes ? 1 : 0;
        EXPECT_EQ(frustum.classify(child, mask), frustum.classify(child)) << "case " << i;
        outside += frustum.classify(child) == Containment::outside ? 1 : 0;
    }
    EXPECT_GT(outside, kCases / 10);
    EXPECT_LT(outside, 9 * kCases / 10);
    EXPECT_GT(masked, kCases / 10);
}

TEST(Frustum, MaskedPlanesAreNotTested)
{
    PlaneMask mask = 0;
    EXPECT_EQ(simple().classify(cube({0.0f, 0.0f, 50.0f}, 1.0f), mask), Containment::inside);
    mask = 1u << Frustum::left;
    EXPECT_EQ(simple().classify(cube({50.0f, 0.0f, -10.0f}, 1.0f), mask), Containment::inside);
    EXPECT_EQ(mask, 0);
}

} // namespace
} // namespace occlude
