#include <occlude/hierarchy/builders/cell_tree.h>

#include <occlude/core/assert.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace occlude {

CellTree::CellTree(std::span<const ItemBounds> items)
    : order(items.size())
    , nodes(1)
{
    OCCLUDE_ASSERT(items.size() < ItemId::kInvalid / 2, "too many items for 32-bit node ids");
    std::iota(order.begin(), order.end(), 0u);
    const auto bounded = std::stable_partition(
        order.begin(), order.end(), [&](uint32_t item) { return !items[item].box.is_bounded(); });
    odd_items = static_cast<uint32_t>(bounded - order.begin());
    nodes[0].own_items = odd_items;
    if (odd_items > 0) {
        top = bounded == order.end() ? nodes.size() : add_children(0, 0, 1);
    }
}

void CellTree::make_leaf(size_t node, size_t first, size_t end)
{
    nodes[node].first_item = static_cast<uint32_t>(first);
    nodes[node].own_items = static_cast<uint32_t>(end - first);
}

size_t CellTree::add_children(size_t node, size_t first, size_t count)
{
    const size_t child = nodes.size();
    nodes[node].first_item = static_cast<uint32_t>(first);
    nodes[node].first_child = NodeId{child};
    nodes[node].child_count = static_cast<uint32_t>(count);
    nodes.resize(child + count);
    return child;
}

Hierarchy CellTree::finish(std::span<const ItemBounds> items, uint32_t leaf_triangles)
{
    std::vector<ItemId> ids;
    std::vector<ItemBounds> bounds;
    ids.reserve(items.size());
    bounds.reserve(items.size());
    for (const uint32_t item : order) {
        ids.push_back(ItemId{item});
        bounds.push_back(items[item]);
    }
    Hierarchy hierarchy =
        Hierarchy::from_arrays(std::move(nodes), std::move(ids), std::move(bounds));
    hierarchy.set_virtual_leaves(leaf_triangles);
    return hierarchy;
}

} // namespace occlude
