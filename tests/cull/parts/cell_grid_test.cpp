#include <occlude/cull/parts/cell_grid.h>

#include "support/trees.h"
#include "support/visibility_script.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cfloat>
#include <set>

namespace occlude {
namespace {

// Boxes of size 1 from x to x + 1, one triangle each.
ItemBounds on_x(float x, float width = 1.0f, uint32_t triangles = 1)
{
    return {{{x, 0.0f, 0.0f}, {x + width, 1.0f, 1.0f}}, triangles};
}

// The cells that hold an item, by its id.
std::vector<uint32_t> cells_of(const CellGrid& grid, const Hierarchy& tree, uint32_t item)
{
    std::vector<uint32_t> cells;
    for (uint32_t c = 0; c < grid.cells().size(); ++c) {
        for (const ItemPosition at : grid.items(grid.cells()[c])) {
            if (tree.item(at).value == item) {
                cells.push_back(c);
            }
        }
    }
    return cells;
}

TEST(CellGrid, AnItemIsInEveryCellThatItOverlaps)
{
    // From 0 to 9 in three cells. Item 2 straddles the wall at 3.
    const std::vector<ItemBounds> items{on_x(0), on_x(8), on_x(2.5f)};
    const Hierarchy tree = build_bvh(items);
    CellGrid grid;
    grid.update(tree, {.cell_triangles = 1});
    ASSERT_EQ(grid.cells().size(), 3u);
    EXPECT_EQ(cells_of(grid, tree, 0), std::vector<uint32_t>{0});
    EXPECT_EQ(cells_of(grid, tree, 1), std::vector<uint32_t>{2});
    EXPECT_EQ(cells_of(grid, tree, 2), (std::vector<uint32_t>{0, 1}));
    // Bounds enclose the contents of the cell, and not its walls.
    EXPECT_EQ(grid.cells()[2].box, items[1].box);
    EXPECT_NEAR(grid.cells()[1].box.min.x, 3.0f, 1e-4f);
    EXPECT_LE(grid.cells()[1].box.min.x, 3.0f);
    EXPECT_EQ(grid.cells()[1].box.max.x, 3.5f);
}

TEST(CellGrid, EveryPointOfAnItemIsInTheBoxOfOneOfItsCells)
{
    for (const uint32_t levels : {0u, 2u}) {
        for (const float offset : {0.0f, 3e4f}) {
            std::vector<ItemBounds> items = test::random_boxes(400, 11, 20.0f, 9.0f);
            for (ItemBounds& item : items) {
                item.box.min += offset;
                item.box.max += offset;
            }
            const Hierarchy tree = build_bvh(items);
            CellGrid grid;
            grid.update(tree, {.cell_triangles = 400, .nested_levels = levels});
            EXPECT_EQ(grid.grids().size() > 1, levels > 0);
            std::vector<std::vector<Aabb>> leaf_boxes(items.size()); // of cells without a grid
            size_t overlaps = 0;
            for (const CellGrid::Cell& cell : grid.cells()) {
                for (const ItemPosition at : grid.items(cell)) {
                    if (cell.grid == CellGrid::kNone) {
                        leaf_boxes[tree.item(at).value].push_back(cell.box);
                        ++overlaps;
                    }
                }
            }
            EXPECT_GT(overlaps, items.size() * 3 / 2);
            Rng rng{12};
            for (size_t i = 0; i < items.size(); ++i) {
                for (int sample = 0; sample < 40; ++sample) {
                    const Aabb& box = items[i].box;
                    glm::vec3 p = sample % 2 == 0 ? box.min : box.max; // corners too
                    if (sample > 1) {
                        p = {rng.range(box.min.x, box.max.x), rng.range(box.min.y, box.max.y),
                             rng.range(box.min.z, box.max.z)};
                    }
                    ASSERT_TRUE(std::ranges::any_of(leaf_boxes[i],
                                                    [&](const Aabb& cell) {
                                                        return contains(cell, {p, p});
                                                    }))
                        << "item " << i;
                }
            }
        }
    }
}

TEST(CellGrid, BoundsThatChangeMakeNewCellsAndOthersDoNot)
{
    std::vector<ItemBounds> items = test::random_boxes(100, 13);
    Hierarchy tree = build_bvh(items);
    CellGrid grid;
    const CellGridOptions options{.cell_triangles = 500};
    grid.update(tree, options);
    const CellGrid::Cell* cells = grid.cells().data();
    grid.update(tree, options);
    EXPECT_EQ(grid.cells().data(), cells);
    const Aabb before = grid.cells()[0].box;
    for (ItemBounds& item : items) {
        item.box.min += 100.0f;
        item.box.max += 100.0f;
    }
    tree.refit(items);
    grid.update(tree, options);
    EXPECT_NE(grid.cells()[0].box, before);
}

// Overlaps must not grow as n^2 (uniform grids) or n^3 (nested grids) with n items that overlap one
// another.
TEST(CellGrid, ItemsThatOverlapOneAnotherAreInFewCellsEach)
{
    std::vector<ItemBounds> items;
    for (uint32_t i = 0; i < 2000; ++i) {
        const float inset = 0.001f * static_cast<float>(i);
        items.push_back({{glm::vec3{-50.0f + inset}, glm::vec3{50.0f - inset}}, 100'000});
    }
    const Hierarchy tree = build_bvh(items);
    for (const uint32_t levels : {0u, 1u, 8u}) {
        CellGrid grid;
        grid.update(tree, {.cell_triangles = 100, .nested_levels = levels});
        size_t overlaps = 0;
        for (const CellGrid::Cell& cell : grid.cells()) {
            overlaps += grid.items(cell).size();
        }
        EXPECT_LE(overlaps, 66'000u) << levels << " levels"; // at most 2^16, or 32 for each item
        EXPECT_GE(overlaps, 2000u);
        EXPECT_GE(grid.cells().size(), 16u); // it is still a grid
    }
}

TEST(CellGrid, OddBoxesAreInNoCell)
{
    std::vector<ItemBounds> items = test::random_boxes(20, 14);
    items[3].box.min.x = std::numeric_limits<float>::quiet_NaN();
    items[4].box = Aabb::everything();
    items[5].box = Aabb::empty();
    items[6].box = {glm::vec3{-FLT_MAX}, glm::vec3{FLT_MAX}};
    const Hierarchy tree = build_bvh(items);
    CellGrid grid;
    grid.update(tree, {.cell_triangles = 100, .nested_levels = 1});
    std::set<uint32_t> unbounded;
    for (const ItemPosition at : grid.unbounded()) {
        unbounded.insert(tree.item(at).value);
        EXPECT_EQ(tree.own_items(grid.owner(at)).size() > 0, true);
    }
    EXPECT_EQ(unbounded, (std::set<uint32_t>{3, 4}));
    EXPECT_TRUE(cells_of(grid, tree, 5).empty());
    EXPECT_FALSE(cells_of(grid, tree, 6).empty());

    CellGrid nothing;
    nothing.update(build_bvh({}), {});
    EXPECT_TRUE(nothing.grids().empty());
}

} // namespace
} // namespace occlude
