// Scenes from files: the right reader for each, in a process of its own where it may not survive.
#pragma once

#include "model/scene_model.h"
#include "model/scene_options.h"

#include <occlude/core/result.h>

namespace occlude::tools {

/// The scene in `file`: glTF 2.0 by a reader of the project's own, every other format through
/// Assimp in a child process. A mesh that several nodes share stays one mesh with several
/// instances. Textures, lights and animations are not read. What was assumed and what was left out
/// is in the model's notes and losses. Errors name the file, what is wrong with it and a remedy.
Result<SceneModel> load_scene_file(const std::string& file, const SceneOptions& options = {});

} // namespace occlude::tools
