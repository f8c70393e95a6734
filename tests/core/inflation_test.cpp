// How far boxes grow before they are tested (rule R2), and how devices round.
#include <occlude/core/view.h>

#include "screen/projections.h"

#include <gtest/gtest.h>

namespace occlude {
namespace {

using test::Projection;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr glm::ivec2 kSize{1280, 720};

View down_z(float fov_y_degrees, float near)
{
    return View::from_clip(
        glm::perspectiveRH_NO(glm::radians(fov_y_degrees), 16.0f / 9.0f, near, 100.0f), kSize);
}

TEST(Inflation, InflatedBoxContainsTheBoxAndKeepsOddBoxes)
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

TEST(Inflation, FlatBoxGetsThickness)
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

TEST(Inflation, InflationIsAtLeastA256thOfAPixelInEveryDirection)
{
    for (const Projection& projection : test::all_projections()) {
        check_pixels(projection, 50.0f, kSize, 61);
        check_pixels(projection, 50.0f, {64, 2048}, 62); // pixels that are not square
    }
}

TEST(Inflation, InflationIsEnoughInTinyAndHugeScenes)
{
    for (const Projection& projection : test::all_projections()) {
        check_pixels(projection, 1e-3f, kSize, 63);
        check_pixels(projection, 1e6f, kSize, 64);
    }
}

// An off-centre and very wide frustum. Its rows of x and w are far from perpendicular, so that the
// length of the row says little about the size of a pixel.
TEST(Inflation, InflationIsEnoughUnderAWideOffCentreFrustum)
{
    const Projection wide{"wide off-centre",
                          glm::frustumRH_NO(-0.05f, 1.95f, -0.1f, 0.1f, 0.1f, 100.0f),
                          test::kOpenGl};
    check_pixels(wide, 50.0f, {512, 512}, 65);
}

// The proof of docs/conventions.md, in long double. At constant w, window depth changes by at most
// depth_bias over the 1/64 pixel that boxes grow by, in any direction. Under an oblique near plane
// it does change.
TEST(Inflation, DepthBiasIsWhatOne64thOfAPixelCanChange)
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

// Far from the origin, drawn in world coordinates. Positions transformed in float, as a device does
// it, differ from those in long double by no more than clip_rounding(), and not by much less.
TEST(Inflation, ClipRoundingBoundsWhatFloatDoes)
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
                continue; // rounding to float leaves no near plane: nothing is hidden there
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

TEST(Inflation, InflatedPartsLieInTheInflatedWhole)
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
