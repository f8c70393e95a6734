#include <occlude/screen/screen_box.h>

#include <occlude/core/rng.h>
#include <occlude/screen/projection.h>

#include "screen/projections.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace occlude {
namespace {

constexpr glm::ivec2 kSize{320, 200};
constexpr double kInfinity = std::numeric_limits<double>::infinity();

View down_z(glm::ivec2 size = {100, 100})
{
    return View::from_clip(glm::perspectiveRH_NO(glm::radians(90.0f), 1.0f, 1.0f, 101.0f), size);
}

glm::dvec3 on_screen(const View& view, const glm::dvec3& p)
{
    const glm::dvec4 clip = glm::dmat4{view.clip_from_world()} * glm::dvec4{p, 1.0};
    const ClipConvention convention = view.convention();
    double z = clip.z / clip.w;
    z = convention.range == DepthRange::minus_one_to_one ? 0.5 * z + 0.5 : z;
    z = convention.order == DepthOrder::near_is_large ? 1.0 - z : z;
    return {(0.5 * clip.x / clip.w + 0.5) * view.size_px().x,
            (0.5 * clip.y / clip.w + 0.5) * view.size_px().y, z};
}

// A cube from 10 to 20 before the eye, to the right: at 45 degrees its left face is visible, too.
TEST(ScreenBox, KnowsTheFacesOfABoxApart)
{
    const View view = down_z();
    const Aabb box{{5.0f, -5.0f, -20.0f}, {10.0f, 5.0f, -10.0f}};
    const ScreenBox screen_box{ScreenSpace{view}, box};
    const auto depth = [](double d) { return 101.0 / 100.0 * (1.0 - 1.0 / d); };
    // The front face is at 75 to 100 px; the left one narrows from 75 to 62.5 px.
    EXPECT_NEAR(screen_box.nearest_over({85, 50}, {85, 50}), depth(10.0), 2e-3);
    const double at_70 = screen_box.nearest_over({70, 50}, {70, 50}); // x = 5 at distance 12.2
    EXPECT_NEAR(at_70, depth(5.0 / 0.42), 2e-3);
    EXPECT_EQ(screen_box.nearest_over({60, 50}, {60, 50}), kInfinity);
    // A point beside the slanted lower edge of the left face, in the rectangle of the box.
    EXPECT_EQ(screen_box.nearest_over({66, 28}, {66, 28}), kInfinity);
    EXPECT_LE(project(view, box).rect.y, 28);
}

TEST(ScreenBox, SamplesInTheMiddleOfPixelsMissWhatOnlyGrazesThem)
{
    // The left face of the front is at 75.2 px: the middle of pixel 75 is in, that of 74 is not;
    // the left side face reaches down to 62.6 px.
    const View view = down_z();
    const Aabb wall{{5.04f, -5.0f, -10.0f}, {10.0f, 5.0f, -10.0f}};
    const ScreenBox anywhere{ScreenSpace{view}, wall};
    const ScreenBox center{ScreenSpace{view, SamplePositions::center}, wall};
    EXPECT_LT(anywhere.nearest_over({75, 50}, {75, 50}), 1.0);
    EXPECT_LT(center.nearest_over({75, 50}, {75, 50}), 1.0);
    const Aabb grazing{{5.14f, -5.0f, -10.0f}, {10.0f, 5.0f, -10.0f}}; // from 75.7 px on
    EXPECT_LT(ScreenBox(ScreenSpace{view}, grazing).nearest_over({75, 50}, {75, 50}), 1.0);
    EXPECT_EQ(ScreenBox(ScreenSpace(view, SamplePositions::center), grazing)
                  .nearest_over({75, 50}, {75, 50}),
              kInfinity);
}

glm::dvec3 random_point(Rng& rng, const Aabb& box)
{
    const glm::dvec3 inside{rng.range(0.0f, 1.0f), rng.range(0.0f, 1.0f), rng.range(0.0f, 1.0f)};
    return glm::dvec3{box.min} + inside * glm::dvec3{box.extent()};
}

bool on_target(const glm::ivec2& pixel)
{
    return pixel.x >= 0 && pixel.y >= 0 && pixel.x < kSize.x && pixel.y < kSize.y;
}

// Over random views in every convention and random boxes: no point of a box is nearer than
// nearest_over says of its pixel, and of any block of pixels around that.
TEST(ScreenBox, NothingInABoxIsNearerThanItSays)
{
    Rng rng{11};
    uint32_t tested = 0;
    uint32_t tighter = 0;
    for (const test::Projection& projection : test::all_projections()) {
        const View view = View::from_clip(projection.clip_from_eye, kSize, projection.convention);
        const ScreenSpace screen{view};
        for (int i = 0; i < 400; ++i) {
            const glm::vec3 low{rng.range(-40.0f, 40.0f), rng.range(-30.0f, 30.0f),
                                rng.range(-90.0f, 0.0f)};
            const Aabb box{low, low + glm::vec3{rng.range(0.0f, 20.0f), rng.range(0.0f, 20.0f),
                                                rng.range(0.0f, 20.0f)}};
            const ScreenBounds bounds = project(view, box);
            if (!bounds.valid || bounds.rect.width == 0) {
                continue;
            }
            const ScreenBox screen_box{screen, box};
            for (int k = 0; k < 16; ++k) {
                const glm::dvec3 p = on_screen(view, random_point(rng, box));
                const glm::ivec2 pixel{std::floor(p.x), std::floor(p.y)};
                if (!on_target(pixel)) {
                    continue;
                }
                ++tested;
                const double at_pixel = screen_box.nearest_over(pixel, pixel);
                EXPECT_LE(at_pixel, p.z) << projection.name;
                const glm::ivec2 more{rng.below(9), rng.below(9)};
                const double at_block = screen_box.nearest_over(pixel - more, pixel + more);
                EXPECT_LE(at_block, at_pixel);
                for (const double depth : {at_pixel - 1e-4, at_block, p.z}) {
                    EXPECT_EQ(screen_box.beyond(depth, pixel - more, pixel + more),
                              depth < at_block);
                }
                tighter += at_pixel > double{bounds.near_depth} + 1e-6 ? 1 : 0;
            }
        }
    }
    EXPECT_GT(tested, 2000u);
    EXPECT_GT(tighter, tested / 4) << "no better than rectangles";
}

// The same for boxes in the space of objects that are turned, stretched, mirrored and far away.
TEST(ScreenBox, NothingInABoxOfAnObjectIsNearerThanItSays)
{
    Rng rng{12};
    uint32_t tested = 0;
    uint32_t tighter = 0;
    for (const test::Projection& projection : test::all_projections()) {
        const View view = View::from_clip(projection.clip_from_eye, kSize, projection.convention);
        const ScreenSpace screen{view};
        for (int i = 0; i < 400; ++i) {
            const auto vector = [&](float low, float high) {
                return glm::vec3{rng.range(low, high), rng.range(low, high), rng.range(low, high)};
            };
            const float size = i % 3 == 0 ? 1000.0f : 1.0f; // as in a file in millimetres
            const glm::vec3 place{rng.range(-40.0f, 40.0f), rng.range(-30.0f, 30.0f),
                                  rng.range(-90.0f, 0.0f)};
            glm::mat4 map = glm::translate(glm::mat4{1.0f}, place);
            map = glm::rotate(map, rng.range(0.0f, 6.0f), glm::normalize(vector(0.1f, 1.0f)));
            map = glm::scale(map, vector(0.3f, 3.0f) * (i % 2 == 0 ? 1.0f : -1.0f) / size);
            map[0][1] += 0.2f / size; // sheared
            const glm::vec3 low = size * vector(-8.0f, 2.0f);
            const Aabb box{low, low + size * vector(0.0f, 6.0f)};
            const Inflation inflation = view.inflation().in(map, inverse_stretch(map));
            EXPECT_GT(inflation.margin(box), 0.0f);
            ScreenBounds bounds;
            project_boxes(view, map, inflation, {&box, 1}, {&bounds, 1});
            if (!bounds.valid || bounds.rect.width == 0) {
                continue;
            }
            const ScreenBounds around = project(view, transformed(map, box));
            const ScreenBox screen_box{screen.in(map, inflation), box};
            for (int k = 0; k < 16; ++k) {
                const glm::dvec3 own = random_point(rng, box);
                const glm::dvec3 p =
                    on_screen(view, glm::dvec3{glm::dmat4{map} * glm::dvec4{own, 1.0}});
                const glm::ivec2 pixel{std::floor(p.x), std::floor(p.y)};
                if (!on_target(pixel)) {
                    continue;
                }
                ++tested;
                EXPECT_GE(pixel.x, bounds.rect.x);
                EXPECT_GE(pixel.y, bounds.rect.y);
                EXPECT_LT(pixel.x, bounds.rect.x + bounds.rect.width);
                EXPECT_LT(pixel.y, bounds.rect.y + bounds.rect.height);
                EXPECT_LE(double{bounds.near_depth}, p.z) << projection.name;
                const double at_pixel = screen_box.nearest_over(pixel, pixel);
                EXPECT_LE(at_pixel, p.z) << projection.name;
                const glm::ivec2 more{rng.below(9), rng.below(9)};
                EXPECT_LE(screen_box.nearest_over(pixel - more, pixel + more), at_pixel);
                tighter += !around.valid || at_pixel > double{around.near_depth} + 1e-6 ? 1 : 0;
            }
        }
    }
    EXPECT_GT(tested, 2000u);
    EXPECT_GT(tighter, tested / 2) << "no better than rectangles";
}

// A box of an object grows as much as the box around it would grow in the world. A box of half the
// size under a map that doubles it has the same margin in the world.
TEST(ScreenBox, ABoxOfAnObjectGrowsByNoLessThanItWouldInTheWorld)
{
    const View view = down_z();
    const Aabb box{{5.0f, -5.0f, -20.0f}, {10.0f, 5.0f, -10.0f}};
    const float in_world = view.inflation().margin(box);
    for (const float scale : {0.01f, 0.5f, 1.0f, 100.0f}) {
        const glm::mat4 map = glm::scale(glm::mat4{1.0f}, glm::vec3{scale});
        const Aabb own{box.min / scale, box.max / scale};
        const float margin = scale * view.inflation().in(map, inverse_stretch(map)).margin(own);
        EXPECT_GE(margin, in_world);
        EXPECT_LE(margin, 8.0f * in_world);
    }
    EXPECT_EQ(inverse_stretch(glm::mat4{0.0f}), 0.0f);
}

TEST(ScreenBox, OfWhatReachesTheEyeNothingIsKnown)
{
    const ScreenBox around{ScreenSpace{down_z()}, {glm::vec3{-5.0f}, glm::vec3{5.0f}}};
    EXPECT_EQ(around.nearest_over({50, 50}, {50, 50}), -kInfinity);
    EXPECT_FALSE(around.beyond(0.0, {50, 50}, {50, 50}));
}

} // namespace
} // namespace occlude
