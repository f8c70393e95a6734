// Both kernels of the projection and of the pyramid, on every kind of vector that this processor
// has: they agree to the bit, and both keep their guarantees.
#include <occlude/screen/depth_pyramid.h>
#include <occlude/screen/projection.h>

#include "screen/projections.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <numeric>
#include <vector>

namespace occlude {
namespace {

using Refinement = DepthPyramid::Refinement;

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Calls `check` with each target allowed alone in turn, as if the processor had no better one.
template <class Check>
void on_every_target(Check&& check)
{
    int tried = 0;
    for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
        SCOPED_TRACE(hwy::TargetName(target));
        hwy::SetSupportedTargetsForTest(target);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
        check();
        ++tried;
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    EXPECT_GT(tried, 0);
}

// Boxes before, beside, behind and around the eye, and invalid boxes.
std::vector<Aabb> all_sorts_of_boxes(Rng& rng, size_t count)
{
    std::vector<Aabb> boxes(count);
    for (Aabb& box : boxes) {
        box = test::random_box(rng, 20.0f, rng.below(4) == 0 ? 30.0f : 3.0f);
        const int axis = static_cast<int>(rng.below(3));
        switch (rng.below(24)) {
        case 0:
            box.min[axis] = kNan;
            break;
        case 1:
            box.max[axis] = kNan;
            break;
        case 2:
            box.max[axis] = box.min[axis] - 1.0f;
            break; // empty
        case 3:
            box = Aabb::empty();
            break;
        case 4:
            box.max[axis] = kInf;
            break;
        case 5:
            box.min[axis] = -kInf;
            break;
        case 6:
            box = Aabb::everything();
            break;
        case 7:
            box.max[axis] = box.min[axis];
            break; // flat
        case 8:
            box.max[axis] = 3e38f;
            break; // overflows on the way
        case 9:
            box = {box.min, box.min};
            break;
        default:
            break;
        }
    }
    return boxes;
}

testing::AssertionResult same_bits(const ScreenBounds& a, const ScreenBounds& b)
{
    if (a.valid == b.valid && a.rect == b.rect &&
        std::memcmp(&a.near_depth, &b.near_depth, sizeof(float)) == 0 &&
        std::memcmp(&a.far_depth, &b.far_depth, sizeof(float)) == 0) {
        return testing::AssertionSuccess();
    }
    const auto text = [](const ScreenBounds& s) {
        return testing::Message() << s.valid << " (" << s.rect.x << ", " << s.rect.y << ", "
                                  << s.rect.width << ", " << s.rect.height << ") " << s.near_depth
                                  << " .. " << s.far_depth;
    };
    return testing::AssertionFailure() << text(a) << " is not " << text(b);
}

TEST(Kernels, ProjectionsAgreeToTheBitOnEveryTargetUnderEveryProjection)
{
    on_every_target([] {
        Rng rng(91);
        int valid = 0;
        int asked = 0;
        for (const test::Projection& projection : test::all_projections()) {
            for (int camera = 0; camera < 4; ++camera) {
                const View view = View::from_clip(projection.clip_from_eye *
                                                      test::random_eye_from_world(rng, 20.0f),
                                                  {641, 359}, projection.convention);
                // Not a multiple of any vector, and less than one now and then.
                const std::vector<Aabb> boxes =
                    all_sorts_of_boxes(rng, camera == 3 ? rng.below(8) : 261);
                std::vector<ScreenBounds> bounds(boxes.size());
                const SamplePositions samples =
                    camera % 2 == 0 ? SamplePositions::anywhere : SamplePositions::center;
                project_boxes(view, boxes, bounds, Kernel::simd, samples);
                for (size_t i = 0; i < boxes.size(); ++i) {
                    ASSERT_TRUE(same_bits(bounds[i], project(view, boxes[i], samples)))
                        << projection.name << ", box " << i;
                    valid += bounds[i].valid && bounds[i].rect.width > 0 ? 1 : 0;
                }
                asked += static_cast<int>(boxes.size());
            }
        }
        EXPECT_GT(valid, asked / 20);
    });
}

TEST(Kernels, NothingIsValidInADegenerateViewWithEitherKernel)
{
    Rng rng(92);
    const std::vector<Aabb> boxes = all_sorts_of_boxes(rng, 100);
    std::vector<ScreenBounds> bounds(boxes.size());
    for (const View& view : {View{}, View::from_clip(glm::mat4{1.0f}, {-3, 5})}) {
        for (const Kernel kernel : {Kernel::simd, Kernel::scalar}) {
            project_boxes(view, boxes, bounds, kernel);
            for (size_t i = 0; i < boxes.size(); ++i) {
                EXPECT_EQ(bounds[i].valid, boxes[i].is_empty());
            }
        }
    }
}

// Smooth depths with some far specks, as a rendered image has.
DepthPyramid specked_pyramid(glm::ivec2 size, uint64_t seed, Kernel kernel = Kernel::simd)
{
    Rng rng(seed);
    DepthPyramid pyramid;
    const std::span<float> depth = pyramid.resize(size);
    for (size_t i = 0; i < depth.size(); ++i) {
        const float slope = static_cast<float>(i % static_cast<size_t>(size.x)) * 0.0005f;
        depth[i] = rng.below(300) == 0 ? 1.0f : 0.4f + slope + rng.range(0.0f, 0.1f);
    }
    pyramid.build(kernel);
    return pyramid;
}

ScreenBounds random_bounds(Rng& rng, glm::ivec2 size)
{
    const uint32_t reach = 1u << (1 + rng.below(10));
    ScreenBounds bounds;
    bounds.valid = rng.below(16) != 0;
    bounds.rect = {static_cast<int>(rng.below(static_cast<uint32_t>(size.x) + 8)) - 4,
                   static_cast<int>(rng.below(static_cast<uint32_t>(size.y) + 8)) - 4,
                   static_cast<int>(rng.below(reach)), static_cast<int>(rng.below(reach))};
    bounds.near_depth = rng.range(0.4f, 1.01f);
    return bounds;
}

bool truly_hidden(std::span<const float> depth, glm::ivec2 size, const ScreenBounds& b)
{
    for (int y = std::max(b.rect.y, 0); y < std::min(b.rect.y + b.rect.height, size.y); ++y) {
        for (int x = std::max(b.rect.x, 0); x < std::min(b.rect.x + b.rect.width, size.x); ++x) {
            if (depth[static_cast<size_t>(y * size.x + x)] >= b.near_depth) {
                return false;
            }
        }
    }
    return b.valid;
}

TEST(Kernels, PyramidsAgreeOnEveryTargetAndWithBruteForceOverPixels)
{
    on_every_target([] {
        Rng rng(93);
        int hidden_count = 0;
        int asked = 0;
        const glm::ivec2 sizes[] = {{1, 1},     {2, 7},     {5, 3},     {31, 65},  {64, 64},
                                    {127, 129}, {641, 359}, {3, 32768}, {2, 40000}};
        for (const glm::ivec2& size : sizes) {
            DepthPyramid pyramid = specked_pyramid(size, rng.below(1000));
            const std::span<float> depth = pyramid.resize(size); // the same size: keeps all
            std::vector<ScreenBounds> bounds(1000);
            std::ranges::generate(bounds, [&] { return random_bounds(rng, size); });
            std::vector<uint8_t> exact(bounds.size(), 9);
            std::vector<uint8_t> coarse(bounds.size(), 9);
            pyramid.hides(bounds, Refinement::pixels, exact);
            pyramid.hides(bounds, Refinement::none, coarse);
            for (size_t i = 0; i < bounds.size(); ++i) {
                const ScreenBounds& b = bounds[i];
                ASSERT_EQ(exact[i], truly_hidden(depth, size, b) ? 1 : 0) << "bounds " << i;
                ASSERT_EQ(coarse[i],
                          b.valid && pyramid.hides(b.rect, b.near_depth, Refinement::none) ? 1 : 0)
                    << "bounds " << i;
                ASSERT_LE(coarse[i], exact[i]);
                hidden_count += exact[i];
                ++asked;
            }
            for (const Refinement refinement : {Refinement::none, Refinement::pixels}) {
                DepthPyramid twin = pyramid;
                twin.build(Kernel::scalar);
                std::vector<uint8_t> scalar(bounds.size(), 9);
                twin.hides(bounds, refinement, scalar, Kernel::scalar);
                ASSERT_EQ(scalar, refinement == Refinement::none ? coarse : exact);
            }
        }
        EXPECT_GT(hidden_count, asked / 10); // both answers are frequent
        EXPECT_LT(hidden_count, asked * 9 / 10);
    });
}

TEST(Kernels, RectanglesAsFarAsNumbersGoHideAsTheSpecificationSays)
{
    constexpr int kMost = std::numeric_limits<int>::max();
    constexpr int kLeast = std::numeric_limits<int>::min();
    const glm::ivec2 size{37, 300};
    const DepthPyramid pyramid = specked_pyramid(size, 95);
    std::vector<ScreenBounds> bounds;
    for (const int x : {kLeast, -kMost, -5, 0, 1, 36, 37, 38, kMost}) {
        for (const int y : {kLeast, -256, -1, 0, 43, 299, 300, kMost}) {
            for (const int width : {kLeast, -1, 0, 1, 2, 5, 6, 37, 38, kMost}) {
                for (const int height : {-3, 0, 1, 4, 8, 17, 257, 300, 301, kMost}) {
                    for (const float nearest : {0.0f, 0.48f, 1.0f, 1.5f, kInf, -kInf, kNan}) {
                        bounds.push_back({{x, y, width, height}, nearest, 1.0f, true});
                    }
                }
            }
        }
    }
    on_every_target([&] {
        for (const Refinement refinement : {Refinement::none, Refinement::pixels}) {
            std::vector<uint8_t> hidden(bounds.size(), 9);
            pyramid.hides(bounds, refinement, hidden);
            int seen = 0;
            for (size_t i = 0; i < bounds.size(); ++i) {
                const ScreenBounds& b = bounds[i];
                ASSERT_EQ(hidden[i], pyramid.hides(b.rect, b.near_depth, refinement) ? 1 : 0)
                    << b.rect.x << ", " << b.rect.y << ", " << b.rect.width << ", " << b.rect.height
                    << " at " << b.near_depth;
                seen += hidden[i] == 0 ? 1 : 0;
            }
            EXPECT_GT(seen, 1000);
            EXPECT_LT(seen, static_cast<int>(bounds.size()) - 1000);
        }
    });
}

// x and y from 0 to 1 across the target, and window depth, of a point that is on the screen.
glm::vec3 window_position(const glm::vec4& clip, ClipConvention convention)
{
    const glm::vec3 ndc = glm::vec3{clip} / clip.w;
    const float z = convention.range == DepthRange::minus_one_to_one ? 0.5f * ndc.z + 0.5f : ndc.z;
    return {0.5f * glm::vec2{ndc} + 0.5f,
            convention.order == DepthOrder::near_is_large ? 1.0f - z : z};
}

// If a corner or an inner point of a box lies in front of the depth, the box must not be hidden.
TEST(Kernels, NoBoxWithAVisiblePointIsHiddenUnderAnyProjection)
{
    constexpr glm::ivec2 kSize{320, 200};
    on_every_target([&] {
        Rng rng(94);
        int hidden_count = 0;
        const std::vector<test::Projection> projections = test::all_projections();
        for (size_t camera = 0; camera < 4 * projections.size(); ++camera) {
            const test::Projection& projection = projections[camera % projections.size()];
            const glm::mat4 clip =
                projection.clip_from_eye * test::random_eye_from_world(rng, 20.0f);
            const View view = View::from_clip(clip, kSize, projection.convention);
            std::vector<Aabb> boxes = all_sorts_of_boxes(rng, 500);
            // Depth near that of the boxes, so that both answers are frequent.
            std::vector<float> depths;
            for (const Aabb& box : boxes) {
                const ScreenBounds b = project(view, box);
                if (b.valid && b.rect.width > 0) {
                    depths.push_back(b.near_depth);
                }
            }
            if (depths.empty()) {
                continue; // looks away from all of them
            }
            std::ranges::sort(depths);
            const float middle = depths[depths.size() / 2];
            DepthPyramid pyramid;
            const std::span<float> depth = pyramid.resize(kSize);
            std::ranges::generate(depth, [&] { return rng.below(200) == 0 ? 1.0f : middle; });
            pyramid.build();

            std::vector<uint8_t> hidden(boxes.size());
            std::vector<uint8_t> scalar(boxes.size());
            pyramid.hides(view, boxes, Refinement::pixels, hidden);
            pyramid.hides(view, boxes, Refinement::pixels, scalar, Kernel::scalar);
            ASSERT_EQ(hidden, scalar) << projection.name;
            for (size_t i = 0; i < boxes.size(); ++i) {
                if (hidden[i] == 0 || !boxes[i].is_bounded()) {
                    ASSERT_TRUE(hidden[i] == 0 || boxes[i].is_empty());
                    continue;
                }
                ++hidden_count;
                for (int k = 0; k < 32; ++k) {
                    const glm::vec3 share{rng.range(0, 1), rng.range(0, 1), rng.range(0, 1)};
                    const glm::vec3 p = k < 8 ? test::corner(boxes[i], k)
                                              : boxes[i].min + share * boxes[i].extent();
                    const glm::vec4 c = clip * glm::vec4{p, 1.0f};
                    if (test::clip_margin(glm::dvec4{c}, projection.convention) >= 0.0) {
                        const glm::vec3 at = window_position(c, projection.convention);
                        const glm::ivec2 pixel =
                            glm::min(glm::ivec2{glm::vec2{at} * glm::vec2{kSize}}, kSize - 1);
                        ASSERT_GT(at.z, depth[static_cast<size_t>(pixel.y * kSize.x + pixel.x)])
                            << projection.name << ", box " << i;
                    }
                }
            }
        }
        EXPECT_GT(hidden_count, 500);
    });
}

TEST(Kernels, NothingIsHiddenInAViewOfAnotherSizeThanThePyramids)
{
    DepthPyramid pyramid;
    std::ranges::fill(pyramid.resize({64, 64}), 0.0f);
    pyramid.build();
    const auto clip = glm::perspectiveRH_NO(1.0f, 1.0f, 0.1f, 100.0f);
    const std::vector<Aabb> boxes(70, Aabb{{-1.0f, -1.0f, -9.0f}, {1.0f, 1.0f, -8.0f}});
    std::vector<uint8_t> hidden(boxes.size());
    pyramid.hides(View::from_clip(clip, {64, 64}), boxes, Refinement::none, hidden);
    EXPECT_EQ(std::accumulate(hidden.begin(), hidden.end(), 0), 70);
    pyramid.hides(View::from_clip(clip, {65, 64}), boxes, Refinement::none, hidden);
    EXPECT_EQ(std::accumulate(hidden.begin(), hidden.end(), 0), 0);
}

} // namespace
} // namespace occlude
