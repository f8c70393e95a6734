#include "replay/check_tree.h"

#include <fmt/format.h>

#include <algorithm>

namespace occlude::tools {

namespace {

std::string check_items(const RecordedTree& tree)
{
    std::vector<ItemId> sorted = tree.items;
    std::sort(sorted.begin(), sorted.end());
    if (!sorted.empty() && !sorted.back().valid()) {
        return "an item has an invalid id";
    }
    if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) {
        return "an item occurs twice";
    }
    const bool nan = std::any_of(tree.bounds.begin(), tree.bounds.end(),
                                 [](const ItemBounds& item) { return item.box.has_nan(); });
    return nan ? "a box is not a number" : "";
}

/// Children lie after their parents, next to each other, and each node is the child of one. Items
/// of a node come before those of its children.
std::string check_links(const RecordedTree& tree)
{
    uint64_t next_child = 1;
    if (tree.nodes[0].parent.valid() || tree.nodes[0].first_item != 0) {
        return "the root is below another node";
    }
    std::vector<bool> claimed(tree.nodes.size(), false);
    for (size_t id = 0; id < tree.nodes.size(); ++id) {
        const Node& node = tree.nodes[id];
        const uint64_t items_end = uint64_t{node.first_item} + node.subtree_items;
        if (items_end > tree.items.size() || node.own_items > node.subtree_items) {
            return fmt::format("node {} has items that do not exist", id);
        }
        uint64_t next_item = uint64_t{node.first_item} + node.own_items;
        if (node.child_count == 0) {
            if (node.first_child.valid() || next_item != items_end) {
                return fmt::format("node {} counts children or items that it does not have", id);
            }
            continue;
        }
        const uint64_t first = node.first_child.value;
        if (first <= id || first + node.child_count > tree.nodes.size()) {
            return fmt::format("node {} has children that do not exist", id);
        }
        for (uint64_t child = first; child < first + node.child_count; ++child) {
            const Node& below = tree.nodes[child];
            if (claimed[child] || below.parent != NodeId{id} || below.first_item != next_item) {
                return fmt::format("node {} is not among the children of its parent", child);
            }
            claimed[child] = true;
            next_item += below.subtree_items;
        }
        next_child += node.child_count;
        if (next_item != items_end) {
            return fmt::format("node {} does not count its items", id);
        }
    }
    if (next_child != tree.nodes.size() || tree.nodes[0].subtree_items != tree.items.size()) {
        return "a node or an item has no parent";
    }
    return {};
}

/// The values that builders derive: boxes, sums and leaves.
std::string check_derived(const RecordedTree& tree)
{
    const Hierarchy derived = Hierarchy::from_arrays(tree.nodes, tree.items, tree.bounds);
    std::vector<bool> below_leaf(tree.nodes.size(), false);
    for (size_t id = 0; id < tree.nodes.size(); ++id) {
        const Node& node = tree.nodes[id];
        const Node& expected = derived.nodes()[id];
        if (node.box != expected.box || node.subtree_triangles != expected.subtree_triangles) {
            return fmt::format("node {} does not bound or count what is below it", id);
        }
        if (id > 0) {
            const uint32_t parent = node.parent.value;
            below_leaf[id] = below_leaf[parent] || tree.nodes[parent].leaf != 0;
        }
        const bool must_be_leaf = node.child_count == 0;
        if (node.leaf > 1 || (must_be_leaf && node.leaf == 0) ||
            (!must_be_leaf && node.leaf != 0 && below_leaf[id])) {
            return fmt::format("node {} is marked as a leaf, or not, where it must not be", id);
        }
    }
    return {};
}

} // namespace

std::string check_tree(const RecordedTree& tree)
{
    if (tree.nodes.empty() || tree.items.size() != tree.bounds.size()) {
        return "its lists do not belong together";
    }
    for (const auto check : {check_items, check_links, check_derived}) {
        if (std::string problem = check(tree); !problem.empty()) {
            return problem;
        }
    }
    return {};
}

} // namespace occlude::tools
