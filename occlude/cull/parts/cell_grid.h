// The items of a hierarchy in the cells of a grid of their own, where an item is in every cell that
// its box overlaps: what the algorithms that think in cells walk instead of the tree.
//
// A cell's box is around the parts of its items' boxes that lie in the cell. So every point of an
// item lies in the box of one of the item's cells: an item all of whose cells are hidden is hidden.
// A cell that holds too much can be a grid again (nested), over that box.
#pragma once

#include <occlude/hierarchy/hierarchy.h>
#include <occlude/hierarchy/lattice.h>

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace occlude {

struct CellGridOptions {
    /// As many cells as make this the mean number of triangles in a cell, empty ones included.
    uint64_t cell_triangles = 4096;
    /// Cells of more than twice that, and more than one item, are grids again, so deep at most.
    uint32_t nested_levels = 0;
};

class CellGrid {
public:
    static constexpr uint32_t kNone = 0xffffffffu;

    /// An occupied cell.
    struct Cell {
        Aabb box;
        glm::uvec3 at{0};   ///< in the lattice of its grid
        uint32_t first = 0; ///< into places
        uint32_t count = 0;
        uint64_t triangles = 0; ///< of all its items, as if wholly in it
        uint32_t grid = kNone;  ///< the grid nested in it
    };
    struct Grid {
        Lattice lattice;
        uint32_t first_cell = 0; ///< occupied cells of a grid are contiguous
        uint32_t cell_count = 0;
    };

    /// Builds the cells anew if `hierarchy` has another structure or other bounds than when they
    /// were built. O(items) if nothing has changed, O(overlaps log overlaps) otherwise.
    void update(const Hierarchy& hierarchy, const CellGridOptions& options);

    /// The outermost grid comes first; none if no item has a bounded box.
    std::span<const Grid> grids() const { return grids_; }
    std::span<const Cell> cells() const { return cells_; }
    std::span<const Cell> cells(const Grid& grid) const
    {
        return cells().subspan(grid.first_cell, grid.cell_count);
    }
    /// Places in Hierarchy::items() of the items of a cell, ascending.
    std::span<const uint32_t> places(const Cell& cell) const
    {
        return std::span{places_}.subspan(cell.first, cell.count);
    }
    /// Places of the items that have no bounded box and so are in no cell: always visible. Those
    /// with empty boxes are nowhere.
    std::span<const uint32_t> unbounded() const { return unbounded_; }

    /// The node that an item, by place, is an own item of.
    NodeId owner(uint32_t place) const { return owners_[place]; }

private:
    using Overlap = std::pair<uint64_t, uint32_t>; // index of a cell in its lattice, place

    bool is_current(const Hierarchy& hierarchy) const;
    void find_owners(const Hierarchy& hierarchy);
    uint32_t build_grid(const std::vector<uint32_t>& places, const Aabb& region,
                        const CellGridOptions& options, uint32_t level);
    Cell make_cell(std::span<const Overlap> overlaps, const Lattice& lattice, const Aabb& region);

    uint64_t structure_ = 0;
    std::vector<ItemBounds> bounds_; ///< by place, as the cells were built
    std::vector<NodeId> owners_;
    std::vector<Grid> grids_;
    std::vector<Cell> cells_;
    std::vector<uint32_t> places_;
    std::vector<uint32_t> unbounded_;
};

} // namespace occlude
