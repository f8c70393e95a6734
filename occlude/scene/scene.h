// The objects of a scene as culling needs them: transforms, boxes and flags, but no meshes.
//
// An *item* is one draw. An *object* has a transform and one or more items: a simple object has
// one, a complex one is partitioned in space into several. Objects can be added, moved and removed
// at any time; the slot of a removed object is reused under a new generation.
#pragma once

#include <occlude/core/aabb.h>
#include <occlude/core/ids.h>
#include <occlude/hierarchy/hierarchy.h>
#include <occlude/hierarchy/item_shapes.h>

#include <glm/mat4x4.hpp>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace occlude {

struct ItemDesc {
    Aabb local_box; ///< in the space of the object
    uint32_t triangles = 0;
    ItemFlags flags = ItemFlags::none;
    /// Tighter bounds, also in the space of the object; null: only the box. Objects that look alike
    /// share one.
    std::shared_ptr<const Shape> shape = {};
};

class Scene {
public:
    /// Adds an object of items.size() >= 1 items. Item ids are taken from removed objects first,
    /// and are contiguous: first_item(id) and the following ones. O(items).
    ObjectId add(const glm::mat4& world_from_object, std::span<const ItemDesc> items);

    /// Moves an object. Returns false and does nothing for a stale or foreign id. O(its items).
    bool move(ObjectId object, const glm::mat4& world_from_object);

    /// Moves all objects by `offset`, for worlds whose zero follows the camera. Positions are added
    /// in double and rounded to float once. O(items).
    void shift(const glm::dvec3& offset);

    /// Removes an object; its id is stale from now on. False for a stale or foreign id.
    bool remove(ObjectId object);

    bool alive(ObjectId object) const;
    size_t object_count() const { return live_objects_; }

    ItemId first_item(ObjectId object) const;
    uint32_t item_count(ObjectId object) const;
    const glm::mat4& world_from_object(ObjectId object) const;
    /// The object that owns `item`, or an invalid id if the slot is free.
    ObjectId object_of(ItemId item) const;

    /// The box of `item` in the space of its object; meaningless for a free slot. Precondition:
    /// item_bounds() has that slot.
    const Aabb& local_box(ItemId item) const { return local_boxes_[item.value]; }

    /// World bounds and flags of every item slot, indexed by ItemId. Free slots have empty boxes, 0
    /// triangles and no flags.
    std::span<const ItemBounds> item_bounds() const { return bounds_; }
    ItemFlags item_flags(ItemId item) const { return bounds_[item.value].flags; }

    /// The shapes of items that have one, for Hierarchy::set_shapes(&scene.shapes()). They follow
    /// every add, move and remove, and keep their address as long as the scene lives.
    const ItemShapes& shapes() const { return shapes_; }

    /// Triangles of all living items.
    uint64_t triangle_count() const { return triangles_; }

    /// Changes with every add and remove (a hierarchy must be rebuilt or patched) ...
    uint64_t content_version() const { return content_version_; }
    /// ... and with every move (a hierarchy must be refitted).
    uint64_t motion_version() const { return motion_version_; }

private:
    struct Object {
        glm::mat4 world_from_object{1.0f};
        uint32_t generation = 0;
        uint32_t first_item = 0;
        uint32_t item_count = 0; ///< 0: the slot is free
    };
    const Object* find(ObjectId object) const;
    void place(const Object& object);

    std::vector<Object> objects_;
    std::vector<uint32_t> free_objects_;
    std::vector<ItemBounds> bounds_;
    std::vector<Aabb> local_boxes_;
    ItemShapes shapes_;
    std::vector<uint32_t> owner_;
    std::vector<std::vector<uint32_t>> free_items_; ///< first slots of free runs, by run length
    size_t live_objects_ = 0;
    uint64_t triangles_ = 0;
    uint64_t content_version_ = 0;
    uint64_t motion_version_ = 0;
};

} // namespace occlude
