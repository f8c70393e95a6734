// A position in Hierarchy::items(), the order of draws: not an ItemId.
#pragma once

#include <occlude/core/assert.h>
#include <occlude/core/ids.h>
#include <occlude/hierarchy/hierarchy.h>

namespace occlude {

/// Valid until the hierarchy's structure changes.
using ItemPosition = Id<struct ItemPositionTag>;

inline ItemId item_at(const Hierarchy& hierarchy, ItemPosition at)
{
    OCCLUDE_ASSERT(at.value < hierarchy.items().size(), "a position of another tree");
    return hierarchy.items()[at.value];
}

inline const ItemBounds& bounds_at(const Hierarchy& hierarchy, ItemPosition at)
{
    OCCLUDE_ASSERT(at.value < hierarchy.items().size(), "a position of another tree");
    return hierarchy.item_bounds()[at.value];
}

} // namespace occlude
