#include <occlude/effects/level_of_detail.h>

#include <gtest/gtest.h>

#include <array>
#include <limits>

namespace occlude {
namespace {

constexpr std::array<uint64_t, 2> kThresholds{1000, 100};

TEST(LevelOfDetail, FollowsThePixelCountWithoutHysteresis)
{
    for (const uint32_t current : {0u, 1u, 2u, 9u}) {
        EXPECT_EQ(choose_level_of_detail(1000, kThresholds, current, 0.0f), 0u);
        EXPECT_EQ(choose_level_of_detail(999, kThresholds, current, 0.0f), 1u);
        EXPECT_EQ(choose_level_of_detail(100, kThresholds, current, 0.0f), 1u);
        EXPECT_EQ(choose_level_of_detail(99, kThresholds, current, 0.0f), 2u);
    }
}

TEST(LevelOfDetail, KeepsItsLevelWhileTheCountWavers)
{
    uint32_t level = 1;
    for (const uint64_t pixels : {950u, 1050u, 990u, 1099u, 901u, 110u, 91u}) {
        level = choose_level_of_detail(pixels, kThresholds, level, 0.1f);
        EXPECT_EQ(level, 1u) << pixels;
    }
    EXPECT_EQ(choose_level_of_detail(1101, kThresholds, 1, 0.1f), 0u);
    EXPECT_EQ(choose_level_of_detail(89, kThresholds, 1, 0.1f), 2u);
}

TEST(LevelOfDetail, JumpsOverLevels)
{
    EXPECT_EQ(choose_level_of_detail(5, kThresholds, 0, 0.2f), 2u);
    EXPECT_EQ(choose_level_of_detail(5000, kThresholds, 2, 0.2f), 0u);
}

TEST(LevelOfDetail, TakesTheFinestForAnUnknownCountAndTheOnlyOneWithoutThresholds)
{
    EXPECT_EQ(choose_level_of_detail(std::numeric_limits<uint64_t>::max(), kThresholds, 2, 0.2f),
              0u);
    EXPECT_EQ(choose_level_of_detail(7, {}, 3, 0.2f), 0u);
}

} // namespace
} // namespace occlude
