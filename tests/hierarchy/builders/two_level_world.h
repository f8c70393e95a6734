// A two-level tree over objects of cubes that appear, disappear and move.
#pragma once

#include <occlude/hierarchy/builders/two_level.h>

#include <glm/ext/matrix_transform.hpp>

#include <map>
#include <vector>

namespace occlude::test {

/// Objects of cubes around their origins: simple ones of one cube, complex ones of a row of four.
struct World {
    explicit World(const TwoLevelOptions& options = {})
        : tree(options)
    {
    }

    TwoLevelTree::Slot add(const glm::vec3& at, uint32_t parts = 1, uint32_t triangles = 12)
    {
        std::vector<Aabb> local;
        for (uint32_t i = 0; i < parts; ++i) {
            const glm::vec3 low{static_cast<float>(i), 0.0f, 0.0f};
            local.push_back({low, low + 1.0f});
        }
        const auto first = static_cast<uint32_t>(bounds.size());
        const glm::mat4 place = glm::translate(glm::mat4{1.0f}, at);
        const TwoLevelTree::Slot slot = tree.add(
            {.first_item = ItemId{first}, .world_from_object = place, .local_boxes = local});
        objects[slot] = {first, local};
        bounds.resize(first + parts, {Aabb{}, triangles});
        put(slot, place);
        return slot;
    }
    void put(TwoLevelTree::Slot slot, const glm::mat4& place)
    {
        const auto& [first, local] = objects[slot];
        places[slot] = place;
        for (size_t i = 0; i < local.size(); ++i) {
            bounds[first + i].box = transformed(place, local[i]);
        }
    }
    void move(TwoLevelTree::Slot slot, const glm::mat4& place)
    {
        put(slot, place);
        tree.move(slot, place);
    }
    void remove(TwoLevelTree::Slot slot)
    {
        const auto& [first, local] = objects[slot];
        for (size_t i = 0; i < local.size(); ++i) {
            bounds[first + i].box = Aabb{};
        }
        objects.erase(slot);
        tree.remove(slot);
    }
    void update() { tree.update(bounds); }
    /// The node whose own items include `item`.
    NodeId node_of(uint32_t item) const
    {
        for (size_t i = 0; i < tree.hierarchy().nodes().size(); ++i) {
            for (const ItemId own : tree.hierarchy().own_items(NodeId{i})) {
                if (own.value == item) {
                    return NodeId{i};
                }
            }
        }
        return {};
    }

    TwoLevelTree tree;
    std::vector<ItemBounds> bounds;
    std::map<TwoLevelTree::Slot, std::pair<uint32_t, std::vector<Aabb>>> objects;
    std::map<TwoLevelTree::Slot, glm::mat4> places;
};

inline glm::mat4 at(float x, float y, float z)
{
    return glm::translate(glm::mat4{1.0f}, glm::vec3{x, y, z});
}

} // namespace occlude::test
