// Is what an engine tells the library true? For debugging an integration: slow, drawing a frame or
// more.
//
// An item that leaves its box makes holes: it is hidden with its box, though a part of it would be
// seen. audit_item_bounds() finds such items, and tells a wrong box from a wrong camera;
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

/// An item that was drawn where its box is not.
struct OutsideItem {
    ItemId item;
    size_t pixels = 0;      ///< drawn outside of the box's rectangle, or nearer or farther than it
    glm::ivec2 first_px{0}; ///< the first of them, from the lower left
    float depth = 0.0f;     ///< its window depth
    std::string text;       ///< a sentence
};

struct BoundsAudit {
    std::vector<OutsideItem> outside; ///< by ascending id
    size_t items_drawn = 0;           ///< items of which a pixel was seen
    /// What explains most of it; empty if nothing is wrong. Names a transposed matrix or another
    /// depth range if most boxes fit then.
    std::string verdict;
};

/// Draws the items of `bounds` (indexed by ItemId) one by one, each in a frame of its own, and
/// holds the depth of what is seen against the item's box. Items with empty boxes are left out.
/// Fails if the device cannot read depth. A frame and a read-back per item: seconds for thousands.
Result<BoundsAudit> audit_item_bounds(QueryDevice& device, const View& view,
                                      std::span<const ItemBounds> bounds);

/// The items whose box, triangle count or flags in `hierarchy` are not those in `bounds` (indexed
/// by ItemId): they were changed, and refit() was forgotten. In tree order. O(items).
std::vector<ItemId> stale_items(const Hierarchy& hierarchy, std::span<const ItemBounds> bounds);

} // namespace occlude
