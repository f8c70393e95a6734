#include <occlude/scene/scene.h>

#include <occlude/core/assert.h>

#include <cmath>

namespace occlude {

const Scene::Object* Scene::find(ObjectId id) const
{
    if (!id.valid() || id.index >= objects_.size()) {
        return nullptr;
    }
    const Object& object = objects_[id.index];
    return object.generation == id.generation && object.item_count > 0 ? &object : nullptr;
}

void Scene::place(const Object& object)
{
    for (uint32_t i = object.first_item; i < object.first_item + object.item_count; ++i) {
        bounds_[i].box = transformed(object.world_from_object, local_boxes_[i]);
        shapes_.move(ItemId{i}, object.world_from_object);
    }
}

ObjectId Scene::add(const glm::mat4& world_from_object, std::span<const ItemDesc> items)
{
    OCCLUDE_ASSERT(!items.empty(), "an object has at least one item");
    const bool room = items.size() < ItemId::kInvalid - bounds_.size();
    OCCLUDE_ASSERT(room, "too many items for 32-bit ids");
    if (items.empty() || !room) {
        return {};
    }
    const auto count = static_cast<uint32_t>(items.size());
    uint32_t first = static_cast<uint32_t>(bounds_.size());
    if (count < free_items_.size() && !free_items_[count].empty()) {
        first = free_items_[count].back();
        free_items_[count].pop_back();
    } else {
        bounds_.resize(first + count);
        local_boxes_.resize(first + count);
        owner_.resize(first + count);
    }

    uint32_t slot = static_cast<uint32_t>(objects_.size());
    if (free_objects_.empty()) {
        objects_.emplace_back();
    } else {
        slot = free_objects_.back();
        free_objects_.pop_back();
    }
    Object& object = objects_[slot];
    object.world_from_object = world_from_object;
    object.first_item = first;
    object.item_count = count;
    ++object.generation;

    for (uint32_t i = 0; i < count; ++i) {
        bounds_[first + i].triangles = items[i].triangles;
        bounds_[first + i].flags = items[i].flags;
        local_boxes_[first + i] = items[i].local_box;
        shapes_.place(ItemId{first + i}, items[i].shape, world_from_object);
        owner_[first + i] = slot;
        triangles_ += items[i].triangles;
    }
    place(object);
    ++live_objects_;
    ++content_version_;
    return {slot, object.generation};
}

bool Scene::move(ObjectId id, const glm::mat4& world_from_object)
{
    if (find(id) == nullptr) {
        return false;
    }
    Object& object = objects_[id.index];
    object.world_from_object = world_from_object;
    place(object);
    ++motion_version_;
    return true;
}

void Scene::shift(const glm::dvec3& offset)
{
    const bool finite =
        std::isfinite(offset.x) && std::isfinite(offset.y) && std::isfinite(offset.z);
    OCCLUDE_ASSERT(finite, "Scene::shift needs a finite offset");
    if (!finite) {
        return;
    }
    for (Object& object : objects_) {
        if (object.item_count > 0) {
            glm::vec4& place_of = object.world_from_object[3];
            place_of = glm::vec4{glm::vec3{glm::dvec3{place_of} + offset}, place_of.w};
            place(object);
        }
    }
    ++motion_version_;
}

bool Scene::remove(ObjectId id)
{
    if (find(id) == nullptr) {
        return false;
    }
    Object& object = objects_[id.index];
    for (uint32_t i = object.first_item; i < object.first_item + object.item_count; ++i) {
        triangles_ -= bounds_[i].triangles;
        bounds_[i] = ItemBounds{};
        shapes_.remove(ItemId{i});
    }
    if (free_items_.size() <= object.item_count) {
        free_items_.resize(object.item_count + 1);
    }
    free_items_[object.item_count].push_back(object.first_item);
    free_objects_.push_back(id.index);
    object.item_count = 0;
    --live_objects_;
    ++content_version_;
    return true;
}

bool Scene::alive(ObjectId id) const
{
    return find(id) != nullptr;
}

ItemId Scene::first_item(ObjectId id) const
{
    const Object* object = find(id);
    return object != nullptr ? ItemId{object->first_item} : ItemId{};
}

uint32_t Scene::item_count(ObjectId id) const
{
    const Object* object = find(id);
    return object != nullptr ? object->item_count : 0;
}

const glm::mat4& Scene::world_from_object(ObjectId id) const
{
    static const glm::mat4 kIdentity{1.0f};
    const Object* object = find(id);
    OCCLUDE_ASSERT(object != nullptr, "stale object id");
    return object != nullptr ? object->world_from_object : kIdentity;
}

ObjectId Scene::object_of(ItemId item) const
{
    if (!item.valid() || item.value >= owner_.size()) {
        return {};
    }
    const uint32_t slot = owner_[item.value];
    const Object& object = objects_[slot];
    const bool owns = object.item_count > 0 && item.value >= object.first_item &&
                      item.value < object.first_item + object.item_count;
    return owns ? ObjectId{slot, object.generation} : ObjectId{};
}

} // namespace occlude
