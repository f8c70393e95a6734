#include <occlude/screen/projection.h>
#include <occlude/screen/screen_box.h>

#include "screen/projections.h"

#include <glm/common.hpp>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string_view>

namespace occlude {
namespace {

using test::Projection;

constexpr glm::ivec2 kSize{640, 360};

View down_z(glm::ivec2 size = {100, 100})
{
    return View::from_clip(glm::perspectiveRH_NO(glm::radians(90.0f), 1.0f, 1.0f, 101.0f), size);
}

// 90 degrees over 100 pixels: at distance 10 one pixel is 0.2 wide and the middle is pixel 50.
TEST(Projection, ABoxBeforeTheCameraHasTheRectangleOfItsFrontFace)
{
    const ScreenBounds b = project(down_z(), {{1.01f, 2.01f, -20.0f}, {2.99f, 3.99f, -10.0f}});
    EXPECT_TRUE(b.valid);
    // Left and bottom are nearest the middle on the back face: 50 + 50 * 1.01 / 20 = 52.5.
    EXPECT_EQ(b.rect, (PixelRect{52, 55, 13, 15}));
    // Window depth of distance d: (101 / 100) * (1 - 1 / d), beside 1/64 pixel of inflation.
    EXPECT_NEAR(b.near_depth, 1.01f * 0.9f, 1e-4f);
    EXPECT_NEAR(b.far_depth, 1.01f * 0.95f, 1e-4f);
    EXPECT_LT(b.near_depth, 1.01f * 0.9f - 0.9f * ScreenBounds::kDepthMargin);
    EXPECT_GT(b.far_depth, 1.01f * 0.95f + 0.9f * ScreenBounds::kDepthMargin);
}

TEST(Projection, ThePixelThatABoxOnlyGrazesBelongsToItsRectangle)
{
    // The left face at pixel edge 55 exactly: what lies in it may be snapped to either side.
    const ScreenBounds b = project(down_z(), {{1.0f, 0.1f, -10.0f}, {1.1f, 0.15f, -10.0f}});
    EXPECT_EQ(b.rect.x, 54);
    EXPECT_EQ(b.rect.x + b.rect.width, 56);
}

TEST(Projection, WhereSamplesAreInTheMiddleOfPixelsABoxBetweenThemHasNoPixels)
{
    const auto centers = [](const Aabb& box) {
        return project(down_z(), box, SamplePositions::center);
    };
    // From 55.1 to 55.4 px along x, and 1/64 more. To 55.49, which that margin takes across the
    // middle.
    const ScreenBounds between = centers({{1.02f, 0.0f, -10.0f}, {1.08f, 1.0f, -10.0f}});
    EXPECT_TRUE(between.valid);
    EXPECT_EQ(between.rect, (PixelRect{}));
    EXPECT_EQ(centers({{1.02f, 0.0f, -10.0f}, {1.098f, 1.0f, -10.0f}}).rect,
              (PixelRect{55, 50, 1, 5}));
    // The middle of pixel 57 is at 57.5.
    EXPECT_EQ(centers({{1.02f, 0.02f, -10.0f}, {1.52f, 1.0f, -10.0f}}).rect,
              (PixelRect{55, 50, 3, 5}));
    EXPECT_EQ(centers({{-50.0f, -50.0f, -20.0f}, {50.0f, 50.0f, -10.0f}}).rect,
              (PixelRect{0, 0, 100, 100}));
}

TEST(Projection, RectanglesEndAtTheTarget)
{
    const ScreenBounds b = project(down_z(), {{-500.0f, -1.0f, -20.0f}, {500.0f, 500.0f, -10.0f}});
    EXPECT_TRUE(b.valid);
    EXPECT_EQ(b.rect, (PixelRect{0, 44, 100, 56}));
}

TEST(Projection, ABoxBesideTheTargetHasAnEmptyRectangle)
{
    for (const Aabb& box : {Aabb{{30.0f, 0.0f, -20.0f}, {40.0f, 1.0f, -10.0f}},
                            Aabb{{0.0f, -40.0f, -20.0f}, {1.0f, -30.0f, -10.0f}}, Aabb::empty()}) {
        const ScreenBounds b = project(down_z(), box);
        EXPECT_TRUE(b.valid);
        EXPECT_EQ(b.rect, (PixelRect{}));
    }
}

TEST(Projection, BeyondTheFarPlaneDepthStopsAtOne)
{
    const ScreenBounds b = project(down_z(), {{-1.0f, -1.0f, -500.0f}, {1.0f, 1.0f, -50.0f}});
    EXPECT_TRUE(b.valid);
    EXPECT_LT(b.near_depth, 1.0f);
    EXPECT_EQ(b.far_depth, 1.0f);
    EXPECT_EQ(project(down_z(), {{-1.0f, -1.0f, -500.0f}, {1.0f, 1.0f, -200.0f}}).near_depth, 1.0f);
}

TEST(Projection, WhatTheNearPlaneOrTheEyeMayTouchIsInvalidAndEverywhere)
{
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const Aabb& box : {Aabb{{-1.0f, -1.0f, -5.0f}, {1.0f, 1.0f, 5.0f}},      // around the eye
                            Aabb{{-1.0f, -1.0f, -5.0f}, {1.0f, 1.0f, -0.99f}},    // across near
                            Aabb{{-1.0f, -1.0f, -5.0f}, {1.0f, 1.0f, -1.00001f}}, // by inflation
                            Aabb{{-50.0f, -9.0f, -50.0f}, {50.0f, -8.0f, 50.0f}}, // a floor
                            Aabb::everything(), Aabb{{nan, 0.0f, -9.0f}, {1.0f, 1.0f, -8.0f}}}) {
        const ScreenBounds b = project(down_z(), box);
        EXPECT_FALSE(b.valid);
        EXPECT_EQ(b.rect, (PixelRect{0, 0, 100, 100}));
        EXPECT_EQ(b.near_depth, 0.0f);
        EXPECT_EQ(b.far_depth, 1.0f);
    }
    EXPECT_TRUE(project(down_z(), {{-1.0f, -1.0f, -5.0f}, {1.0f, 1.0f, -1.01f}}).valid);
}

TEST(Projection, UnderADegenerateViewNothingIsValid)
{
    const Aabb box{{-1.0f, -1.0f, -5.0f}, {1.0f, 1.0f, -4.0f}};
    EXPECT_FALSE(project(View{}, box).valid);
    EXPECT_FALSE(project(View::from_clip(glm::mat4{0.0f}, {64, 64}), box).valid);
    const ScreenBounds b = project(View::from_clip(glm::mat4{1.0f}, {-3, 5}), box);
    EXPECT_FALSE(b.valid);
    EXPECT_EQ(b.rect, (PixelRect{0, 0, 0, 5}));
}

// Window depth and pixel of a point as a device computes them: everything in float.
struct FloatDevice {
    glm::mat4 clip;
    ClipConvention convention;

