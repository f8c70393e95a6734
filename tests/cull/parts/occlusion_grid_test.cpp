#include <occlude/cull/parts/occlusion_grid.h>

#include "support/trees.h"

#include <occlude/core/rng.h>

#include <gtest/gtest.h>

#include <algorithm>

namespace occlude {
namespace {

OcclusionGrid grid_of(glm::ivec2 size, int cell_size)
{
    OcclusionGrid grid;
    grid.reset(size, cell_size);
    return grid;
}

TEST(OcclusionGrid, CellsAtTheEdgesAreCutOffByTheTarget)
{
    const OcclusionGrid grid = grid_of({100, 64}, 32);
    EXPECT_EQ(grid.size_in_cells(), glm::ivec2(4, 2));
    EXPECT_EQ(grid.pixels({0, 1}), (PixelRect{0, 32, 32, 32}));
    EXPECT_EQ(grid.pixels({3, 0}), (PixelRect{96, 0, 4, 32}));
}

TEST(OcclusionGrid, ATargetWithoutPixelsHasNoCells)
{
    EXPECT_EQ(grid_of({0, 50}, 32).size_in_cells(), glm::ivec2(0, 2));
    EXPECT_EQ(grid_of({-5, 50}, 32).size_in_cells().x, 0);
}

TEST(OcclusionGrid, InternalCellsAreThoseWhollyInTheRectangle)
{
    const OcclusionGrid grid = grid_of({100, 64}, 32);
    const auto internal = [&](const PixelRect& rect) { return grid.internal(rect); };
    // From pixel 31 to 97: one pixel of cell 0, cells 1 and 2, two pixels of cell 3.
    EXPECT_EQ(grid.touched({31, 0, 67, 32}).begin, glm::ivec2(0, 0));
    EXPECT_EQ(grid.touched({31, 0, 67, 32}).end, glm::ivec2(4, 1));
    EXPECT_EQ(internal({31, 0, 67, 32}).begin, glm::ivec2(1, 0));
    EXPECT_EQ(internal({31, 0, 67, 32}).end, glm::ivec2(3, 1));
    // At the edge of the target the cell is cut off, and wholly covered.
    EXPECT_EQ(internal({31, 0, 69, 32}).end, glm::ivec2(4, 1));
    // Within one cell, or across a seam: none, not a negative number.
    for (const PixelRect& rect : {PixelRect{33, 33, 5, 5}, PixelRect{30, 0, 4, 64}, PixelRect{}}) {
        const CellRange cells = internal(rect);
        EXPECT_TRUE(cells.begin.x >= cells.end.x || cells.begin.y >= cells.end.y);
    }
}

TEST(OcclusionGrid, EveryCellIsOutsideABorderCellOrInternal)
{
    Rng rng(5);
    for (int i = 0; i < 500; ++i) {
        const glm::ivec2 size{1 + static_cast<int>(rng.below(90)),
                              1 + static_cast<int>(rng.below(90))};
        const OcclusionGrid grid = grid_of(size, 1 + static_cast<int>(rng.below(40)));
        PixelRect rect;
        rect.x = static_cast<int>(rng.below(static_cast<uint32_t>(size.x)));
        rect.y = static_cast<int>(rng.below(static_cast<uint32_t>(size.y)));
        rect.width = 1 + static_cast<int>(rng.below(static_cast<uint32_t>(size.x - rect.x)));
        rect.height = 1 + static_cast<int>(rng.below(static_cast<uint32_t>(size.y - rect.y)));
        for (int y = 0; y < grid.size_in_cells().y; ++y) {
            for (int x = 0; x < grid.size_in_cells().x; ++x) {
                const PixelRect all = grid.pixels({x, y});
                const PixelRect shared = intersection(all, rect);
                ASSERT_EQ(grid.touched(rect).contains({x, y}), shared.width > 0);
                ASSERT_EQ(grid.internal(rect).contains({x, y}), shared == all);
            }
        }
    }
}

TEST(OcclusionGrid, DrawingMakesATouchedCellUnknownButKeepsItsBound)
{
    OcclusionGrid grid = grid_of({64, 64}, 32);
    grid.mark_drawn({0, 0, 32, 16});
    grid.update({0, 0}, 0.5f);
    EXPECT_EQ(grid.cell({0, 0}).zfar, 0.5f);
    EXPECT_EQ(grid.cell({0, 0}).known_free, 0.5f);
    grid.mark_drawn({0, 0, 33, 32});
    EXPECT_EQ(grid.cell({0, 0}).zfar, 0.5f); // draws can only bring it nearer
    EXPECT_EQ(grid.cell({0, 0}).known_free, OcclusionGrid::kUnknown);
    EXPECT_FLOAT_EQ(grid.cell({0, 0}).covered, 1.5f);
    EXPECT_FLOAT_EQ(grid.cell({1, 0}).covered, 1.0f / 32.0f);
    EXPECT_FALSE(grid.cell({1, 0}).untouched);
    EXPECT_TRUE(grid.cell({0, 1}).untouched);
    EXPECT_EQ(grid.cell({0, 1}).known_free, OcclusionGrid::kFarthest);
}

TEST(OcclusionGrid, AnswersOfQueriesNarrowTheBoundFromBothSides)
{
    OcclusionGrid grid = grid_of({32, 32}, 32);
    grid.mark_drawn({0, 0, 32, 32});
    grid.learn_hidden({0, 0}, 0.8f);
    EXPECT_LT(grid.cell({0, 0}).zfar, 0.8f); // so that the same box is hidden again
    grid.learn_free({0, 0}, 0.4f);
    EXPECT_EQ(grid.cell({0, 0}).known_free, 0.4f);
    grid.learn_free({0, 0}, 0.3f);
    grid.learn_hidden({0, 0}, 0.9f);
    EXPECT_EQ(grid.cell({0, 0}).known_free, 0.4f);
    EXPECT_GT(grid.cell({0, 0}).zfar, 0.79f);
    EXPECT_LT(grid.cell({0, 0}).zfar, 0.8f);
}

TEST(OcclusionGrid, FarthestDepthIsThatOfThePlainLoop)
{
    Rng rng(6);
    std::vector<float> depths(61 * 40);
    for (float& d : depths) {
        d = rng.range(0.0f, 1.0f);
    }
    for (size_t width = 0; width < 40; ++width) {
        for (size_t height = 0; height < 5; ++height) {
            float expected = 0.0f;
            for (size_t y = 0; y < height; ++y) {
                for (size_t x = 0; x < width; ++x) {
                    expected = std::max(expected, depths[7 + y * 61 + x]);
                }
            }
            ASSERT_EQ(farthest_depth(depths.data() + 7, width, height, 61), expected);
        }
    }
}

// Of random boxes against random depth: the same pixel by pixel.
TEST(OcclusionGrid, ABoxIsHiddenWhereAllOfItsPixelsAreNearer)
{
    Rng rng(7);
    constexpr PixelRect kPart{3, 5, 61, 40};
    const View view = test::look({0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -1.0f});
    const ScreenSpace screen{view, SamplePositions::center};
    std::vector<float> depths(kPart.width * kPart.height);
    int hidden = 0;
    for (int round = 0; round < 300; ++round) {
        const glm::vec3 at{rng.range(-8.0f, 8.0f), rng.range(-8.0f, 8.0f),
                           rng.range(-30.0f, -12.0f)};
        const ScreenBox box{screen, Aabb{at - rng.range(0.2f, 4.0f), at + rng.range(0.2f, 4.0f)}};
        const float farthest = rng.range(0.99f, 1.0f);
        for (float& depth : depths) {
            depth = rng.range(0.0f, farthest);
        }
        bool expected = true;
        for (int y = 0; y < kPart.height; ++y) {
            for (int x = 0; x < kPart.width; ++x) {
                const glm::ivec2 pixel{kPart.x + x, kPart.y + y};
                expected &=
                    box.beyond(depths[static_cast<size_t>(y * kPart.width + x)], pixel, pixel);
            }
        }
        ASSERT_EQ(hides(depths.data(), kPart.width, kPart, box), expected);
        hidden += expected ? 1 : 0;
    }
    EXPECT_GT(hidden, 30);
    EXPECT_LT(hidden, 270);
}

} // namespace
} // namespace occlude
