#include <occlude/hierarchy/item_shapes.h>

#include <occlude/core/assert.h>

#include <algorithm>
#include <utility>

namespace occlude {

void ItemShapes::place(ItemId item, std::shared_ptr<const Shape> shape,
                       const glm::mat4& world_from_shape)
{
    OCCLUDE_ASSERT(item.valid(), "the id of the item with the shape is invalid");
    remove(item);
    if (!item.valid() || shape == nullptr || shape->empty()) {
        return;
    }
    OCCLUDE_ASSERT(std::ranges::all_of(*shape, &Aabb::is_bounded),
                   "the boxes of a shape are bounded");
    if (item.value >= slot_of_.size()) {
        slot_of_.resize(size_t{item.value} + 1, kNone);
    }
    uint32_t slot = static_cast<uint32_t>(placed_.size());
    if (free_.empty()) {
        placed_.emplace_back();
    } else {
        slot = free_.back();
        free_.pop_back();
    }
    placed_[slot] = {std::move(shape), world_from_shape};
    slot_of_[item.value] = slot;
}

void ItemShapes::move(ItemId item, const glm::mat4& world_from_shape)
{
    if (item.value < slot_of_.size() && slot_of_[item.value] != kNone) {
        placed_[slot_of_[item.value]].world_from_shape = world_from_shape;
    }
}

void ItemShapes::remove(ItemId item)
{
    if (item.value < slot_of_.size() && slot_of_[item.value] != kNone) {
        const uint32_t slot = std::exchange(slot_of_[item.value], kNone);
        placed_[slot] = {};
        free_.push_back(slot);
    }
}

} // namespace occlude
