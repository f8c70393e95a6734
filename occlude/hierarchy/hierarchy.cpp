#include <occlude/hierarchy/hierarchy.h>

#include <occlude/core/assert.h>
#include <occlude/hierarchy/detail/box_area.h>
#include <occlude/hierarchy/detail/node_sums.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <utility>

namespace occlude {

using detail::box_area;
using detail::merged_box;
using detail::triangle_sum;

// Never decides anything but "changed", so a process-wide counter costs no determinism.
static uint64_t next_structure_version()
{
    static std::atomic<uint64_t> last{0};
    return ++last;
}

static std::string sentence(size_t node, const char* what)
{
    return "node " + std::to_string(node) + " " + what;
}

// Checks what a builder delivers of one node, and the parents and item sums that follow from it.
static std::string check_links(const Hierarchy& hierarchy, size_t id)
{
    const std::span<const Node> nodes = hierarchy.nodes();
    const Node& node = nodes[id];
    if (id > 0) {
        if (node.parent.value >= id) {
            return sentence(id, "does not come after its parent");
        }
        const Node& parent = nodes[node.parent.value];
        if (id < parent.first_child.value || id - parent.first_child.value >= parent.child_count) {
            return sentence(id, "is not among the children of its parent");
        }
    }
    if (node.child_count == 0) {
        if (node.first_child.valid()) {
            return sentence(id, "names a first child but has no children");
        }
    } else if (node.first_child.value <= id || node.first_child.value >= nodes.size() ||
               node.child_count > nodes.size() - node.first_child.value) {
        return sentence(id, "has children outside of the nodes after it");
    }
    uint64_t next_item = uint64_t{node.first_item} + node.own_items;
    for (uint32_t c = 0; c < node.child_count; ++c) {
        const Node& child = nodes[node.first_child.value + c];
        if (child.parent != NodeId{id}) {
            return sentence(node.first_child.value + c, "does not name its parent");
        }
        if (child.first_item != next_item) {
            return sentence(node.first_child.value + c, "does not begin where its sibling's or "
                                                        "parent's items end");
        }
        next_item += child.subtree_items;
    }
    if (next_item != uint64_t{node.first_item} + node.subtree_items) {
        return sentence(id, "does not count the items of its subtree");
    }
    return {};
}

static std::string check_items(const Hierarchy& hierarchy)
{
    if (hierarchy.items().size() != hierarchy.item_bounds().size()) {
        return "there are not as many item bounds as items";
    }
    std::vector<ItemId> sorted(hierarchy.items().begin(), hierarchy.items().end());
    std::sort(sorted.begin(), sorted.end());
    if (!sorted.empty() && !sorted.back().valid()) {
        return "an item id is invalid";
    }
    const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
    if (twice != sorted.end()) {
        return "item " + std::to_string(twice->value) + " is in the tree more than once";
    }
    return {};
}

// The part of validate() that concerns the shape: after it, every range lies within its array.
static std::string check_structure(const Hierarchy& hierarchy)
{
    if (std::string problem = check_items(hierarchy); !problem.empty()) {
        return problem;
    }
    const std::span<const Node> nodes = hierarchy.nodes();
    if (nodes.empty()) {
        return hierarchy.items().empty() ? "" : "there are items but no nodes";
    }
    if (nodes[0].parent.valid()) {
        return sentence(0, "is the root but has a parent");
    }
    if (nodes[0].first_item != 0 || nodes[0].subtree_items != hierarchy.items().size()) {
        return sentence(0, "is the root but does not cover all items");
    }
    for (size_t id = 0; id < nodes.size(); ++id) {
        if (std::string problem = check_links(hierarchy, id); !problem.empty()) {
            return problem;
        }
    }
    return {};
}

// Checks what is derived from the shape and the items.
static std::string check_derived(const Hierarchy& hierarchy)
{
    const std::span<const Node> nodes = hierarchy.nodes();
    const std::span<const ItemBounds> item_bounds = hierarchy.item_bounds();
    for (size_t i = 0; i < item_bounds.size(); ++i) {
        if (item_bounds[i].box.has_nan()) {
            return "the box of item " + std::to_string(hierarchy.items()[i].value) + " is NaN";
        }
    }
    std::vector<bool> below_leaf(nodes.size(), false); // below a virtual leaf
    for (size_t id = 0; id < nodes.size(); ++id) {
        const Node& node = nodes[id];
        if (node.box != merged_box(node, nodes, item_bounds)) {
            return sentence(id, "does not have the box around its items and children");
        }
        if (node.subtree_triangles != triangle_sum(node, nodes, item_bounds)) {
            return sentence(id, "does not count the triangles of its subtree");
        }
        if (node.leaf > 1) {
            return sentence(id, "has a leaf mark that is neither 0 nor 1");
        }
        if (node.child_count == 0 && node.leaf == 0) {
            return sentence(id, "has no children but is not a leaf");
        }
        if (id > 0) {
            const size_t parent = node.parent.value;
            below_leaf[id] = below_leaf[parent] || nodes[parent].leaf != 0;
        }
        if (below_leaf[id] && node.child_count > 0 && node.leaf != 0) {
            return sentence(id, "is a virtual leaf below a virtual leaf");
        }
    }
    return {};
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
    OCCLUDE_VALIDATE(check_structure(result));
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
    OCCLUDE_ASSERT(known, "refit() needs the bounds of every item that it is to look at");
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
    object_nodes_ = {}; // nobody said how the objects moved
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
        OCCLUDE_ASSERT(at.valid(), "a moved item is one of the hierarchy's");
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

std::string validate(const Hierarchy& hierarchy)
{
    std::string problem = check_structure(hierarchy);
    return problem.empty() ? check_derived(hierarchy) : problem;
}

double sah_cost(const Hierarchy& hierarchy)
{
    Aabb scene;
    for (const ItemBounds& item : hierarchy.item_bounds()) {
        if (item.box.is_bounded()) {
            scene = merge(scene, item.box);
        }
    }
    const double scene_area = box_area(scene);
    double cost = 0.0;
    for (const Node& node : hierarchy.nodes()) {
        if (!node.box.is_bounded()) {
            continue;
        }
        const double hit = scene_area > 0.0 ? box_area(node.box) / scene_area : 1.0;
        cost += hit * ((node.child_count > 0 ? 1.0 : 0.0) + node.own_items);
    }
    return cost;
}

} // namespace occlude
