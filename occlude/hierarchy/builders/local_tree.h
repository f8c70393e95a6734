// The tree over the parts of one object, in the space of the object: the lower level of a two-level
// tree (two_level.h).
#pragma once

#include <occlude/core/aabb.h>

#include <cstdint>
#include <span>
#include <vector>

namespace occlude {

/// The axis-aligned BSP tree over the parts of one object, in the space of the object.
struct LocalTree {
    static constexpr uint32_t kNone = 0xffffffffu;

    struct Node {
        Aabb box;                     ///< around the parts of the subtree
        uint32_t first_child = kNone; ///< of two adjacent ones; kNone for a leaf
        uint32_t part = kNone;        ///< the one part of a leaf
    };
    std::vector<Node> nodes; ///< the root first, parents before their children
};

/// A local tree over parts with these boxes. Each node is divided by the plane that separates its
/// boxes best, so that for parts cut by planes (split_triangles) the tree finds those planes again.
/// Deterministic. Empty for no parts. O(n log^2 n).
LocalTree build_local_tree(std::span<const Aabb> part_boxes);

} // namespace occlude
