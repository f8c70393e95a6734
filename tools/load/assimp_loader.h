// Scenes from files, through Assimp.
#pragma once

#include "model/scene_model.h"
#include "model/scene_options.h"

#include <occlude/core/result.h>

namespace occlude::tools {

/// The scene in `file`, of any format that Assimp reads. A mesh that several nodes share stays one
/// mesh with several instances. Points and lines, triangles without area and triangles with a
/// corner that is not a finite number are left out; missing normals are made. Textures, lights,
/// cameras and animations are not read. Errors name the file and what is wrong with it. A file that
/// crashes Assimp all the same ends the program: see CrashGuard.
///
/// `unit`: glTF, Collada and FBX say what a unit is (Assimp turns Collada into metres), and they
/// are believed unless the size is absurd; see guess_unit().
Result<SceneModel> load_with_assimp(const std::string& file, const SceneOptions& options = {});

/// What is known of a file's unit of length.
enum class UnitSource { metres, unknown };

/// Units per metre. A file that says metres is believed (1), unless the scene were longer than
/// 20 km or nine of ten triangles larger than 20 m; one that says nothing is taken for metres too,
/// unless it is longer than 1 km with triangles of 8 m and more. Then the power of two is returned
/// that brings the triangles' median edge nearest to 2 m: 32 for levels made like Quake's.
float guess_unit(const SceneModel& model, UnitSource source);

} // namespace occlude::tools
