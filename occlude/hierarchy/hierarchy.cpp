#include <occlude/hierarchy/hierarchy.h>

#include <occlude/core/assert.h>
#include <occlude/hierarchy/detail/node_sums.h>
#include <occlude/hierarchy/detail/structure.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <utility>

namespace occlude {

using detail::merged_box;
using detail::triangle_sum;

// It is only compared for equality, so that a process-wide counter does not affect determinism.
static uint64_t next_structure_version()
{
    static std::atomic<uint64_t> last{0};
    return ++last;
}

Hierarchy& Hierarchy::operator=(Hierarchy&& from) noexcept
{
    if (this == &from) {
        return *this;
    }
    nodes_ = std::exchange(from.nodes_, {});
    items_ = std::exchange(from.items_, {});
    item_bounds_ = std::exchange(from.item_bounds_, {});
    flagged_ = std::exchange(from.flagged_, {});
    object_nodes_ = std::exchange(from.object_nodes_, {});
    positions_ = std::exchange(from.positions_, {});
    shapes_ = std::exchange(from.shapes_, nullptr);
    structure_version_ = std::exchange(from.structure_version_, kMovedFrom);
    return *this;
}

Hierarchy Hierarchy::from_arrays(std::vector<Node> nodes, std::vector<ItemId> items,
                                 std::vector<ItemBounds> item_bounds)
{
    OCCLUDE_ASSERT(items.size() == item_bounds.size(),
                   "Hierarchy::from_arrays needs the bounds of each item");
    item_bounds.resize(items.size(), ItemBounds{.box = Aabb::everything()});
    Hierarchy result;
    result.nodes_ = std::move(nodes);
    result.items_ = std::move(items);
    result.item_bounds_ = std::move(item_bounds);
    result.structure_version_ = next_structure_version();

    for (ItemBounds& item : result.item_bounds_) {
        item.box = sanitized(item.box);
    }
    result.collect_flagged();
    const std::span<Node> all = result.nodes_;
    if (!all.empty()) {
        all[0].parent = NodeId{};
    }
    // Backward, so that children are finished before their parents.
    for (size_t id = all.size(); id-- > 0;) {
        Node& node = all[id];
        node.leaf = node.child_count == 0 ? 1 : 0;
        if (node.child_count == 0) {
            node.first_child = NodeId{};
        }
        node.subtree_items = node.own_items;
        const bool in_range = node.first_child.value <= all.size() &&
                              node.child_count <= all.size() - node.first_child.value;
        for (uint32_t c = 0; in_range && c < node.child_count; ++c) {
            Node& child = all[node.first_child.value + c];
            child.parent = NodeId{id};
            node.subtree_items += child.subtree_items;
        }
    }
    OCCLUDE_VALIDATE(detail::check_structure(result));
    result.refit_nodes();
    return result;
}

Hierarchy Hierarchy::from_finished_arrays(std::vector<Node> nodes, std::vector<ItemId> items,
                                          std::vector<ItemBounds> item_bounds)
{
    Hierarchy result;
    result.nodes_ = std::move(nodes);
    result.items_ = std::move(items);
    result.item_bounds_ = std::move(item_bounds);
    result.structure_version_ = next_structure_version();
    result.collect_flagged();
    OCCLUDE_VALIDATE(validate(result));
    return result;
}

void Hierarchy::set_virtual_leaves(uint32_t triangles)
{
    structure_version_ = next_structure_version();
    std::vector<bool> below_leaf(nodes_.size(), false); // below a virtual leaf
    for (size_t id = 0; id < nodes_.size(); ++id) {
        Node& node = nodes_[id];
        if (id > 0) {
            const Node& parent = nodes_[node.parent.value];
            below_leaf[id] = below_leaf[node.parent.value] || parent.leaf != 0;
        }
        bool leaf = node.child_count == 0;
        if (!leaf && triangles > 0 && !below_leaf[id]) {
            leaf = node.subtree_triangles <= triangles && node.box.is_bounded();
            for (uint32_t c = 0; c < node.child_count; ++c) {
                leaf = leaf && !nodes_[node.first_child.value + c].box.is_empty();
            }
        }
        node.leaf = leaf ? 1 : 0;
    }
}

void Hierarchy::refit_nodes()
{
    // Backward, so that children are finished before their parents.
    for (size_t id = nodes_.size(); id-- > 0;) {
        nodes_[id].subtree_triangles = triangle_sum(nodes_[id], nodes_, item_bounds_);
        nodes_[id].box = merged_box(nodes_[id], nodes_, item_bounds_);
    }
}

void Hierarchy::collect_flagged()
{
    flagged_.clear();
    for (uint32_t i = 0; i < std::min(items_.size(), item_bounds_.size()); ++i) {
        if (has_flag(item_bounds_[i].flags, kDrawnOutOfTurn)) {
            flagged_.push_back({items_[i], ItemPosition{i}});
        }
    }
    std::sort(flagged_.begin(), flagged_.end());
}

// Takes new bounds of the item at that position; true if its flags have changed.
bool Hierarchy::take_bounds(ItemPosition at, std::span<const ItemBounds> bounds_by_item)
{
    ItemBounds& item = item_bounds_[at.value];
    const bool known = items_[at.value].value < bounds_by_item.size();
    OCCLUDE_ASSERT(known, "refit() needs the bounds of every item that it updates");
    if (!known) {
        item.box = Aabb::everything();
        return false;
    }
    const ItemFlags old_flags = item.flags;
    item = bounds_by_item[items_[at.value].value];
    item.box = sanitized(item.box);
    return item.flags != old_flags;
}

void Hierarchy::refit(std::span<const ItemBounds> bounds_by_item)
{
    bool flags_changed = false;
    for (size_t i = 0; i < items_.size(); ++i) {
        flags_changed = take_bounds(ItemPosition{i}, bounds_by_item) || flags_changed;
    }
    if (flags_changed) {
        collect_flagged();
    }
    object_nodes_ = {}; // the caller does not say how the objects moved
    refit_nodes();
    OCCLUDE_VALIDATE(validate(*this));
}

void Hierarchy::index_positions()
{
    if (positions_.structure_version == structure_version_) {
        return;
    }
    positions_.structure_version = structure_version_;
    uint32_t ids = 0;
    for (const ItemId item : items_) {
        ids = std::max(ids, item.value + 1);
    }
    positions_.of_item.assign(ids, ItemPosition{});
    for (size_t i = 0; i < items_.size(); ++i) {
        positions_.of_item[items_[i].value] = ItemPosition{i};
    }
    positions_.owner_of.resize(items_.size());
    for (size_t id = 0; id < nodes_.size(); ++id) {
        const Node& node = nodes_[id];
        std::fill_n(positions_.owner_of.begin() + node.first_item, node.own_items, NodeId{id});
    }
    positions_.marked.assign((nodes_.size() + 63) / 64, 0);
}

void Hierarchy::refit(std::span<const ItemId> moved, std::span<const ItemBounds> bounds_by_item,
                      std::vector<NodeId>* changed)
{
    if (moved.empty()) {
        return;
    }
    index_positions();
    std::vector<uint64_t>& marked = positions_.marked;
    const auto mark = [&](NodeId node) {
        marked[node.value / 64] |= uint64_t{1} << node.value % 64;
    };
    bool flags_changed = false;
    for (const ItemId item : moved) {
        const bool indexed = item.value < positions_.of_item.size();
        const ItemPosition at = indexed ? positions_.of_item[item.value] : ItemPosition{};
        OCCLUDE_ASSERT(at.valid(), "a moved item must be in the hierarchy");
        if (at.valid()) {
            flags_changed = take_bounds(at, bounds_by_item) || flags_changed;
            mark(positions_.owner_of[at.value]);
        }
    }
    if (flags_changed) {
        collect_flagged();
    }
    object_nodes_ = {};
    // Backward, so that children are finished before their parents, which they mark on the way.
    for (size_t word = marked.size(); word-- > 0;) {
        while (marked[word] != 0) {
            const auto bit = static_cast<uint32_t>(63 - std::countl_zero(marked[word]));
            marked[word] ^= uint64_t{1} << bit;
            const NodeId id{64 * word + bit};
            Node& node = nodes_[id.value];
            const uint32_t triangles = triangle_sum(node, nodes_, item_bounds_);
            const Aabb box = merged_box(node, nodes_, item_bounds_);
            const bool same = triangles == node.subtree_triangles && box == node.box;
            node.subtree_triangles = triangles;
            node.box = box;
            if (!same && changed != nullptr) {
                changed->push_back(id);
            }
            if (!same && node.parent.valid()) {
                mark(node.parent);
            }
        }
    }
    OCCLUDE_VALIDATE(validate(*this));
}

size_t Hierarchy::memory_bytes() const
{
    const auto bytes = [](const auto& vector) { return vector.size() * sizeof(vector[0]); };
    return bytes(nodes_) + bytes(items_) + bytes(item_bounds_) + bytes(flagged_) +
           bytes(object_nodes_.object) + bytes(object_nodes_.box) + bytes(object_nodes_.key) +
           bytes(object_nodes_.frames) + bytes(positions_.of_item) + bytes(positions_.owner_of) +
           bytes(positions_.marked);
}

void Hierarchy::set_object_nodes(ObjectNodes nodes)
{
    const bool complete =
        nodes.empty() || (nodes.object.size() == nodes_.size() &&
                          nodes.box.size() == nodes_.size() && nodes.key.size() == nodes_.size());
    OCCLUDE_ASSERT(complete,
                   "object nodes need one object, one box and one key for each node of the tree");
    object_nodes_ = complete ? std::move(nodes) : ObjectNodes{};
}

} // namespace occlude
