// Bounding volume hierarchy by binned surface area heuristic.
//
// Implements  I. Wald, "On fast construction of SAH-based bounding volume hierarchies", IEEE
//             Symposium on Interactive Ray Tracing 2007.
// Deviations  Subtrees are built side by side (task_runner.h); the tree does not depend on the
//             number of threads. The cost of a leaf counts triangles, not items: an occlusion test
//             pays for a whole item, however many triangles it has.
// Guarantees  Deterministic: the same boxes give the same tree on every compiler and thread count.
// Cost        O(n log n); 1,000,000 boxes in under a second on two cores.
#pragma once

#include <occlude/hierarchy/builders/task_runner.h>
#include <occlude/hierarchy/hierarchy.h>

#include <span>

namespace occlude {

struct BvhOptions {
    /// A node of at most this many items is not split further. 0 counts as 1.
    uint32_t max_leaf_items = 4;
    /// ... unless it has several items with more triangles than this together.
    uint32_t max_leaf_triangles = 64;
    /// Nodes with at most this many triangles become virtual leaves. docs/hierarchy.md says how the
    /// default was measured. 0: no virtual leaves.
    uint32_t leaf_triangles = 1024;
    /// The number of candidate planes per axis, plus one: 2 to 32.
    uint32_t bins = 16;
    /// Runs the work on subtrees in parallel; must live until build_bvh() returns. Null:
    /// default_task_runner().
    TaskRunner* tasks = nullptr;
};

/// A BVH over items 0 .. items.size()-1; no items give an empty hierarchy. Each inner node has two
/// children, each real leaf 1 to max_leaf_items items in the order of their ids.
///
/// Empty, unbounded and NaN boxes are allowed. The unbounded and NaN ones go into a leaf of their
/// own below the root, so that they do not enlarge other boxes. The empty ones go into another
/// leaf, whose box is empty: it is outside every frustum, so that they are never drawn. With such
/// leaves the root has up to three children and is never a virtual leaf.
Hierarchy build_bvh(std::span<const ItemBounds> items, const BvhOptions& options = {});

/// Names of the options; see core/option_text.h.
template <class Visit>
void visit_options(BvhOptions& o, Visit&& visit)
{
    visit("max_leaf_items", o.max_leaf_items, {1},
          "a node with at most this many items is not split");
    visit("max_leaf_triangles", o.max_leaf_triangles, {}, "... unless they have more triangles");
    visit("leaf_triangles", o.leaf_triangles, {},
          "nodes with at most this many triangles become virtual leaves; 0: none do");
    visit("bins", o.bins, {2, 32}, "number of candidate planes per axis, plus one");
}

} // namespace occlude
