// Octree by the centres of the items.
//
// Implements  the common octree: a cube is halved along all three axes at once until few items are
//             left. Built from the Morton codes of the centres, sorted once.
// Deviations  An item is only in the cell of its centre, so cells overlap by the size of their
//             items. Node boxes bound the items, not the cubes, because tests need tight boxes. A
//             cube with only one occupied octant has no node, nor has an empty octant.
// Guarantees  Deterministic: the same boxes give the same tree on every compiler.
// Cost        O(n log n), one thread; about half the processor time of build_bvh().
#pragma once

#include <occlude/hierarchy/hierarchy.h>

#include <span>

namespace occlude {

struct OctreeOptions {
    /// A cube of at most this many items is not split further.
    uint32_t max_leaf_items = 1;
    /// Cubes are halved at most this many times, at most 21. Items that are then still together
    /// share a leaf.
    uint32_t max_depth = 21;
    /// Nodes with at most this many triangles become virtual leaves. 0: no virtual leaves.
    uint32_t leaf_triangles = 1024;
};

/// An octree over items 0 .. items.size()-1. Empty and unbounded boxes are allowed: they are items
/// of the root, above all cubes.
Hierarchy build_octree(std::span<const ItemBounds> items, const OctreeOptions& options = {});

/// Names of the options; see core/option_text.h.
template <class Visit>
void visit_options(OctreeOptions& o, Visit&& visit)
{
    visit("max_leaf_items", o.max_leaf_items, {1},
          "a cube with at most this many items is not split");
    visit("max_depth", o.max_depth, {0, 21}, "cubes are halved at most this many times");
    visit("leaf_triangles", o.leaf_triangles, {},
          "nodes with at most this many triangles become virtual leaves; 0: none do");
}

} // namespace occlude
