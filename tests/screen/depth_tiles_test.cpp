#include <occlude/screen/depth_tiles.h>

#include <occlude/core/rng.h>
#include <occlude/core/tiles.h>
#include <occlude/screen/depth_pyramid.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <vector>

namespace occlude {
namespace {

std::vector<float> random_depths(glm::ivec2 size, uint64_t seed)
{
    Rng rng{seed};
    std::vector<float> depths(static_cast<size_t>(size.x * size.y));
    for (float& depth : depths) {
        depth = rng.below(30) == 0 ? 1.0f : rng.range(0.2f, 0.6f);
    }
    return depths;
}

TEST(DepthTiles, EachTileIsTheFarthestOfItsPixels)
{
    for (const glm::ivec2 size : {glm::ivec2{1, 1}, glm::ivec2{16, 8}, glm::ivec2{37, 21}}) {
        const std::vector<float> depths = random_depths(size, 3);
        for (const int side : {1, 2, 8, 64}) {
            const glm::ivec2 count = tiles_in(size, side);
            std::vector<float> tiles(static_cast<size_t>(count.x * count.y), 7.0f);
            farthest_of_tiles(depths, size, side, tiles);
            for (int y = 0; y < count.y; ++y) {
                for (int x = 0; x < count.x; ++x) {
                    float farthest = 0.0f;
                    for (int py = y * side; py < std::min((y + 1) * side, size.y); ++py) {
                        for (int px = x * side; px < std::min((x + 1) * side, size.x); ++px) {
                            farthest =
                                std::max(farthest, depths[static_cast<size_t>(py * size.x + px)]);
                        }
                    }
                    EXPECT_EQ(tiles[static_cast<size_t>(y * count.x + x)], farthest);
                }
            }
        }
    }
}

// A pyramid over pixels and one over tiles of them.
TEST(DepthTiles, APyramidFromTilesHidesOnlyWhatThatOfPixelsHides)
{
    Rng rng{9};
    int hidden = 0;
    int hidden_by_tiles = 0;
    int asked = 0;
    for (const glm::ivec2 size : {glm::ivec2{64, 64}, glm::ivec2{131, 77}, glm::ivec2{5, 9}}) {
        const std::vector<float> depths = random_depths(size, 4);
        DepthPyramid pixels;
        std::ranges::copy(depths, pixels.resize(size).begin());
        pixels.build();
        DepthPyramid tiles;
        for (const int side : {2, 4, 8}) {
            const std::span<float> base =
                tiles.resize(size, std::countr_zero(static_cast<uint32_t>(side)));
            ASSERT_EQ(base.size(), static_cast<size_t>(tiles_in(size, side).x) *
                                       static_cast<size_t>(tiles_in(size, side).y));
            farthest_of_tiles(depths, size, side, base);
            for (const Kernel kernel : {Kernel::scalar, Kernel::simd}) {
                tiles.build(kernel);
                for (int i = 0; i < 500; ++i) {
                    ScreenBounds bounds;
                    bounds.rect = {static_cast<int>(rng.below(static_cast<uint32_t>(size.x))),
                                   static_cast<int>(rng.below(static_cast<uint32_t>(size.y))),
                                   1 + static_cast<int>(rng.below(12)),
                                   1 + static_cast<int>(rng.below(12))};
                    bounds.near_depth = rng.range(0.2f, 1.1f);
                    bounds.valid = true;
                    uint8_t by_tiles = 2;
                    tiles.hides({&bounds, 1}, DepthPyramid::Refinement::pixels, {&by_tiles, 1},
                                kernel);
                    const bool by_pixels = pixels.hides(bounds.rect, bounds.near_depth);
                    EXPECT_EQ(by_tiles != 0, tiles.hides(bounds.rect, bounds.near_depth));
                    EXPECT_LE(by_tiles, by_pixels ? 1 : 0) << side;
                    ++asked;
                    hidden += by_pixels ? 1 : 0;
                    hidden_by_tiles += by_tiles;
                }
            }
        }
    }
    EXPECT_GT(hidden, asked / 10) << "the case is representative";
    EXPECT_GT(hidden_by_tiles, hidden / 3) << "tiles hide much of it, too";
    EXPECT_LT(hidden_by_tiles, hidden);
}

TEST(DepthTiles, ABaseBeyondTheLastLevelIsTheLastLevel)
{
    DepthPyramid pyramid;
    EXPECT_EQ(pyramid.resize({8, 4}, 10).size(), 1u);
    EXPECT_EQ(pyramid.base_level(), 3);
    EXPECT_EQ(pyramid.resize({8, 4}, 0).size(), 32u);
    EXPECT_EQ(pyramid.base_level(), 0);
    EXPECT_TRUE(pyramid.resize({0, 0}, 3).empty());
}

} // namespace
} // namespace occlude
