// The order of translucent items: far to near, and the same for every algorithm.
#pragma once

#include <occlude/core/ids.h>

#include <cstdint>

namespace occlude {

struct TranslucentItem {
    float distance_key = 0.0f; ///< View::distance_key of its box
    ItemId item;
    uint32_t triangles = 0;
};

/// True if `a` is blended before `b`: the nearest point of its box is farther, or equally far and
/// its id is smaller. A total order, so that leaving out hidden items changes no pixel.
inline bool blended_before(const TranslucentItem& a, const TranslucentItem& b)
{
    return a.distance_key != b.distance_key ? a.distance_key > b.distance_key : a.item < b.item;
}

} // namespace occlude