    glm::vec3 window(const glm::vec3& p) const
    {
        const glm::vec4 c = clip * glm::vec4{p, 1.0f};
        const glm::vec3 ndc = glm::vec3{c} / c.w;
        const float z =
            convention.range == DepthRange::minus_one_to_one ? 0.5f * ndc.z + 0.5f : ndc.z;
        return {(0.5f * ndc.x + 0.5f) * static_cast<float>(kSize.x),
                (0.5f * ndc.y + 0.5f) * static_cast<float>(kSize.y),
                convention.order == DepthOrder::near_is_large ? 1.0f - z : z};
    }
};

// The rectangle of middles must contain every pixel whose middle lies between corners of the box,
// along both axes.
void check_middles(const FloatDevice& device, const Aabb& box, const ScreenBounds& middles,
                   const ScreenBounds& anywhere)
{
    glm::vec2 low{1e30f};
    glm::vec2 high{-1e30f};
    for (int k = 0; k < 8; ++k) {
        const glm::vec2 w{device.window(test::corner(box, k))};
        low = glm::min(low, w);
        high = glm::max(high, w);
    }
    const glm::ivec2 first{glm::max(glm::ceil(glm::dvec2{low} - 0.5), 0.0)};
    const glm::ivec2 past{glm::min(glm::floor(glm::dvec2{high} - 0.5) + 1.0, glm::dvec2{kSize})};
    const PixelRect& r = middles.rect;
    if (first.x < past.x && first.y < past.y) {
        ASSERT_LE(r.x, first.x);
        ASSERT_LE(r.y, first.y);
        ASSERT_GE(r.x + r.width, past.x);
        ASSERT_GE(r.y + r.height, past.y);
    }
    ASSERT_EQ(middles.near_depth, anywhere.near_depth);
    ASSERT_EQ(middles.far_depth, anywhere.far_depth);
    if (r.width > 0) {
        ASSERT_GE(r.x, anywhere.rect.x);
        ASSERT_GE(r.y, anywhere.rect.y);
        ASSERT_LE(r.x + r.width, anywhere.rect.x + anywhere.rect.width);
        ASSERT_LE(r.y + r.height, anywhere.rect.y + anywhere.rect.height);
    }
}

void check_points(const Projection& projection, const glm::vec3& origin, float extent,
                  uint64_t seed)
{
    Rng rng(seed);
    int valid = 0;
    int tight = 0;
    for (int i = 0; i < 2000; ++i) {
        const glm::mat4 clip = projection.clip_from_eye * test::random_eye_from_world(rng, extent) *
                               glm::translate(glm::mat4{1.0f}, -origin);
        const View view = View::from_clip(clip, kSize, projection.convention);
        const FloatDevice device{clip, projection.convention};
        Aabb box = test::random_box(rng, extent, 0.2f * extent);
        box.min += origin;
        box.max += origin;
        const ScreenBounds b = project(view, box);
        if (!b.valid) {
            continue;
        }
        ++valid;
        const ScreenBounds middles = project(view, box, SamplePositions::center);
        ASSERT_TRUE(middles.valid);
        ASSERT_NO_FATAL_FAILURE(check_middles(device, box, middles, b))
            << projection.name << ", seed " << seed << ", box " << i;
        tight += b.rect.width < kSize.x / 2 ? 1 : 0;
        for (int k = 0; k < 24; ++k) {
            const glm::vec3 p =
                k < 8 ? test::corner(box, k)
                      : glm::vec3{rng.range(box.min.x, box.max.x), rng.range(box.min.y, box.max.y),
                                  rng.range(box.min.z, box.max.z)};
            const glm::vec3 w = device.window(p);
            if (w.x < 0.0f || w.y < 0.0f || w.x >= static_cast<float>(kSize.x) ||
                w.y >= static_cast<float>(kSize.y) || w.z > 1.0f) {
                continue;
            }
            const glm::ivec2 pixel{static_cast<int>(w.x), static_cast<int>(w.y)};
            ASSERT_TRUE(pixel.x >= b.rect.x && pixel.x < b.rect.x + b.rect.width &&
                        pixel.y >= b.rect.y && pixel.y < b.rect.y + b.rect.height)
                << projection.name << ", seed " << seed << ", box " << i << ", point " << k;
            ASSERT_TRUE(w.z >= b.near_depth && w.z <= b.far_depth)
                << projection.name << ", seed " << seed << ", box " << i << ", point " << k
                << ": depth " << w.z << " not in " << b.near_depth << " .. " << b.far_depth;
        }
    }
    EXPECT_GT(valid, 100) << projection.name;
    EXPECT_GT(tight, valid / 4) << projection.name;
}

TEST(Projection, BoundsHoldEveryPointOfTheBoxUnderEveryProjection)
{
    for (const Projection& projection : test::all_projections()) {
        check_points(projection, glm::vec3{0.0f}, 20.0f, 71);
    }
}

TEST(Projection, BoundsHoldFarFromTheOriginWhereFloatsAreCoarse)
{
    for (const Projection& projection : test::all_projections()) {
        check_points(projection, {4000.0f, -7000.0f, 300.0f}, 20.0f, 72);
    }
}

// 1e7 units away the eye lies between two floats. Boxes are taken relative to the exact eye:
// relative to the float beside it, their rectangles are off by up to half a unit.
TEST(Projection, BoundsHoldEveryPointWhereTheEyeLiesBetweenTwoFloats)
{
    Rng rng(74);
    int pixels = 0;
    for (int i = 0; i < 2000; ++i) {
        const glm::dvec3 eye =
            glm::dvec3{1e7, -3e6, 2e6} +
            glm::dvec3{rng.range(0.0f, 1.0f), rng.range(0.0f, 1.0f), rng.range(0.0f, 1.0f)};
        const View view = View::camera_relative(glm::perspectiveRH_ZO(1.0f, 1.5f, 0.1f, 100.0f),
                                                eye, kSize, test::kVulkan);
        const glm::vec3 low{eye + glm::dvec3{rng.range(-12.0f, 12.0f), rng.range(-8.0f, 8.0f),
                                             rng.range(-40.0f, -6.0f)}};
        const Aabb box{low, low + glm::vec3{1.0f, 1.0f, 1.0f}};
        for (const SamplePositions samples : {SamplePositions::anywhere, SamplePositions::center}) {
            const ScreenBounds b = project(view, box, samples);
            const ScreenBox faces{ScreenSpace{view, samples}, box};
            ASSERT_TRUE(b.valid) << i;
            for (int k = 0; k < 24; ++k) { // points of the box that are in the middle of a pixel
                const glm::dvec3 inside =
                    glm::mix(glm::dvec3{box.min}, glm::dvec3{box.max},
                             glm::dvec3{rng.range(0.0f, 1.0f), rng.range(0.0f, 1.0f),
                                        rng.range(0.0f, 1.0f)});
                const glm::dvec4 clip = view.clip_from_relative() * glm::dvec4{inside - eye, 1.0};
                const glm::dvec2 at = (0.5 * glm::dvec2{clip} / clip.w + 0.5) * glm::dvec2{kSize};
                const glm::ivec2 pixel{glm::floor(at)};
                const bool on_screen =
                    at.x >= 0.0 && at.y >= 0.0 && pixel.x < kSize.x && pixel.y < kSize.y;
                const glm::dvec2 middle = glm::dvec2{pixel} + 0.5;
                const bool near_middle = glm::distance(at, middle) < 0.02;
                if (!on_screen || (samples == SamplePositions::center && !near_middle)) {
                    continue;
                }
                ++pixels;
                ASSERT_TRUE(pixel.x >= b.rect.x && pixel.x < b.rect.x + b.rect.width &&
                            pixel.y >= b.rect.y && pixel.y < b.rect.y + b.rect.height)
                    << "box " << i << ", point " << k;
                ASSERT_GE(clip.z / clip.w, double{b.near_depth}) << "box " << i;
                ASSERT_LE(clip.z / clip.w, double{b.far_depth}) << "box " << i;
                if (samples == SamplePositions::anywhere) {
                    ASSERT_GE(clip.z / clip.w, faces.nearest_over(pixel, pixel)) << "box " << i;
                }
            }
        }
    }
    EXPECT_GT(pixels, 10000);
}

TEST(Projection, ALargerBoxHasLargerBounds)
{
    Rng rng(73);
    const View view = down_z(kSize);
    int compared = 0;
    for (int i = 0; i < 2000; ++i) {
        Aabb whole = test::random_box(rng, 40.0f, 30.0f);
        const Aabb part{whole.min, whole.min + rng.range(0.0f, 1.0f) * whole.extent()};
        const ScreenBounds w = project(view, whole);
        const ScreenBounds p = project(view, part);
        if (!w.valid) {
            continue;
        }
        ++compared;
        ASSERT_TRUE(p.valid);
        ASSERT_LE(w.near_depth, p.near_depth + 0x1p-23f); // floats round, the margin is larger
        ASSERT_GE(w.far_depth, p.far_depth - 0x1p-23f);
        if (p.rect.width > 0) {
            ASSERT_LE(w.rect.x, p.rect.x);
            ASSERT_LE(w.rect.y, p.rect.y);
            ASSERT_GE(w.rect.x + w.rect.width, p.rect.x + p.rect.width);
            ASSERT_GE(w.rect.y + w.rect.height, p.rect.y + p.rect.height);
        }
    }
    EXPECT_GT(compared, 500);
}

TEST(Rectangle, CoversItsPixelsAtNoMoreThanItsDepthUnderEveryProjection)
{
    Rng rng(81);
    for (const Projection& projection : test::all_projections()) {
        int found = 0;
        int wanted = 0;
        for (int i = 0; i < 500; ++i) {
            const glm::mat4 clip =
                projection.clip_from_eye * test::random_eye_from_world(rng, 20.0f);
            const View view = View::from_clip(clip, kSize, projection.convention);
            const FloatDevice device{clip, projection.convention};
            const ScreenBounds b = project(view, test::random_box(rng, 20.0f, 4.0f));
            if (!b.valid || b.rect.width == 0) {
                continue;
            }
            ++wanted;
            const auto map = world_from_rectangle(view, b.rect, b.near_depth);
            if (!map) {
                continue;
            }
            ++found;
            const glm::vec3 low = device.window(glm::vec3{(*map)[3]});
            const glm::vec3 high = device.window(glm::vec3{*map * glm::vec4{1, 1, 0, 1}});
            for (int k = 0; k < 4; ++k) {
                const glm::vec3 p = device.window(glm::vec3{*map * glm::vec4{k & 1, k >> 1, 0, 1}});
                ASSERT_LE(p.z, b.near_depth) << projection.name << ", case " << i;
                ASSERT_GT(p.z, b.near_depth - 1e-4f) << projection.name << ", case " << i;
            }
            ASSERT_LT(low.x, static_cast<float>(b.rect.x) - 0.01f) << projection.name;
            ASSERT_LT(low.y, static_cast<float>(b.rect.y) - 0.01f) << projection.name;
            ASSERT_GT(high.x, static_cast<float>(b.rect.x + b.rect.width) + 0.01f);
            ASSERT_GT(high.y, static_cast<float>(b.rect.y + b.rect.height) + 0.01f);
            ASSERT_GT(low.x, static_cast<float>(b.rect.x) - 0.3f);
            ASSERT_LT(high.y, static_cast<float>(b.rect.y + b.rect.height) + 0.3f);
        }
        EXPECT_GT(wanted, 20) << projection.name;
        if (std::string_view{projection.name} == "oblique") {
            EXPECT_LT(found, wanted / 2); // only where constant depth all but faces the camera
        } else {
            EXPECT_GT(found, wanted * 9 / 10) << projection.name;
        }
    }
}

TEST(Rectangle, ThereIsNoneBeforeTheNearPlane)
{
    EXPECT_FALSE(world_from_rectangle(down_z(), {10, 10, 20, 20}, 0.0f));
    EXPECT_FALSE(world_from_rectangle(down_z(), {10, 10, 20, 20}, 1e-7f));
    EXPECT_TRUE(world_from_rectangle(down_z(), {10, 10, 20, 20}, 0.5f));
}

} // namespace
} // namespace occlude
