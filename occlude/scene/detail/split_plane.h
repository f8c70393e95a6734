// Chooses the plane that cuts a mesh in two. Internal; split.h says what it implements.
#pragma once

#include <occlude/core/aabb.h>

#include <cstdint>
#include <optional>
#include <span>

namespace occlude::detail {

struct SplitPlane {
    int axis = 0;
    float at = 0.0f;
};

struct SplitChoice {
    std::optional<SplitPlane> plane;
    bool cuts_too_many = false; ///< a plane was passed over because it cuts too many triangles
};

/// The plane with the least area * triangles, summed over both sides, that cuts at most `most_cuts`
/// triangles and leaves at most nine tenths of them on either side. Unbounded boxes stay below
/// every plane. O(triangles).
SplitChoice choose_split_plane(std::span<const Aabb> boxes, uint64_t most_cuts);

} // namespace occlude::detail
