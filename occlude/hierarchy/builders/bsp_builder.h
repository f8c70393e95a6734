// Axis-aligned BSP tree with items in inner nodes.
//
// Implements  the tree of V. Kovalcik, J. Sochor, "Occlusion Culling with Statistically Optimized
//             Occlusion Queries", WSCG 2005, section 3, and of V. Kovalcik, P. Tobola, "Fast
//             Rendering of Complex Dynamic Scenes" (the upper of its two levels): each item is in
//             exactly one node, below all planes that it does not straddle.
// Deviations  The papers do not say where the planes go; see BspOptions::Split. Node boxes are the
//             boxes of the items, not the cells between the planes: tighter, and what is tested.
//             Straddling::child hangs what straddles a plane into a node of its own, which is
//             tested as the others are; as items of the node itself it is drawn whenever the node
//             is seen.
// Guarantees  Deterministic: the same boxes give the same tree on every compiler. The sides of a
//             plane never overlap (until a refit); with Straddling::own no item straddles a plane
//             above it.
// Cost        O(n * depth), one thread.
#pragma once

#include <occlude/hierarchy/hierarchy.h>

#include <array>
#include <span>
#include <string_view>

namespace occlude {

struct BspOptions {
    /// How the plane of a node is chosen.
    enum class Split : uint8_t {
        cost,   ///< the least area * triangles, summed over both sides and the straddling items
        middle, ///< the middle of the longest axis
        median, ///< the median of the upper faces along the longest axis
    };
    Split split = Split::cost;
    /// What happens to an item that straddles the plane of a node.
    enum class Straddling : uint8_t {
        own,   ///< it becomes an own item of the node, as in the papers
        child, ///< it goes to a third child, which other planes divide further
    };
    Straddling straddling = Straddling::own;
    /// A node of at most this many items is not split further.
    uint32_t max_leaf_items = 1;
    /// A node this far below the root is not split further; at most 64.
    uint32_t max_depth = 48;
    /// Nodes with at most this many triangles become virtual leaves. 0: no virtual leaves.
    uint32_t leaf_triangles = 1024;
};

/// A BSP tree over items 0 .. items.size()-1. A node has up to two children, the low side first, or
/// up to three, with the straddling items before both sides. If no plane separates anything, a leaf
/// keeps all its items. Empty and unbounded boxes are allowed: they are items of the root, above
/// all planes.
Hierarchy build_bsp(std::span<const ItemBounds> items, const BspOptions& options = {});

/// Names of the options; see core/option_text.h.
constexpr std::array<std::string_view, 3> option_names(BspOptions::Split)
{
    return {"cost", "middle", "median"};
}
constexpr std::array<std::string_view, 2> option_names(BspOptions::Straddling)
{
    return {"own", "child"};
}
template <class Visit>
void visit_options(BspOptions& o, Visit&& visit)
{
    visit("split", o.split, "how the plane of a node is chosen");
    visit("straddling", o.straddling,
          "whether items that straddle the plane stay in the node or go to a third child");
    visit("max_leaf_items", o.max_leaf_items, {1},
          "a node with at most this many items is not split");
    visit("max_depth", o.max_depth, {0, 64}, "a node this many levels below the root is not split");
    visit("leaf_triangles", o.leaf_triangles, {},
          "nodes with at most this many triangles become virtual leaves; 0: none do");
}

} // namespace occlude
