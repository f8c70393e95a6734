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
// are 7.68 near distances away, so a box beside the eye that a test of the near *distance* lets
// through is cut by the near rectangle.
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

TEST(View, InflatedBoxContainsTheBoxAndKeepsOddBoxes)
{
    const View view = down_z(60.0f, 0.1f);
    EXPECT_TRUE(view.inflated_for_test(Aabb::empty()).is_empty());
    EXPECT_EQ(view.inflated_for_test(Aabb::everything()), Aabb::everything());
    EXPECT_TRUE(view.inflated_for_test({glm::vec3{kNan}, glm::vec3{1.0f}}).has_nan());

    Rng rng(53);
    for (const float extent : {1e-3f, 10.0f, 1e6f}) {
        for (int i = 0; i < 500; ++i) {
            const Aabb box = test::random_box(rng, extent, extent);
            const Aabb grown = view.inflated_for_test(box);
            for (int axis = 0; axis < 3; ++axis) {
                EXPECT_LT(grown.min[axis], box.min[axis]);
                EXPECT_GT(grown.max[axis], box.max[axis]);
            }
        }
    }
}

TEST(View, FlatBoxGetsThickness)
{
    const Aabb flat{glm::vec3{-1.0f, -1.0f, -10.0f}, glm::vec3{1.0f, 1.0f, -10.0f}};
    EXPECT_GT(down_z(60.0f, 0.1f).inflated_for_test(flat).extent().z, 0.0f);
}

/// The corner of `box` that lies farthest in direction `u` on the screen, in pixels; only for boxes
/// wholly before the eye.
double farthest_px(const Aabb& box, const glm::dmat4& clip, glm::ivec2 size_px, const glm::dvec2& u)
{
    double farthest = -std::numeric_limits<double>::infinity();
    for (int k = 0; k < 8; ++k) {
        const glm::dvec4 c = clip * glm::dvec4{test::corner(box, k), 1.0};
        const glm::dvec2 px = 0.5 * glm::dvec2{c} / c.w * glm::dvec2{size_px};
        farthest = std::max(farthest, glm::dot(px, u));
    }
    return farthest;
}

bool on_screen(const Aabb& box, const glm::dmat4& clip, ClipConvention convention)
{
    for (int k = 0; k < 8; ++k) {
        const glm::dvec4 c = clip * glm::dvec4{test::corner(box, k), 1.0};
        if (test::clip_margin(c, convention) < 0.0) {
            return false;
        }
    }
    return true;
}

void check_pixels(const Projection& projection, float extent, glm::ivec2 size_px, uint64_t seed)
{
    Rng rng(seed);
    const glm::mat4 to_50 = glm::scale(glm::mat4{1.0f}, glm::vec3{50.0f / extent});
    int tested = 0;
    for (int i = 0; i < 3000; ++i) {
        const glm::mat4 clip =
            projection.clip_from_eye * test::random_eye_from_world(rng, 10.0f) * to_50;
        const View view = View::from_clip(clip, size_px, projection.convention);
        const Aabb box = test::random_box(rng, 0.6f * extent, 0.1f * extent);
        if (!on_screen(box, glm::dmat4{clip}, projection.convention)) {
            continue;
        }
        const Aabb grown = view.inflated_for_test(box);
        if (view.touches_near(grown)) {
            continue;
        }
        ++tested;
        for (int k = 0; k < 16; ++k) {
            const double angle = k * 0.39269908169872414;
            const glm::dvec2 u{std::cos(angle), std::sin(angle)};
            ASSERT_GE(farthest_px(grown, glm::dmat4{clip}, size_px, u) -
                          farthest_px(box, glm::dmat4{clip}, size_px, u),
                      1.0 / 256.0)
                << projection.name << ", seed " << seed << ", box " << i << ", direction " << k;
        }
    }
    EXPECT_GT(tested, 100) << projection.name;
}

TEST(View, InflationIsAtLeastA256thOfAPixelInEveryDirection)
{
    for (const Projection& projection : test::all_projections()) {
        check_pixels(projection, 50.0f, kSize, 61);
        check_pixels(projection, 50.0f, {64, 2048}, 62); // pixels that are not square
    }
}

TEST(View, InflationIsEnoughInTinyAndHugeScenes)
{
    for (const Projection& projection : test::all_projections()) {
        check_pixels(projection, 1e-3f, kSize, 63);
        check_pixels(projection, 1e6f, kSize, 64);
    }
}

