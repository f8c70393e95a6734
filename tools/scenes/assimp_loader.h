// Scenes from files, through Assimp.
#pragma once

#include "scenes/scene_source.h"

namespace occlude::tools {

/// The scene in `file`, of any format that Assimp reads. A mesh that several nodes share stays one
/// mesh with several instances. Points and lines, triangles without area and triangles with a
/// corner that is not a finite number are left out; missing normals are made. Textures, lights,
/// cameras and animations are not read. Errors name the file and what is wrong with it.
///
/// `unit`: glTF, Collada and FBX say what a unit is (Assimp turns Collada into metres), and they
/// are believed unless the size is absurd; see guess_unit().
Result<SceneModel> load_with_assimp(const std::string& file, const SceneOptions& options = {});

/// Units per metre of a scene that does not say, or is not to be believed, from the length of the
/// edges of its triangles: the drawn triangles of houses, rooms and streets made in metres have a
/// median edge of centimetres to some ten metres.
float guess_unit(const SceneModel& model);

} // namespace occlude::tools
