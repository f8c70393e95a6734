// What the octree and the grid have in common: items are in the cell of their centre, and what has
// no centre stays with the root. Internal to hierarchy/.
#pragma once

#include <occlude/hierarchy/hierarchy.h>

#include <span>
#include <vector>

namespace occlude {

/// Item ids in the order of the tree, and its nodes as Hierarchy::from_arrays takes them.
struct CellTree {
    std::vector<uint32_t> order;
    std::vector<Node> nodes;

    /// All ids of `items`, those of unbounded and empty boxes first; a root that keeps these; and
    /// below it, or in its place if there are none of these, a node for the rest.
    explicit CellTree(std::span<const ItemBounds> items);

    uint32_t odd_items = 0; ///< how many of `order` stay with the root
    size_t top = 0;         ///< the node for the rest; nodes.size() if there is no rest

    /// Makes the items [first, end) of `order` the own items of a node.
    void make_leaf(size_t node, size_t first, size_t end);
    /// Gives a node `count` children at the end of `nodes`, and returns the first.
    size_t add_children(size_t node, size_t first, size_t count);

    Hierarchy finish(std::span<const ItemBounds> items, uint32_t leaf_triangles);
};

} // namespace occlude