// An off-centre and very wide frustum: rows of x and w are far from perpendicular, so that the
// length of the row says little about how far a pixel is.
TEST(View, InflationIsEnoughUnderAWideOffCentreFrustum)
{
    const Projection wide{"wide off-centre",
                          glm::frustumRH_NO(-0.05f, 1.95f, -0.1f, 0.1f, 0.1f, 100.0f),
                          test::kOpenGl};
    check_pixels(wide, 50.0f, {512, 512}, 65);
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

// The same camera, handed over both ways: the same frustum, keys and answers.
TEST(View, CameraRelativeIsTheSameCamera)
{
    Rng rng(71);
    for (const Projection& projection : test::all_projections()) {
        const glm::mat4 eye_from_world = test::random_eye_from_world(rng, 20.0f);
        const glm::dvec3 eye{glm::inverse(glm::dmat4{eye_from_world})[3]};
        const glm::mat4 turned{glm::mat3{eye_from_world}};
        const View absolute = View::from_clip(projection.clip_from_eye * eye_from_world, kSize,
                                              projection.convention);
        const View relative = View::camera_relative(projection.clip_from_eye * turned, eye, kSize,
                                                    projection.convention);
        EXPECT_EQ(relative.orthographic(), absolute.orthographic());
        for (int i = 0; i < 300; ++i) {
            const Aabb box = test::random_box(rng, 40.0f, 10.0f);
            const float key = absolute.distance_key(box);
            EXPECT_NEAR(relative.distance_key(box), key, 1e-3f * (1.0f + std::abs(key)));
            EXPECT_EQ(relative.frustum().classify(box), absolute.frustum().classify(box));
            EXPECT_EQ(relative.touches_near(box), absolute.touches_near(box));
            // Drawn in world coordinates, positions round more.
            EXPECT_LE(relative.inflation().margin(box), absolute.inflation().margin(box) * 1.0001f);
        }
    }
}

// 1e7 units away, float counts in steps of 1 and the matrix of the world moves the camera by as
// much. Relative to the eye nothing of that is left but the rounding of the boxes.
TEST(View, CameraRelativeKeepsItsPrecisionFarFromTheOrigin)
{
    const glm::dvec3 eye{1e7 + 0.25, -3e6 + 0.5, 2e6 - 0.125};
    const View view =
        View::camera_relative(glm::perspectiveRH_NO(1.0f, 1.5f, 0.1f, 100.0f), eye, kSize);
    const glm::vec3 ahead{eye + glm::dvec3{0.0, 0.0, -20.0}};
    const Aabb box{ahead - 1.0f, ahead + 1.0f};
    EXPECT_EQ(view.frustum().classify(box), Containment::inside);
    EXPECT_FALSE(view.touches_near(view.inflated_for_test(box)));
    EXPECT_LT(view.inflation().margin(box), 0.01f);
    const glm::vec3 beside{eye + glm::dvec3{40.0, 0.0, -20.0}};
    EXPECT_EQ(view.frustum().classify({beside - 1.0f, beside + 1.0f}), Containment::outside);
    // In world coordinates the same box would have to grow by more than its size.
    glm::dmat4 world{view.clip_from_relative()};
    world[3] = world * glm::dvec4{-eye, 1.0};
    EXPECT_GT(View::from_clip(glm::mat4{world}, kSize).inflation().margin(box), 10.0f);
}

// The eye lies between two floats there. What touches the near rectangle does so at any distance
// from zero: the same boxes and the same eye, 1e7 units nearer to zero, say what is right.
TEST(View, CameraRelativeKnowsTheNearRectangleFarFromTheOrigin)
{
    Rng rng(88);
    const glm::mat4 clip = glm::perspectiveRH_NO(1.0f, 1.5f, 2.0f, 100.0f);
    const glm::dvec3 far_away{1e7, -3e6, 2e6};
    int touching = 0;
    int free = 0;
    for (int i = 0; i < 4000; ++i) {
        const glm::dvec3 eye{rng.range(0.0f, 1.0f), rng.range(0.0f, 1.0f), rng.range(0.0f, 1.0f)};
        const glm::vec3 low{static_cast<float>(rng.below(7)) - 3.0f,
                            static_cast<float>(rng.below(7)) - 3.0f,
                            static_cast<float>(rng.below(7)) - 6.0f};
        const Aabb box{low, low + 1.0f};
        const Aabb far_box{glm::vec3{glm::dvec3{box.min} + far_away},
                           glm::vec3{glm::dvec3{box.max} + far_away}};
        const bool touches = View::camera_relative(clip, eye, kSize)
                                 .touches_near({box.min + 1e-3f, box.max - 1e-3f});
        const View far_view = View::camera_relative(clip, eye + far_away, kSize);
        touching += touches ? 1 : 0;
        free += far_view.touches_near(far_box) ? 0 : 1;
        ASSERT_TRUE(!touches || far_view.touches_near(far_box)) << "box " << i;
    }
    EXPECT_GT(touching, 100);
    EXPECT_GT(free, 1000);
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

// The proof of docs/conventions.md, in long double: at constant w, window depth changes by no more
// than depth_bias over the 1/64 pixel that boxes grow by, in any direction; and under an oblique
// near plane it does change.
TEST(View, DepthBiasIsWhatOne64thOfAPixelCanChange)
{
    using Real = long double;
    Rng rng(79);
    const auto window_depth = [](const View& view, const glm::vec<3, Real>& relative) {
        const glm::mat<4, 4, Real> clip{view.clip_from_relative()};
        const glm::vec<4, Real> c = clip * glm::vec<4, Real>{relative, Real{1}};
        const bool symmetric = view.convention().range == DepthRange::minus_one_to_one;
        return glm::vec<3, Real>{c.x / c.w * Real{0.5} * Real(view.size_px().x),
                                 c.y / c.w * Real{0.5} * Real(view.size_px().y),
                                 symmetric ? Real{0.5} * (c.z / c.w + 1) : c.z / c.w};
    };
    int tilted = 0;
    for (const Projection& projection : test::all_projections()) {
        const View view =
            View::from_clip(projection.clip_from_eye * test::random_eye_from_world(rng, 10.0f),
                            kSize, projection.convention);
        const glm::mat<4, 4, Real> rows =
            glm::transpose(glm::mat<4, 4, Real>{view.clip_from_relative()});
        const glm::vec<3, Real> toward_w{rows[3]};
        double steepest = 0.0;
        for (int i = 0; i < 2000; ++i) {
            const glm::vec<3, Real> p{rng.range(-40, 40), rng.range(-40, 40), rng.range(-40, 40)};
            const Real w = glm::dot(toward_w, p) + rows[3].w;
            if (w < Real{0.5}) {
                continue;
            }
            // A step at constant w, scaled to 1/64 pixel.
            glm::vec<3, Real> step{rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1)};
            if (glm::dot(toward_w, toward_w) > Real{1e-12}) {
                step -= toward_w * (glm::dot(step, toward_w) / glm::dot(toward_w, toward_w));
            } else { // orthographic: the step across the screen, not along the view
                const glm::vec<3, Real> x{rows[0]};
                const glm::vec<3, Real> y{rows[1]};
                step = x * step.x / glm::dot(x, x) + y * step.y / glm::dot(y, y);
            }
            const auto from = window_depth(view, p);
            const auto to = window_depth(view, p + step);
            const Real moved = std::max(std::abs(to.x - from.x), std::abs(to.y - from.y));
            const Real change = std::abs(to.z - from.z) / (64 * moved);
            EXPECT_LE(static_cast<double>(change), double{view.inflation().depth_bias} + 1e-12)
                << projection.name;
            steepest = std::max(steepest, static_cast<double>(change));
        }
        if (std::string_view{projection.name} == "oblique") {
            EXPECT_GT(steepest, 0.5 * double{view.inflation().depth_bias});
            EXPECT_GT(view.inflation().depth_bias, 1e-7f);
            ++tilted;
        } else {
            EXPECT_LT(view.inflation().depth_bias, 1e-8f) << projection.name;
        }
    }
    EXPECT_EQ(tilted, 1);
}

// Far from the origin, drawn in world coordinates: positions transformed in float, as a device does
// it, differ from those in long double by no more than clip_rounding() says, and not by much less.
TEST(View, ClipRoundingBoundsWhatFloatDoes)
{
    using Real = long double;
    Rng rng(83);
    for (const float distance : {0.0f, 1e3f, 1e5f, 1e7f}) {
        double worst = 0.0;
        for (const Projection& projection : test::all_projections()) {
            const glm::vec3 away{distance, -0.5f * distance, 0.25f * distance};
            const glm::mat4 clip = glm::mat4{glm::dmat4{projection.clip_from_eye} *
                                             glm::dmat4{test::random_eye_from_world(rng, 10.0f)} *
                                             glm::translate(glm::dmat4{1.0}, -glm::dvec3{away})};
            const View view = View::from_clip(clip, kSize, projection.convention);
            if (!view.usable()) {
                continue; // float left no near plane: nothing is hidden there
            }
            for (int i = 0; i < 500; ++i) {
                const glm::vec3 p =
                    away + glm::vec3{rng.range(-40, 40), rng.range(-40, 40), rng.range(-40, 40)};
                const glm::vec4 in_float = clip * glm::vec4{p, 1.0f};
                const glm::vec<4, Real> exact =
                    glm::mat<4, 4, Real>{clip} * glm::vec<4, Real>{glm::vec<3, Real>{p}, Real{1}};
                const glm::vec3 reach{glm::abs(glm::dvec3{p} - view.origin())};
                const glm::vec4 bound = view.clip_rounding(reach);
                for (int row = 0; row < 4; ++row) {
                    const auto off =
                        static_cast<double>(std::abs(Real(in_float[row]) - exact[row]));
                    EXPECT_LE(off, double{bound[row]}) << projection.name << ", " << distance;
                    worst = std::max(worst, bound[row] > 0.0f ? off / double{bound[row]} : 0.0);
                }
            }
        }
        EXPECT_GT(worst, 0.02) << "at " << distance << " the bound means nothing";
    }
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

    // Perspective: only what is around the eye touches; nothing behind it is seen.
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

TEST(View, InflatedPartsLieInTheInflatedWhole)
{
    const View view = down_z(60.0f, 0.1f);
    Rng rng(67);
    for (int i = 0; i < 1000; ++i) {
        const Aabb whole = test::random_box(rng, 50.0f, 50.0f);
        const Aabb part{whole.min, whole.min + rng.range(0.0f, 1.0f) * whole.extent()};
        EXPECT_TRUE(contains(view.inflated_for_test(whole), view.inflated_for_test(part)));
    }
}

} // namespace
} // namespace occlude
