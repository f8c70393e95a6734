// Scenes of the formats that Assimp reads.
#pragma once

#include "load/loaded_scene.h"

#include <occlude/core/result.h>

#include <filesystem>
#include <functional>

namespace occlude::tools {

/// The scene in `file`, as Assimp reads it without any of its own post-processing. A mesh that
/// several nodes share stays one mesh with several instances. Polygons are cut into triangles;
/// points and lines are counted. Coordinates of OBJ files that lie far from the origin are read in
/// double precision. Errors name the file. Assimp crashes, hangs and eats memory over some broken
/// files: call it through read_in_child(). `progress` may be empty; few of Assimp's readers say how
/// far they are.
Result<LoadedScene> read_with_assimp(const std::filesystem::path& file,
                                     const std::function<void(double share)>& progress);

} // namespace occlude::tools
