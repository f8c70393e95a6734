// Tighter bounds than one world box: a few boxes in an object's own space that together hold
// everything an item draws. Optional for each item. Cullers that test against depth use them if the
// world box of an item is not hidden (depth_traversal.h).
//
// Implements  D. Sekulic, "Efficient Occlusion Culling", GPU Gems, 2004, ch. 29, section 29.5.1:
//             several smaller boxes for an object that leaves most of its box empty.
#pragma once

#include <occlude/core/aabb.h>
#include <occlude/core/ids.h>

#include <glm/mat4x4.hpp>

#include <cstdint>
#include <memory>
#include <vector>

namespace occlude {

/// Boxes in the space of an object: every triangle of an item lies in their union. Empty: nothing
/// is known beyond the item's box. Items that look alike share one shape. Boxes are tested in their
/// order.
using Shape = std::vector<Aabb>;

/// The shapes of items, and their transforms. Scene keeps one; an engine without a Scene can keep
/// its own and give it to Hierarchy::set_shapes().
class ItemShapes {
public:
    struct Placed {
        std::shared_ptr<const Shape> shape; ///< not null, not empty
        glm::mat4 world_from_shape{1.0f};   ///< affine
    };

    /// The shape of an item, or null. Valid until something is placed or removed. O(1).
    const Placed* find(ItemId item) const
    {
        const uint32_t slot = item.value < slot_of_.size() ? slot_of_[item.value] : kNone;
        return slot != kNone ? &placed_[slot] : nullptr;
    }
    bool empty() const { return placed_.size() == free_.size(); }

    /// Gives an item a shape and replaces its former one; a null or empty shape removes it.
    void place(ItemId item, std::shared_ptr<const Shape> shape, const glm::mat4& world_from_shape);
    /// Sets the transform of the item's shape. Does nothing for an item without one. Allocates
    /// nothing.
    void move(ItemId item, const glm::mat4& world_from_shape);
    void remove(ItemId item);

private:
    static constexpr uint32_t kNone = 0xffffffffu;

    std::vector<uint32_t> slot_of_; ///< by ItemId; ends with the last item that has a shape
    std::vector<Placed> placed_;
    std::vector<uint32_t> free_;
};

} // namespace occlude
