// The common part of the octree and the grid: an item is in the cell of its centre, and items
// without a centre stay with the root. Internal to hierarchy/.
#pragma once

#include <occlude/hierarchy/hierarchy.h>

#include <span>
#include <vector>

namespace occlude {

/// Item ids in the order of the tree, and its nodes as Hierarchy::from_arrays takes them.
struct CellTree {
    std::vector<uint32_t> order;
    std::vector<Node> nodes;

    /// Contains all ids of `items`, first those of unbounded and empty boxes. The root keeps these.
    /// The rest gets a node below the root; if there are no such boxes, this node is the root.
    explicit CellTree(std::span<const ItemBounds> items);

    uint32_t odd_items = 0; ///< number of items at the front of `order` that stay with the root
    size_t top = 0;         ///< the node for the rest; nodes.size() if there are no other items

    /// Makes items [first, end) of `order` the own items of a node.
    void make_leaf(size_t node, size_t first, size_t end);
    /// Adds `count` children of a node at the end of `nodes`, and returns the first.
    size_t add_children(size_t node, size_t first, size_t count);

    Hierarchy finish(std::span<const ItemBounds> items, uint32_t leaf_triangles);
};

} // namespace occlude
