#include <occlude/core/view.h>

#include "screen/projections.h"

#include <gtest/gtest.h>

#include <array>

namespace occlude {
namespace {

using test::Projection;

constexpr float kInf = Aabb::kInfinity;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr glm::ivec2 kSize{1280, 720};

Aabb cube(const glm::vec3& center, float half)
{
    return {center - half, center + half};
}

View down_z(float fov_y_degrees, float near)
{
    return View::from_clip(
        glm::perspectiveRH_NO(glm::radians(fov_y_degrees), 16.0f / 9.0f, near, 100.0f), kSize);
}

TEST(View, EyeIsRecoveredFromEveryPerspectiveMatrix)
{
    Rng rng(41);
    for (const Projection& projection : test::all_projections()) {
        for (int i = 0; i < 100; ++i) {
            const glm::mat4 eye_from_world = test::random_eye_from_world(rng, 20.0f);
            const View view = View::from_clip(projection.clip_from_eye * eye_from_world, kSize,
                                              projection.convention);
            EXPECT_EQ(view.orthographic(), projection.orthographic) << projection.name;
            if (!projection.orthographic) {
                const glm::vec3 eye{glm::inverse(eye_from_world)[3]};
                EXPECT_LT(glm::length(view.eye() - eye), 1e-3f) << projection.name;
            }
        }
    }
}

TEST(View, EyeIsRecoveredFarFromTheOrigin)
{
    const glm::vec3 eye{1e6f, -2e5f, 3e5f};
    const glm::mat4 clip = glm::perspectiveRH_NO(1.0f, 1.5f, 0.5f, 1e4f) *
                           glm::lookAt(eye, eye + glm::vec3{8.0f, 16.0f, 2.0f}, {0, 0, 1});
    // The float matrix itself is this far off.
    EXPECT_LT(glm::length(View::from_clip(clip, kSize).eye() - eye), 1.0f);
}

TEST(View, DegenerateMatricesCullNothing)
{
    glm::mat4 flat{1.0f};
    flat[2][2] = 0.0f;
    const glm::mat4 good = glm::perspectiveRH_NO(1.0f, 1.5f, 0.1f, 100.0f);
    const std::array views{View{},
                           View::from_clip(glm::mat4{0.0f}, kSize),
                           View::from_clip(glm::mat4{kNan}, kSize),
                           View::from_clip(glm::mat4{kInf}, kSize),
                           View::from_clip(flat, kSize),
                           View::from_clip(good, {0, 720}),
                           View::from_clip(good, {1280, -1})};
    for (const View& view : views) {
        for (const Aabb& box : {cube({0.0f, 0.0f, 5.0f}, 1.0f), cube({0.0f, 0.0f, -5.0f}, 1.0f),
                                cube({900.0f, 0.0f, 0.0f}, 1.0f)}) {
            EXPECT_NE(view.frustum().classify(box), Containment::outside);
            EXPECT_TRUE(view.touches_near(box));
            EXPECT_TRUE(contains(view.inflated_for_test(box), box));
            EXPECT_TRUE(view.inflated_for_test(box).is_bounded());
        }
    }
}

TEST(View, KeepsWhatItWasMadeFrom)
{
    const glm::mat4 clip = glm::perspectiveRH_ZO(1.0f, 1.5f, 0.1f, 100.0f);
    const View view = View::from_clip(clip, kSize, test::kVulkan);
    EXPECT_EQ(view.clip_from_world(), clip);
    EXPECT_EQ(view.size_px(), kSize);
    EXPECT_EQ(view.convention(), test::kVulkan);
}

// Rule R1: the near rectangle's corners are farther than its middle. At 150 degrees and 16:9 they
// are 7.68 near distances away. A box beside the eye can be beyond the near *distance* and be cut
// by the near rectangle all the same.
TEST(View, BoxAtTheCornerOfAWideNearRectangleTouches)
{
    const View view = down_z(150.0f, 1.0f);
    const float tan_y = std::tan(glm::radians(75.0f));
    const glm::vec3 corner{tan_y * 16.0f / 9.0f, tan_y, -1.0f};
    EXPECT_GT(glm::length(corner), 7.5f);
    EXPECT_TRUE(view.touches_near(cube(corner, 0.01f)));
}

TEST(View, NearReachIsTheCornerDistanceFromBothSides)
{
    const View view = down_z(90.0f, 1.0f);
    const float corner = std::sqrt(1.0f + 1.0f + 256.0f / 81.0f);
    // Across the near plane, sideways: at first within reach, then beyond it.
    const auto beside = [](float x) {
        return Aabb{glm::vec3{x, -0.1f, -1.5f}, glm::vec3{x + 5.0f, 0.1f, 0.5f}};
    };
    EXPECT_TRUE(view.touches_near(beside(corner * 0.999f)));
    EXPECT_FALSE(view.touches_near(beside(corner * 1.001f)));
}

TEST(View, BoxBeyondTheNearPlaneDoesNotTouch)
{
    const View view = down_z(90.0f, 1.0f);
    const auto ahead = [](float z) {
        return Aabb{glm::vec3{-0.5f, -0.5f, z - 1.0f}, glm::vec3{0.5f, 0.5f, z}};
    };
    EXPECT_FALSE(view.touches_near(ahead(-1.001f)));
    EXPECT_TRUE(view.touches_near(ahead(-1.0f)));
    EXPECT_TRUE(view.touches_near(ahead(-0.999f)));
}

TEST(View, BoxAroundTheEyeTouches)
{
    EXPECT_TRUE(down_z(60.0f, 0.1f).touches_near(cube(glm::vec3{0.0f}, 1.0f)));
    EXPECT_TRUE(down_z(60.0f, 0.1f).touches_near(cube(glm::vec3{0.0f}, 1e6f)));
}

TEST(View, BoxesThatAreNotBoundedTouch)
{
    const View view = down_z(60.0f, 0.1f);
    EXPECT_TRUE(view.touches_near(Aabb::everything()));
    EXPECT_TRUE(view.touches_near({glm::vec3{kNan}, glm::vec3{1.0f}}));
    EXPECT_TRUE(view.touches_near({glm::vec3{5.0f, 5.0f, -kInf}, glm::vec3{6.0f, 6.0f, -50.0f}}));
}

TEST(View, OrthographicBoxAcrossTheNearPlaneTouches)
{
    const View view = View::from_clip(glm::orthoRH_ZO(-5.0f, 5.0f, -5.0f, 5.0f, 1.0f, 50.0f), kSize,
                                      test::kVulkan);
    EXPECT_TRUE(view.touches_near(cube({0.0f, 0.0f, -1.0f}, 0.5f)));
    EXPECT_FALSE(view.touches_near(cube({0.0f, 0.0f, -2.0f}, 0.5f)));
}

// Known false: a box behind the near rectangle, inside the sphere through its corners.
TEST(View, BoxBesideTheEyeIsFalselyCalledTouching)
{
    EXPECT_TRUE(down_z(90.0f, 1.0f).touches_near(cube({0.0f, 0.0f, 1.0f}, 0.1f)));
}

/// True if a point of `box` lies before the near plane within the pyramid of the screen.
bool near_cuts(const Aabb& box, const Projection& projection, const glm::dmat4& clip, Rng& rng)
{
    const bool reversed = projection.convention.order == DepthOrder::near_is_large;
    for (int k = 0; k < 200; ++k) {
        const glm::dvec4 p{rng.range(box.min.x, box.max.x), rng.range(box.min.y, box.max.y),
                           rng.range(box.min.z, box.max.z), 1.0};
        const glm::dvec4 c = clip * p;
        const double low = projection.convention.range == DepthRange::zero_to_one ? c.z : c.w + c.z;
        const double beyond_near = reversed ? c.w - c.z : low;
        if (std::abs(c.x) <= c.w && std::abs(c.y) <= c.w && beyond_near < 0.0) {
            return true;
        }
    }
    return false;
}

TEST(View, BoxCutByTheNearRectangleAlwaysTouches)
{
    Rng rng(43);
    int cut = 0;
    int touching = 0;
    int cases = 0;
    for (const Projection& projection : test::all_projections()) {
        for (int i = 0; i < 400; ++i) {
            const glm::mat4 eye_from_world = test::random_eye_from_world(rng, 5.0f);
            const glm::mat4 clip = projection.clip_from_eye * eye_from_world;
            const View view = View::from_clip(clip, kSize, projection.convention);
            const glm::vec3 eye{glm::inverse(eye_from_world)[3]};
            Aabb box = test::random_box(rng, 1.0f, 4.0f);
            box.min += eye;
            box.max += eye;
            const bool touches = view.touches_near(box);
            const bool cuts = near_cuts(box, projection, glm::dmat4{clip}, rng);
            EXPECT_TRUE(touches || !cuts) << projection.name << ", case " << i;
            cut += cuts ? 1 : 0;
            touching += touches ? 1 : 0;
            ++cases;
        }
    }
    EXPECT_GT(cut, cases / 20);
    EXPECT_GT(touching, cases / 10);
    EXPECT_LT(touching, 9 * cases / 10);
}

TEST(View, ObliqueNearPlanePastTheHorizonTouchesEverythingBeforeIt)
{
    // Keeps only what is right of x = 1: the left corners of the near rectangle do not exist.
    const glm::mat4 clip =
        test::oblique(glm::perspectiveRH_ZO(1.2f, 1.5f, 0.1f, 100.0f), {1.0f, 0.0f, 0.0f, -1.0f});
    const View view = View::from_clip(clip, kSize, test::kVulkan);
    EXPECT_TRUE(view.touches_near(Aabb{{0.5f, -1.0f, -80.0f}, {1.5f, 1.0f, -60.0f}}));
    EXPECT_FALSE(view.touches_near(Aabb{{1.2f, -1.0f, -80.0f}, {1.5f, 1.0f, -60.0f}}));
}

TEST(View, DistanceKeyIsSquaredDistanceToTheNearestPoint)
{
    const View view = down_z(60.0f, 0.1f);
    EXPECT_NEAR(view.distance_key(cube({0.0f, 0.0f, -11.0f}, 1.0f)), 100.0f, 1e-3f);
    EXPECT_EQ(view.distance_key(cube(glm::vec3{0.0f}, 1.0f)), 0.0f);
    // A big box is as near as its nearest point, not as its centre.
    EXPECT_LT(view.distance_key(cube({0.0f, 0.0f, -50.0f}, 49.0f)),
              view.distance_key(cube({0.0f, 0.0f, -5.0f}, 1.0f)));
}

TEST(View, DistanceKeyPutsUnboundedFirstAndEmptyLast)
{
    const View ortho =
        View::from_clip(glm::orthoRH_NO(-5.0f, 5.0f, -5.0f, 5.0f, 1.0f, 50.0f), kSize);
    for (const View& view : {down_z(60.0f, 0.1f), ortho}) {
        const float ordinary = view.distance_key(cube({0.0f, 0.0f, 900.0f}, 1.0f));
        EXPECT_LT(view.distance_key(Aabb::everything()), ordinary);
        EXPECT_LT(view.distance_key({glm::vec3{kNan}, glm::vec3{1.0f}}), ordinary);
        EXPECT_GT(view.distance_key(Aabb::empty()), ordinary);
    }
}

TEST(View, OrthographicDistanceKeyGrowsAlongTheViewDirection)
{
    Rng rng(47);
    for (const Projection& projection : test::all_projections()) {
        if (!projection.orthographic) {
            continue;
        }
        const glm::mat4 eye_from_world = test::random_eye_from_world(rng, 10.0f);
        const View view = View::from_clip(projection.clip_from_eye * eye_from_world, kSize,
                                          projection.convention);
        for (int i = 0; i < 200; ++i) {
            const Aabb a = test::random_box(rng, 50.0f, 10.0f);
            const Aabb b = test::random_box(rng, 50.0f, 10.0f);
            const auto nearest = [&](const Aabb& box) {
                float z = -kInf;
                for (int k = 0; k < 8; ++k) {
                    const glm::vec4 p{test::corner(box, k), 1.0f};
                    z = std::max(z, (eye_from_world * p).z);
                }
                return -z;
            };
            if (nearest(a) + 1e-3f < nearest(b)) {
                EXPECT_LT(view.distance_key(a), view.distance_key(b)) << projection.name;
            }
            // World units beyond the near plane.
            EXPECT_NEAR(view.distance_key(a), nearest(a) - 0.1f, 1e-3f) << projection.name;
        }
    }
}

TEST(View, KeepsItsViewportItsTagAndWhatItIgnores)
{
    const glm::mat4 clip = glm::perspectiveRH_NO(1.0f, 1.5f, 0.1f, 100.0f);
    const ViewOptions options{
        .viewport_origin_px = {640, 8}, .tag = 77, .ignores_near_plane = true};
    for (const View& view :
         {View::from_clip(clip, kSize, {}, options),
          View::camera_relative(clip, glm::dvec3{1e7}, kSize, {}, options),
          View::from_clip(clip, kSize, {}, options).in_object(glm::mat4{2.0f})}) {
        EXPECT_EQ(view.options(), options);
        EXPECT_EQ(view.viewport_origin_px(), glm::ivec2(640, 8));
        EXPECT_EQ(view.tag(), 77u);
        EXPECT_TRUE(view.ignores_near_plane());
    }
    EXPECT_EQ(View::from_clip(clip, kSize).options(), ViewOptions{});
}

TEST(View, NoBoxInsideOfAnotherTouchesUnlessTheOtherDoes)
{
    Rng rng(73);
    int touching = 0;
    int cases = 0;
    for (const float scale : {1e-6f, 1.0f, 3e6f, 1e9f}) {
        for (const Projection& projection : test::all_projections()) {
            const glm::mat4 clip = projection.clip_from_eye * test::random_eye_from_world(rng, 5) *
                                   glm::scale(glm::mat4{1.0f}, glm::vec3{1.0f / scale});
            const View view = View::from_clip(clip, kSize, projection.convention);
            for (int i = 0; i < 300; ++i) {
                Aabb whole = test::random_box(rng, 6.0f * scale, 3.0f * scale);
                const glm::vec3 size = whole.extent();
                Aabb part = whole;
                for (int axis = 0; axis < 3; ++axis) {
                    part.min[axis] += rng.below(3) == 0 ? 0.0f : rng.range(0.0f, 0.4f) * size[axis];
                    part.max[axis] = std::max(
                        part.min[axis],
                        part.max[axis] -
                            (rng.below(3) == 0 ? 0.0f : rng.range(0.0f, 0.4f) * size[axis]));
                }
                const Aabb grown = view.inflated_for_test(whole);
                const Aabb grown_part = view.inflated_for_test(part);
                EXPECT_TRUE(contains(grown, grown_part)) << projection.name << " x " << scale;
                EXPECT_TRUE(view.touches_near(grown) || !view.touches_near(grown_part))
                    << projection.name << " x " << scale;
                touching += view.touches_near(grown) ? 1 : 0;
                ++cases;
            }
        }
    }
    EXPECT_GT(touching, cases / 10);
    EXPECT_LT(touching, 9 * cases / 10);
}

TEST(View, IgnoringTheNearPlaneKeepsWhatIsBeforeIt)
{
    const ViewOptions clamped{.ignores_near_plane = true};
    const Aabb before = cube({0.0f, 0.0f, 5.0f}, 1.0f);
    const Aabb across = cube({0.0f, 0.0f, -1.0f}, 0.5f);
    const glm::mat4 ortho = glm::orthoRH_ZO(-5.0f, 5.0f, -5.0f, 5.0f, 1.0f, 50.0f);
    const View clipping = View::from_clip(ortho, kSize, test::kVulkan);
    const View keeping = View::from_clip(ortho, kSize, test::kVulkan, clamped);
    EXPECT_EQ(clipping.frustum().classify(before), Containment::outside);
    EXPECT_EQ(keeping.frustum().classify(before), Containment::inside);
    EXPECT_TRUE(clipping.touches_near(across));
    EXPECT_FALSE(keeping.touches_near(across));
    EXPECT_EQ(keeping.frustum().classify(cube({0.0f, 0.0f, -90.0f}, 1.0f)), Containment::outside);

    // Perspective: only boxes around the eye touch; nothing behind the eye is visible.
    const glm::mat4 perspective = glm::perspectiveRH_NO(1.0f, 1.5f, 2.0f, 100.0f);
    const View view = View::from_clip(perspective, kSize, {}, clamped);
    EXPECT_NE(view.frustum().classify(cube({0.0f, 0.0f, -1.0f}, 0.2f)), Containment::outside);
    EXPECT_FALSE(view.touches_near(cube({0.0f, 0.0f, -1.0f}, 0.2f)));
    EXPECT_TRUE(view.touches_near(cube(glm::vec3{0.0f}, 0.2f)));
    EXPECT_EQ(view.frustum().classify(cube({0.0f, 0.0f, 5.0f}, 0.2f)), Containment::outside);
}

TEST(View, InObjectSeesTheSameCamera)
{
    Rng rng(89);
    for (const Projection& projection : test::all_projections()) {
        const View view =
            View::from_clip(projection.clip_from_eye * test::random_eye_from_world(rng, 10.0f),
                            kSize, projection.convention);
        glm::mat4 map = glm::translate(glm::mat4{1.0f}, {3.0f, -8.0f, 5.0f});
        map = glm::rotate(map, 0.7f, glm::normalize(glm::vec3{1.0f, 2.0f, 3.0f}));
        map = glm::scale(map, {-2.0f, 0.5f, 1.5f});
        const View own = view.in_object(map);
        for (int i = 0; i < 200; ++i) {
            const glm::vec3 p{rng.range(-9, 9), rng.range(-9, 9), rng.range(-9, 9)};
            const glm::dvec4 world = glm::dmat4{map} * glm::dvec4{p, 1.0};
            const glm::dvec4 expected =
                view.clip_from_relative() * (world - glm::dvec4{view.origin(), 0.0});
            const glm::dvec4 c =
                own.clip_from_relative() * glm::dvec4{glm::dvec3{p} - own.origin(), 1.0};
            EXPECT_LT(glm::length(c - expected), 1e-9 * (1.0 + glm::length(expected)));
            const glm::vec3 reach{glm::abs(glm::dvec3{p} - own.origin())};
            const glm::vec3 reach_world{glm::abs(glm::dvec3{world} - view.origin())};
            EXPECT_GE(own.clip_rounding(reach).w, 0.999f * view.clip_rounding(reach_world).w);
        }
    }
    EXPECT_FALSE(down_z(60.0f, 0.1f).in_object(glm::mat4{0.0f}).usable());
}

} // namespace
} // namespace occlude
