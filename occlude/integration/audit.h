// Checks what an engine tells the library. For debugging an integration: slow, because it draws a
// frame or more.
//
// An item that leaves its box causes holes: it is hidden with its box, although a part of it is
// visible. audit_item_bounds() finds such items, and tells a wrong box from a wrong camera.
// stale_items() finds boxes that were changed without a refit.
#pragma once

#include <occlude/core/query_device.h>
#include <occlude/core/result.h>
#include <occlude/core/view.h>
#include <occlude/hierarchy/hierarchy.h>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace occlude {

/// An item that was drawn outside its box.
struct OutsideItem {
    ItemId item;
    size_t pixels = 0;      ///< pixels outside the box's rectangle, or nearer or farther than the
                            ///< box
    glm::ivec2 first_px{0}; ///< the first of them, from the lower left
    float depth = 0.0f;     ///< its window depth
    std::string text;       ///< a sentence
};

struct BoundsAudit {
    std::vector<OutsideItem> outside; ///< by ascending id
    size_t items_drawn = 0;           ///< number of items with a visible pixel
    /// The probable cause of most of it; empty if nothing is wrong. Names a transposed matrix or
    /// another depth range if most boxes fit then.
    std::string verdict;
};

/// Draws the items of `bounds` (indexed by ItemId), each alone in a frame, and compares the visible
/// depth with the item's box. Leaves out items with empty boxes. Fails if the device cannot read
/// depth. Takes a frame and a read-back per item: seconds for thousands of items.
Result<BoundsAudit> audit_item_bounds(QueryDevice& device, const View& view,
                                      std::span<const ItemBounds> bounds);

/// The items whose box, triangle count or flags in `hierarchy` differ from `bounds` (indexed by
/// ItemId): they were changed without a refit(). In tree order. O(items).
std::vector<ItemId> stale_items(const Hierarchy& hierarchy, std::span<const ItemBounds> bounds);

} // namespace occlude
