#include <occlude/screen/depth_pyramid.h>

#include <occlude/core/rng.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace occlude {
namespace {

using Refinement = DepthPyramid::Refinement;

// A pyramid over smooth depths with some far specks, as a rendered image has.
DepthPyramid random_pyramid(glm::ivec2 size, uint64_t seed)
{
    Rng rng{seed};
    DepthPyramid pyramid;
    const std::span<float> depth = pyramid.resize(size);
    for (size_t i = 0; i < depth.size(); ++i) {
        const float slope = static_cast<float>(i % static_cast<size_t>(size.x)) * 0.002f;
        depth[i] = rng.below(40) == 0 ? 1.0f : 0.2f + slope + rng.range(0.0f, 0.1f);
    }
    pyramid.build();
    return pyramid;
}

float true_farthest(DepthPyramid& pyramid, const PixelRect& rect)
{
    const glm::ivec2 size = pyramid.size_px();
    const std::span<float> depth = pyramid.resize(size);
    float farthest = 0.0f;
    for (int y = std::max(rect.y, 0); y < std::min(rect.y + rect.height, size.y); ++y) {
        for (int x = std::max(rect.x, 0); x < std::min(rect.x + rect.width, size.x); ++x) {
            farthest = std::max(farthest, depth[static_cast<size_t>(y * size.x + x)]);
        }
    }
    return farthest;
}

TEST(DepthPyramid, EveryAnswerAgreesWithBruteForceAtOddAndEvenSizes)
{
    const glm::ivec2 sizes[] = {{1, 1},   {2, 1},   {1, 7},     {3, 3},    {5, 2},
                                {64, 64}, {65, 33}, {127, 129}, {641, 359}};
    uint64_t seed = 1;
    int hidden = 0;
    int asked = 0;
    for (const glm::ivec2& size : sizes) {
        DepthPyramid pyramid = random_pyramid(size, seed);
        Rng rng{++seed};
        for (int i = 0; i < 2000; ++i) {
            // Many small rectangles, some as large as the target, some partly outside of it.
            const uint32_t reach = 1u << (1 + rng.below(9));
            const PixelRect rect{static_cast<int>(rng.below(static_cast<uint32_t>(size.x) + 8)) - 4,
                                 static_cast<int>(rng.below(static_cast<uint32_t>(size.y) + 8)) - 4,
                                 1 + static_cast<int>(rng.below(reach)),
                                 1 + static_cast<int>(rng.below(reach))};
            const float nearest = rng.range(0.2f, 1.1f);
            const float farthest = true_farthest(pyramid, rect);
            ASSERT_EQ(pyramid.hides(rect, nearest), farthest < nearest);
            if (pyramid.hides(rect, nearest, Refinement::none)) {
                ASSERT_LT(farthest, nearest);
            }
            hidden += farthest < nearest ? 1 : 0;
            ++asked;
        }
    }
    EXPECT_GT(hidden, asked / 10); // both answers are frequent
    EXPECT_LT(hidden, asked * 9 / 10);
}

TEST(DepthPyramid, ALoneFarPixelIsSeenAtEveryPlaceOfAnOddTarget)
{
    // A pyramid that rounds its halves down misses the last row and column.
    const glm::ivec2 size{7, 5};
    const PixelRect everything{0, 0, size.x, size.y};
    for (int i = 0; i < size.x * size.y; ++i) {
        DepthPyramid pyramid;
        const std::span<float> depth = pyramid.resize(size);
        std::fill(depth.begin(), depth.end(), 0.25f);
        depth[static_cast<size_t>(i)] = 0.75f;
        pyramid.build();
        for (const Refinement refinement : {Refinement::none, Refinement::pixels}) {
            EXPECT_FALSE(pyramid.hides(everything, 0.5f, refinement)) << "pixel " << i;
        }
        EXPECT_FALSE(pyramid.hides({i % size.x, i / size.x, 1, 1}, 0.75f)); // as far: visible
        EXPECT_TRUE(pyramid.hides({i % size.x, i / size.x, 1, 1}, 0.76f));
    }
}

TEST(DepthPyramid, RefinementSeesThatAFarPixelLiesBesideTheRectangle)
{
    DepthPyramid pyramid;
    const std::span<float> depth = pyramid.resize({64, 64});
    std::fill(depth.begin(), depth.end(), 0.25f);
    depth[0] = 1.0f;
    pyramid.build();
    const PixelRect beside{1, 0, 63, 64};
    EXPECT_TRUE(pyramid.hides(beside, 0.5f, Refinement::pixels));
    EXPECT_FALSE(pyramid.hides(beside, 0.5f, Refinement::none)); // the known false answer
}

TEST(DepthPyramid, NothingOutsideOfTheTargetCanBeSeen)
{
    DepthPyramid pyramid = random_pyramid({16, 16}, 3);
    const int big = std::numeric_limits<int>::max();
    EXPECT_TRUE(pyramid.hides({16, 0, 4, 4}, 0.0f));
    EXPECT_TRUE(pyramid.hides({-4, 0, 4, 4}, 0.0f));
    EXPECT_TRUE(pyramid.hides({3, 3, 0, 0}, 0.0f));
    EXPECT_TRUE(pyramid.hides({0, 16, 1, 1}, 0.0f));
    EXPECT_FALSE(pyramid.hides({-5, -5, big, big}, 0.0f));
    EXPECT_FALSE(pyramid.hides({0, 0, big, big}, 1.0f)); // cleared pixels hide nothing
    EXPECT_TRUE(DepthPyramid{}.empty());
}

TEST(DepthPyramid, ANewSizeIsANewPyramid)
{
    DepthPyramid pyramid = random_pyramid({33, 9}, 4);
    EXPECT_EQ(pyramid.size_px(), (glm::ivec2{33, 9}));
    EXPECT_EQ(pyramid.resize({4, 4}).size(), 16u);
    EXPECT_EQ(pyramid.size_px(), (glm::ivec2{4, 4}));
    EXPECT_TRUE(pyramid.resize({0, 4}).empty());
    EXPECT_TRUE(pyramid.empty());
}

} // namespace
} // namespace occlude
