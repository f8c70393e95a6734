// Uniform grid as a flat tree; crowded cells hold nested grids.
//
// Implements  the grids of K. Hillesland, B. Salomon, A. Lastra, D. Manocha, "Fast and Simple
//             Occlusion Culling using Hardware-Based Depth Queries", 2002, as a hierarchy: the root
//             has one child for each occupied cell, and a cell that holds too many items is a grid
//             again.
// Deviations  An item is only in the cell of its centre, and a node's box bounds its items, not the
//             cell. (In the algorithm `uniform_grid`, cells share items.)
// Guarantees  Deterministic: the same boxes give the same tree on every compiler.
// Cost        O(n log n), one thread. Nodes have many children: each step down tests all of them.
#pragma once

#include <occlude/hierarchy/hierarchy.h>

#include <span>

namespace occlude {

struct GridOptions {
    /// Number of items per cell, averaged over empty and occupied cells.
    uint32_t items_per_cell = 8;
    /// A cell with at most this many items holds no nested grid.
    uint32_t max_leaf_items = 1;
    /// Grids are nested up to this many levels deep, at most 32. Items that are then still together
    /// share a leaf.
    uint32_t max_depth = 16;
    /// Nodes with at most this many triangles become virtual leaves. 0: no virtual leaves.
    uint32_t leaf_triangles = 1024;
};

/// A grid over items 0 .. items.size()-1. Empty and unbounded boxes are allowed: they are items of
/// the root, outside all cells.
Hierarchy build_grid(std::span<const ItemBounds> items, const GridOptions& options = {});

/// Names of the options; see core/option_text.h.
template <class Visit>
void visit_options(GridOptions& o, Visit&& visit)
{
    visit("items_per_cell", o.items_per_cell, {1}, "mean number of items per cell of a grid");
    visit("max_leaf_items", o.max_leaf_items, {1},
          "a cell with at most this many items holds no nested grid");
    visit("max_depth", o.max_depth, {0, 32}, "grids are nested at most this many levels deep");
    visit("leaf_triangles", o.leaf_triangles, {},
          "nodes with at most this many triangles become virtual leaves; 0: none do");
}

} // namespace occlude
