// A grid over the items of a hierarchy, where an item is in every cell that its box overlaps. The
// algorithms that work on cells walk this grid instead of the tree.
//
// A cell's box bounds the parts of its items' boxes that lie in the cell. So every point of an item
// lies in the box of one of the item's cells: if all of them are hidden, so is the item. A cell
// with too many triangles can hold a nested grid over that box.
#pragma once

#include <occlude/core/assert.h>
#include <occlude/hierarchy/hierarchy.h>
#include <occlude/hierarchy/lattice.h>

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace occlude {

struct CellGridOptions {
    /// The mean number of triangles per cell, empty cells included, which sets the number of cells.
    /// If items overlap one another, there are fewer cells, so that an item is in at most 32 cells
    /// on average over all grids.
    uint64_t cell_triangles = 4096;
    /// A cell of more than twice that many triangles and more than one item holds a nested grid, up
    /// to this many levels deep.
    uint32_t nested_levels = 0;
};

class CellGrid {
public:
    static constexpr uint32_t kNone = 0xffffffffu;

    /// An occupied cell.
    struct Cell {
        Aabb box;
        glm::uvec3 at{0};   ///< its index in the lattice of its grid
        uint32_t first = 0; ///< its first index into the positions of all cells
        uint32_t count = 0;
        uint64_t triangles = 0; ///< triangles of all its items, as if they lay wholly in the cell
        uint32_t grid = kNone;  ///< the grid nested in it
    };
    struct Grid {
        Lattice lattice;
        uint32_t first_cell = 0; ///< occupied cells of a grid are contiguous
        uint32_t cell_count = 0;
    };

    /// Builds the cells again if `hierarchy` has another structure or other bounds than at the last
    /// build. O(items) if nothing has changed, O(n log^2 n) for n items otherwise.
    void update(const Hierarchy& hierarchy, const CellGridOptions& options);

    /// The outermost grid comes first. Empty if no item has a bounded box.
    std::span<const Grid> grids() const { return grids_; }
    std::span<const Cell> cells() const { return cells_; }
    std::span<const Cell> cells(const Grid& grid) const
    {
        return cells().subspan(grid.first_cell, grid.cell_count);
    }
    /// The items of a cell, by position, ascending.
    std::span<const ItemPosition> items(const Cell& cell) const
    {
        OCCLUDE_ASSERT(cell.first + cell.count <= items_.size(),
                       "the cell belongs to another grid");
        return std::span{items_}.subspan(cell.first, cell.count);
    }
    /// The items that are always visible: their boxes are not bounded, so that they are in no cell.
    /// An item with an empty box is neither here nor in a cell.
    std::span<const ItemPosition> unbounded() const { return unbounded_; }

    /// The node whose own items include the item.
    NodeId owner(ItemPosition item) const { return owners_[item.value]; }

private:
    using Overlap = std::pair<uint64_t, ItemPosition>; // (index of a cell in its lattice, item)

    bool is_current(const Hierarchy& hierarchy) const;
    void find_owners(const Hierarchy& hierarchy);
    uint64_t count_overlaps(std::span<const ItemPosition> items, const Aabb& region,
                            const Lattice& lattice) const;
    Lattice choose_lattice(std::span<const ItemPosition> items, const Aabb& region,
                           uint64_t cells) const;
    uint32_t build_grid(const std::vector<ItemPosition>& items, const Aabb& region,
                        const CellGridOptions& options, uint32_t level);
    Cell make_cell(std::span<const Overlap> overlaps, const Lattice& lattice, const Aabb& region);

    uint64_t structure_ = 0;
    uint64_t overlap_budget_ = 0;    ///< how many overlaps the grids still to be built may have
                                     ///< together
    std::vector<ItemBounds> bounds_; ///< by position, as the cells were built
    std::vector<NodeId> owners_;
    std::vector<Grid> grids_;
    std::vector<Cell> cells_;
    std::vector<ItemPosition> items_;
    std::vector<ItemPosition> unbounded_;
};

} // namespace occlude
