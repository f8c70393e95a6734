// The sums and the box of a subtree, from its own items and its finished children. Internal.
#pragma once

#include <occlude/hierarchy/hierarchy.h>

#include <algorithm>
#include <limits>
#include <span>

namespace occlude::detail {

inline uint32_t saturating_add(uint32_t a, uint32_t b)
{
    return a + std::min(b, std::numeric_limits<uint32_t>::max() - a);
}

/// The triangles in the subtree of `node`.
inline uint32_t triangle_sum(const Node& node, std::span<const Node> nodes,
                             std::span<const ItemBounds> item_bounds)
{
    uint32_t sum = 0;
    for (const ItemBounds& item : item_bounds.subspan(node.first_item, node.own_items)) {
        sum = saturating_add(sum, item.triangles);
    }
    for (uint32_t c = 0; c < node.child_count; ++c) {
        sum = saturating_add(sum, nodes[node.first_child.value + c].subtree_triangles);
    }
    return sum;
}

/// The box around the items of `node` and its finished children.
inline Aabb merged_box(const Node& node, std::span<const Node> nodes,
                       std::span<const ItemBounds> item_bounds)
{
    Aabb box;
    for (const ItemBounds& item : item_bounds.subspan(node.first_item, node.own_items)) {
        box = merge(box, item.box);
    }
    for (uint32_t c = 0; c < node.child_count; ++c) {
        box = merge(box, nodes[node.first_child.value + c].box);
    }
    return box;
}

/// Sets the sums and the box of `node`; its children are indices into `nodes`.
inline void sum_up(Node& node, std::span<const Node> nodes, std::span<const ItemBounds> item_bounds)
{
    node.subtree_items = node.own_items;
    for (uint32_t c = 0; c < node.child_count; ++c) {
        node.subtree_items += nodes[node.first_child.value + c].subtree_items;
    }
    node.subtree_triangles = triangle_sum(node, nodes, item_bounds);
    node.box = merged_box(node, nodes, item_bounds);
}

} // namespace occlude::detail
