// Finds the bulk of a scene.
#pragma once

#include "model/scene_model.h"

#include <cstdint>
#include <vector>

namespace occlude::tools {

/// The part of a scene that built-in paths look at.
struct Focus {
    Aabb box;              ///< box of the instances below, in all frames
    uint64_t left_out = 0; ///< number of instances that are far away from these
};

/// All instances, unless some are so far away that a view of all would show nothing: a marker at
/// the origin of a country's grid, a second town. Along an axis, a gap is far in two cases: it cuts
/// off at most one instance of 20 and is longer than 8 times the size of the middle nine tenths, or
/// it is longer than 64 times the size of either side. Then the side with more triangles stays.
/// O(n), and O(n log n) if there are such gaps.
Focus find_focus(const SceneModel& model);

} // namespace occlude::tools
