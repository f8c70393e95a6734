// Item boxes for the tests of hierarchy/.
#pragma once

#include <occlude/core/rng.h>
#include <occlude/hierarchy/hierarchy.h>

#include <glm/common.hpp>

#include <algorithm>
#include <limits>
#include <vector>

namespace occlude::test {

inline constexpr float kInf = Aabb::kInfinity;
inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// `count` boxes of 0 to 4 units in a cube of 1000 units, with 0 to 999 triangles.
inline std::vector<ItemBounds> random_items(size_t count, uint64_t seed)
{
    Rng rng(seed);
    std::vector<ItemBounds> items(count);
    for (ItemBounds& item : items) {
        glm::vec3 low;
        glm::vec3 size;
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = rng.range(0.0f, 1000.0f);
            size[axis] = rng.range(0.0f, 4.0f);
        }
        item = {{low, low + size}, rng.below(1000)};
    }
    return items;
}

/// True if both have the same nodes, items and bounds, whatever their structure versions are.
inline bool same_tree(const Hierarchy& a, const Hierarchy& b)
{
    const auto same_node = [](const Node& x, const Node& y) {
        return x.box == y.box && x.parent == y.parent && x.first_child == y.first_child &&
               x.child_count == y.child_count && x.first_item == y.first_item &&
               x.own_items == y.own_items && x.subtree_items == y.subtree_items &&
               x.subtree_triangles == y.subtree_triangles && x.leaf == y.leaf;
    };
    const auto same_bounds = [](const ItemBounds& x, const ItemBounds& y) {
        return x.box == y.box && x.triangles == y.triangles;
    };
    return std::ranges::equal(a.nodes(), b.nodes(), same_node) &&
           std::ranges::equal(a.items(), b.items()) &&
           std::ranges::equal(a.item_bounds(), b.item_bounds(), same_bounds);
}

} // namespace occlude::test
