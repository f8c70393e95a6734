#include <occlude/core/aabb.h>

#include "screen/projections.h"

#include <gtest/gtest.h>

#include <cfloat>
#include <cmath>

namespace occlude {
namespace {

constexpr float kInf = Aabb::kInfinity;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
const Aabb kUnit{glm::vec3{0.0f}, glm::vec3{1.0f}};

TEST(Aabb, DefaultBoxIsEmpty)
{
    EXPECT_TRUE(Aabb{}.is_empty());
    EXPECT_EQ(Aabb::empty(), Aabb{});
    EXPECT_FALSE(Aabb{}.is_bounded());
}

TEST(Aabb, InvertedOnOneAxisIsEmpty)
{
    for (int axis = 0; axis < 3; ++axis) {
        Aabb box = kUnit;
        box.min[axis] = 2.0f;
        EXPECT_TRUE(box.is_empty());
        EXPECT_FALSE(box.is_bounded());
    }
}

TEST(Aabb, NanAnywhereIsUnknownAndNeverEmptyOrBounded)
{
    for (int axis = 0; axis < 3; ++axis) {
        for (const bool low : {true, false}) {
            Aabb box = kUnit;
            (low ? box.min : box.max)[axis] = kNan;
            EXPECT_TRUE(box.has_nan());
            EXPECT_FALSE(box.is_bounded());
            EXPECT_FALSE(box.is_empty());
            EXPECT_EQ(sanitized(box), Aabb::everything());

            // An unknown box is not an empty one, even where another axis is inverted.
            box.min[(axis + 1) % 3] = 5.0f;
            EXPECT_FALSE(box.is_empty());
        }
    }
}

TEST(Aabb, InfiniteSideIsUnboundedAndNotEmpty)
{
    for (int axis = 0; axis < 3; ++axis) {
        Aabb above = kUnit;
        above.max[axis] = kInf;
        Aabb below = kUnit;
        below.min[axis] = -kInf;
        for (const Aabb& box : {above, below}) {
            EXPECT_FALSE(box.is_bounded());
            EXPECT_FALSE(box.is_empty());
            EXPECT_EQ(sanitized(box), box);
        }
    }
    EXPECT_FALSE(Aabb::everything().is_bounded());
    EXPECT_FALSE(Aabb::everything().is_empty());
}

TEST(Aabb, FlatBoxIsOrdinary)
{
    Aabb point{glm::vec3{1.0f}, glm::vec3{1.0f}};
    EXPECT_TRUE(point.is_bounded());
    EXPECT_FALSE(point.is_empty());
    EXPECT_EQ(point.center(), glm::vec3{1.0f});
}

TEST(Aabb, CenterOfHugeBoxIsFinite)
{
    const Aabb far_away{glm::vec3{FLT_MAX}, glm::vec3{FLT_MAX}};
    EXPECT_TRUE(far_away.is_bounded());
    EXPECT_EQ(far_away.center(), glm::vec3{FLT_MAX});
}

TEST(Aabb, MergeIsSmallestBoxAroundBoth)
{
    const Aabb other{glm::vec3{-1.0f, 0.5f, 3.0f}, glm::vec3{0.5f, 0.6f, 4.0f}};
    const Aabb both{glm::vec3{-1.0f, 0.0f, 0.0f}, glm::vec3{1.0f, 1.0f, 4.0f}};
    EXPECT_EQ(merge(kUnit, other), both);
    EXPECT_EQ(merge(other, kUnit), both);
}

TEST(Aabb, MergingAnEmptyBoxAddsNothing)
{
    const Aabb inverted{glm::vec3{100.0f, 0.0f, 0.0f}, glm::vec3{-100.0f, 0.0f, 0.0f}};
    for (const Aabb& nothing : {Aabb::empty(), inverted}) {
        EXPECT_EQ(merge(kUnit, nothing), kUnit);
        EXPECT_EQ(merge(nothing, kUnit), kUnit);
    }
}

TEST(Aabb, MergingANanBoxMakesEverything)
{
    Aabb nan = kUnit;
    nan.max.y = kNan;
    EXPECT_EQ(merge(kUnit, nan), Aabb::everything());
    EXPECT_EQ(merge(nan, Aabb::empty()), Aabb::everything());
}

TEST(Aabb, ContainsCountsFacesAndEmptyBoxes)
{
    EXPECT_TRUE(contains(kUnit, kUnit));
    EXPECT_TRUE(contains(kUnit, Aabb::empty()));
    EXPECT_TRUE(contains(Aabb::everything(), kUnit));
    EXPECT_FALSE(contains(kUnit, inflated(kUnit, 1e-6f)));
    EXPECT_FALSE(contains(Aabb::empty(), kUnit));
    Aabb nan = kUnit;
    nan.min.z = kNan;
    EXPECT_FALSE(contains(kUnit, nan));
    EXPECT_FALSE(contains(nan, kUnit));
}

TEST(Aabb, SurfaceAreaOfOddBoxes)
{
    EXPECT_FLOAT_EQ(surface_area({glm::vec3{0.0f}, glm::vec3{1.0f, 2.0f, 3.0f}}), 22.0f);
    EXPECT_EQ(surface_area({glm::vec3{0.0f}, glm::vec3{2.0f, 3.0f, 0.0f}}), 12.0f);
    EXPECT_EQ(surface_area(Aabb::empty()), 0.0f);
    EXPECT_EQ(surface_area(Aabb::everything()), kInf);
    // A line without end: infinite times flat must not become NaN.
    EXPECT_EQ(surface_area({glm::vec3{0.0f}, glm::vec3{kInf, 0.0f, 0.0f}}), kInf);
    EXPECT_EQ(surface_area({glm::vec3{kNan}, glm::vec3{1.0f}}), kInf);
}

TEST(Aabb, InflatedGrowsOnAllSidesAndKeepsEmptyEmpty)
{
    EXPECT_EQ(inflated(kUnit, 0.5f), (Aabb{glm::vec3{-0.5f}, glm::vec3{1.5f}}));
    EXPECT_TRUE(inflated(Aabb::empty(), 1.0f).is_empty());
    const Aabb inverted{glm::vec3{0.1f}, glm::vec3{0.0f}};
    EXPECT_TRUE(inflated(inverted, 1.0f).is_empty());
}

TEST(Aabb, DistanceIsZeroInsideAndToNearestPointOutside)
{
    EXPECT_EQ(distance_squared(kUnit, glm::vec3{0.5f}), 0.0f);
    EXPECT_EQ(distance_squared(kUnit, glm::vec3{1.0f}), 0.0f);
    EXPECT_EQ(distance_squared(kUnit, {3.0f, 0.5f, 0.5f}), 4.0f);
    EXPECT_EQ(distance_squared(kUnit, {4.0f, 5.0f, 1.0f}), 25.0f);
    EXPECT_EQ(distance_squared(Aabb::empty(), glm::vec3{0.0f}), kInf);
    EXPECT_EQ(distance_squared(Aabb::everything(), glm::vec3{1e30f}), 0.0f);
    EXPECT_EQ(distance_squared({glm::vec3{kNan}, glm::vec3{1.0f}}, glm::vec3{9.0f}), 0.0f);
}

TEST(Aabb, TransformedKeepsEmptyAndOpensUnbounded)
{
    const glm::mat4 move = glm::translate(glm::mat4{1.0f}, {1.0f, 2.0f, 3.0f});
    EXPECT_TRUE(transformed(move, Aabb::empty()).is_empty());
    EXPECT_EQ(transformed(move, Aabb::everything()), Aabb::everything());
    EXPECT_EQ(transformed(move, {glm::vec3{0.0f}, glm::vec3{kInf}}), Aabb::everything());
    EXPECT_EQ(transformed(move, {glm::vec3{kNan}, glm::vec3{1.0f}}), Aabb::everything());
    EXPECT_FALSE(transformed(glm::mat4{kNan}, kUnit).is_bounded());
    EXPECT_FALSE(transformed(glm::mat4{kInf}, kUnit).is_bounded());
    EXPECT_FALSE(transformed(glm::mat4{kInf}, kUnit).is_empty());
}

TEST(Aabb, TransformedContainsEveryImageAndIsTight)
{
    Rng rng(7);
    for (int i = 0; i < 2000; ++i) {
        // Tiny and huge scenes; shears and mirrors too.
        const float extent = i % 3 == 0 ? 1e-3f : i % 3 == 1 ? 10.0f : 1e6f;
        glm::mat4 m{1.0f};
        for (int c = 0; c < 3; ++c) {
            m[c] = {rng.range(-2, 2), rng.range(-2, 2), rng.range(-2, 2), 0.0f};
        }
        m[3] = {rng.range(-extent, extent), rng.range(-extent, extent), rng.range(-extent, extent),
                1.0f};
        const Aabb box = test::random_box(rng, extent, extent);
        const Aabb image = transformed(m, box);
        Aabb tight;
        for (int k = 0; k < 8; ++k) {
            // long double: exact enough to be the truth.
            const glm::vec3 p = test::corner(box, k);
            glm::vec3 rounded;
            for (int axis = 0; axis < 3; ++axis) {
                long double sum = m[3][axis];
                for (int c = 0; c < 3; ++c) {
                    sum += static_cast<long double>(m[c][axis]) * p[c];
                }
                ASSERT_LE(static_cast<long double>(image.min[axis]), sum) << "case " << i;
                ASSERT_GE(static_cast<long double>(image.max[axis]), sum) << "case " << i;
                rounded[axis] = static_cast<float>(sum);
            }
            tight = merge(tight, {rounded, rounded});
        }
        const float slop = 4e-7f * extent;
        EXPECT_TRUE(contains(inflated(tight, slop), image)) << "case " << i;
    }
}

TEST(Aabb, TransformedContainsImageUnderCancellation)
{
    // x + y - z cancels to far less than the rounding of its terms.
    glm::mat4 m{1.0f};
    m[0][0] = 1.0000001f;
    m[1][0] = 3333333.3f;
    m[2][0] = -0.99999994f;
    m[3][0] = 12345.678f;
    const Aabb point{glm::vec3{1e6f, 1.1f, 4666664.5f}, glm::vec3{1e6f, 1.1f, 4666664.5f}};
    const Aabb image = transformed(m, point);
    long double exact = m[3][0];
    for (int c = 0; c < 3; ++c) {
        exact += static_cast<long double>(m[c][0]) * point.min[c];
    }
    EXPECT_LE(static_cast<long double>(image.min.x), exact);
    EXPECT_GE(static_cast<long double>(image.max.x), exact);
}

} // namespace
} // namespace occlude
