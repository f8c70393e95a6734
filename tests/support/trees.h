// Small hierarchies and cameras that tests can reason about by hand.
#pragma once

#include <occlude/core/rng.h>
#include <occlude/core/view.h>
#include <occlude/hierarchy/builders/bvh_builder.h>
#include <occlude/hierarchy/hierarchy.h>

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>

#include <cstdint>
#include <vector>

namespace occlude::test {

/// A camera at `eye` that looks at `target`, 90 degrees wide and high, near 0.1, far 1000.
inline View look(const glm::vec3& eye, const glm::vec3& target, glm::ivec2 size = {64, 64})
{
    const glm::mat4 clip_from_eye = glm::perspectiveRH_NO(
        glm::radians(90.0f), static_cast<float>(size.x) / static_cast<float>(size.y), 0.1f,
        1000.0f);
    return View::from_clip(clip_from_eye * glm::lookAtRH(eye, target, glm::vec3{0.0f, 1.0f, 0.0f}),
                           size);
}

/// From the origin along -z.
inline View look_ahead()
{
    return look({0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -1.0f});
}

/// A complete binary tree over 2^depth leaves of one item each, which stand one behind the other
/// along -z: leaf k is a box of size 2 around (0, 0, -10 - 10 k), item k, 100 triangles. Nodes are
/// numbered level by level, so that depth 2 gives
///
///            0
///        1       2
///      3   4   5   6        node 3 is nearest (item 0), node 6 farthest (item 3)
inline Hierarchy row_tree(uint32_t depth)
{
    const uint32_t leaves = 1u << depth;
    std::vector<Node> nodes(2 * leaves - 1);
    std::vector<ItemId> items;
    std::vector<ItemBounds> bounds;
    for (uint32_t k = 0; k < leaves; ++k) {
        const glm::vec3 center{0.0f, 0.0f, -10.0f - 10.0f * static_cast<float>(k)};
        items.push_back(ItemId{k});
        bounds.push_back({{center - 1.0f, center + 1.0f}, 100});
    }
    for (uint32_t level = 0; level <= depth; ++level) {
        const uint32_t width = leaves >> level;
        for (uint32_t i = 0; i < (1u << level); ++i) {
            const uint32_t index = (1u << level) - 1 + i;
            Node& node = nodes[index];
            node.parent = level == 0 ? NodeId{} : NodeId{(1u << (level - 1)) - 1 + i / 2};
            if (level < depth) {
                node.first_child = NodeId{(1u << (level + 1)) - 1 + 2 * i};
                node.child_count = 2;
            } else {
                node.own_items = 1;
                node.leaf = 1;
            }
            node.first_item = i * width;
            node.subtree_items = width;
            node.subtree_triangles = width * 100;
            for (uint32_t k = i * width; k < (i + 1) * width; ++k) {
                node.box = merge(node.box, bounds[k].box);
            }
        }
    }
    return Hierarchy::from_arrays(std::move(nodes), std::move(items), std::move(bounds));
}

/// `count` boxes of size up to `size` in a cube of half width `spread` around the origin.
inline std::vector<ItemBounds> random_boxes(uint32_t count, uint64_t seed, float spread = 50.0f,
                                            float size = 4.0f)
{
    Rng rng{seed};
    std::vector<ItemBounds> boxes;
    for (uint32_t i = 0; i < count; ++i) {
        const glm::vec3 low{rng.range(-spread, spread), rng.range(-spread, spread),
                            rng.range(-spread, spread)};
        const glm::vec3 extent{rng.range(0.1f, size), rng.range(0.1f, size), rng.range(0.1f, size)};
        boxes.push_back({{low, low + extent}, 1 + rng.below(200)});
    }
    return boxes;
}

/// A BVH with leaves of few items, so that small scenes have deep trees.
inline Hierarchy random_bvh(uint32_t count, uint64_t seed, uint32_t leaf_triangles = 300)
{
    return build_bvh(random_boxes(count, seed), {.leaf_triangles = leaf_triangles});
}

} // namespace occlude::test
