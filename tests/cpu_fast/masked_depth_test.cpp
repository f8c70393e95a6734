// The two layers of a sub-tile never say that something is hidden which is not, and rectangles are
// tested against exactly the depth that depth() shows.
#include "cpu_fast/occluder_worlds.h"

#include <occlude/backends/cpu_fast/detail/bin_raster.h>

#include <gtest/gtest.h>

#include <bit>

namespace occlude {
namespace {

using cpu_fast::kWholeSubTile;
using cpu_fast::scalar::merge_layer;

struct SubTile {
    float far_depth = 1.0f;
    float near_depth = 0.0f;
    uint32_t mask = 0;

    void cover(uint32_t cells, float depth)
    {
        merge_layer(cells, depth, far_depth, near_depth, mask);
    }
    float depth(int cell) const { return (mask >> cell & 1) != 0 ? near_depth : far_depth; }
};

TEST(MaskedLayers, NeverHideMoreThanWhatCoversEachCellAndOftenAsMuch)
{
    Rng rng(11);
    size_t exact = 0;
    size_t cells = 0;
    for (int round = 0; round < 4000; ++round) {
        SubTile tile;
        std::array<float, 32> truth;
        truth.fill(1.0f);
        for (uint32_t i = 0, count = 1 + rng.below(6); i < count; ++i) {
            // Half-planes, mostly, as triangles give them.
            const uint32_t bits = rng.below(5) == 0 ? kWholeSubTile : ~0u << rng.below(32);
            const uint32_t covered = rng.below(2) == 0 ? bits : ~bits;
            const float depth = uniform01(rng.next());
            tile.cover(covered, depth);
            for (int cell = 0; cell < 32; ++cell) {
                if ((covered >> cell & 1) != 0) {
                    truth[static_cast<size_t>(cell)] =
                        std::min(truth[static_cast<size_t>(cell)], depth);
                }
            }
            ASSERT_TRUE(tile.mask == 0 ? tile.near_depth == 0.0f
                                       : tile.near_depth < tile.far_depth);
            ASSERT_NE(tile.mask, kWholeSubTile);
        }
        for (int cell = 0; cell < 32; ++cell) {
            ASSERT_GE(tile.depth(cell), truth[static_cast<size_t>(cell)]) << "round " << round;
            exact += tile.depth(cell) == truth[static_cast<size_t>(cell)] ? 1 : 0;
            ++cells;
        }
    }
    EXPECT_GT(exact, cells / 2);
}

TEST(MaskedLayers, WhatCoversTheWholeSubTileBehindTheNearLayerKeepsThatLayer)
{
    SubTile tile;
    tile.cover(0xffffu, 0.3f);
    tile.cover(kWholeSubTile, 0.7f);
    EXPECT_EQ(tile.depth(0), 0.3f);
    EXPECT_EQ(tile.depth(31), 0.7f);
    tile.cover(kWholeSubTile, 0.2f);
    EXPECT_EQ(tile.depth(0), 0.2f);
    EXPECT_EQ(tile.depth(31), 0.2f);
}

TEST(MaskedLayers, TwoHalvesHideAtTheFartherOfTheirDepths)
{
    SubTile tile;
    tile.cover(0xffffu, 0.3f);
    tile.cover(~0xffffu, 0.4f);
    EXPECT_EQ(tile.mask, 0u);
    EXPECT_EQ(tile.far_depth, 0.4f);
}

TEST(OccluderBuffer, RectanglesAreHiddenExactlyWhereAllOfTheirCellsAre)
{
    size_t hidden = 0;
    size_t tested = 0;
    for (uint64_t seed = 1; seed <= 60; ++seed) {
        Rng rng(seed);
        const glm::ivec2 size{300 + static_cast<int>(rng.below(300)),
                              1 + static_cast<int>(rng.below(200))};
        const test::OccluderWorld world = test::random_occluder_world(seed, size, 12);
        OccluderBuffer buffer({.cell_px = 1 + static_cast<int>(rng.below(2))});
        rasterize(buffer, world, test::PreparedWorld(world));
        const glm::ivec2 cells = buffer.size_cells();
        const int cell = buffer.cell_px();
        for (int i = 0; i < 200; ++i) {
            const auto side = [&](int most) {
                const auto limit = static_cast<uint32_t>(rng.below(2) == 0 ? most : 24);
                return 1 +
                       static_cast<int>(rng.below(std::min(limit, static_cast<uint32_t>(most))));
            };
            PixelRect rect{0, 0, side(size.x), side(size.y)};
            rect.x = static_cast<int>(rng.below(static_cast<uint32_t>(size.x - rect.width + 1)));
            rect.y = static_cast<int>(rng.below(static_cast<uint32_t>(size.y - rect.height + 1)));
            float farthest = 0.0f;
            for (int y = rect.y / cell; y <= (rect.y + rect.height - 1) / cell; ++y) {
                for (int x = rect.x / cell; x <= (rect.x + rect.width - 1) / cell; ++x) {
                    farthest =
                        std::max(farthest, buffer.depth()[static_cast<size_t>(y * cells.x + x)]);
                }
            }
            const float just_behind = std::nextafter(farthest, 2.0f);
            ASSERT_EQ(buffer.test(rect, just_behind), Visibility::hidden) << "seed " << seed;
            ASSERT_EQ(buffer.test(rect, farthest), Visibility::visible) << "seed " << seed;
            hidden += farthest < 1.0f ? 1 : 0;
            ++tested;
        }
    }
    EXPECT_GT(hidden, tested / 10);
    EXPECT_LT(hidden, tested * 9 / 10);
}

} // namespace
} // namespace occlude
