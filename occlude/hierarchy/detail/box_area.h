// The surface area of a box, as builders weigh it. Internal.
#pragma once

#include <occlude/core/aabb.h>

namespace occlude::detail {

/// 0 for boxes that are empty or unbounded. In double: the areas of float boxes can overflow float.
inline double box_area(const Aabb& box)
{
    if (!box.is_bounded()) {
        return 0.0;
    }
    const double x = double{box.max.x} - box.min.x;
    const double y = double{box.max.y} - box.min.y;
    const double z = double{box.max.z} - box.min.z;
    return 2.0 * (x * y + y * z + z * x);
}

} // namespace occlude::detail
