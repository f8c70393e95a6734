// Uniform grid, nested where its cells hold too much, as a flat tree.
//
// Implements  the grids of K. Hillesland, B. Salomon, A. Lastra, D. Manocha, "Fast and Simple
//             Occlusion Culling using Hardware-Based Depth Queries", 2002, as a hierarchy: the root
//             has one child for each occupied cell, and a cell that holds too many items is a grid
//             again.
// Deviations  An item is in the cell of its centre and in no other; node boxes are those of the
//             items, not the cells. (The algorithm `uniform_grid` has cells that share items.)
// Guarantees  Deterministic: the same boxes give the same tree on every compiler.
// Cost        O(n log n), one thread. Nodes have many children: each step down tests all of them.
#pragma once

#include <occlude/hierarchy/hierarchy.h>

#include <span>

namespace occlude {

struct GridOptions {
    /// Cells of a grid: one for this many of its items, on average over empty and occupied ones.
    uint32_t items_per_cell = 8;
    /// A cell of at most this many items is not a grid again.
    uint32_t max_leaf_items = 1;
    /// Grids in grids at most so deep; at most 32. Items that are still together share a leaf.
    uint32_t max_depth = 16;
    /// Nodes with at most this many triangles become virtual leaves. 0: no virtual leaves.
    uint32_t leaf_triangles = 1024;
};

/// A grid over items 0 .. items.size()-1. Empty and unbounded boxes are allowed: they are items of
/// the root, outside of all cells.
Hierarchy build_grid(std::span<const ItemBounds> items, const GridOptions& options = {});

/// Names of the options; see core/option_text.h.
template <class Visit>
void visit_options(GridOptions& o, Visit&& visit)
{
    visit("items_per_cell", o.items_per_cell, {1},
          "a grid has one cell for this many of its items");
    visit("max_leaf_items", o.max_leaf_items, {1},
          "a cell of at most this many items is not a grid");
    visit("max_depth", o.max_depth, {0, 32}, "grids in grids at most so deep; at most 32");
    visit("leaf_triangles", o.leaf_triangles, {},
          "nodes of at most this many triangles become leaves; 0: none");
}

} // namespace occlude
