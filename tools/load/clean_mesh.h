// From the triangles of a file to a mesh that can be drawn.
#pragma once

#include "load/loaded_scene.h"
#include "model/scene_model.h"

namespace occlude::tools {

/// What happens to a triangle over the same three points as an earlier one of its mesh, with the
/// same side out. Of an opaque mesh one never sees it, so it may be dropped.
enum class Repeats { drop, keep };

/// Leaves out triangles that cannot be drawn, and counts them in `source.left_out`; counts those
/// that repeat another one in `source.repeated` (dropped or not) and `source.backs` (kept); drops
/// vertices that none of the others uses; makes normals where there are none. The mesh has no
/// triangles if nothing is left, and no parts. O(triangles). The source's arrays are used up.
Mesh clean_mesh(LoadedMesh& source, Repeats repeats);

/// Coordinates beyond this are taken for damage: their squares would not fit a float.
inline constexpr float kLargestCoordinate = 1e15f;

} // namespace occlude::tools
