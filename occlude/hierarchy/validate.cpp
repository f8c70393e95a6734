// Checks the rules of every tree from its arrays alone, and computes the quality of a tree.
#include <occlude/hierarchy/detail/box_area.h>
#include <occlude/hierarchy/detail/node_sums.h>
#include <occlude/hierarchy/detail/structure.h>
#include <occlude/hierarchy/hierarchy.h>

#include <algorithm>

namespace occlude {

using detail::box_area;
using detail::merged_box;
using detail::triangle_sum;

static std::string sentence(size_t node, const char* what)
{
    return "node " + std::to_string(node) + " " + what;
}

// Checks the fields of one node that a builder sets, and the parents and item sums that follow.
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
        return "the numbers of items and item bounds differ";
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

// The part of validate() about the shape. If it passes, every range lies within its array.
std::string detail::check_structure(const Hierarchy& hierarchy)
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

std::string validate(const Hierarchy& hierarchy)
{
    std::string problem = detail::check_structure(hierarchy);
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
