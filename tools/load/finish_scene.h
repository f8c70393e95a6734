// From what a reader found to the scene that is drawn and culled.
#pragma once

#include "load/loaded_scene.h"
#include "model/scene_model.h"
#include "model/scene_options.h"

#include <occlude/core/result.h>

#include <string>

namespace occlude::tools {

/// Cleans the meshes and cuts them into items, moves a scene that lies far from its origin there,
/// and decides its unit and its axis: as `options` say, else as the file does, else by its shape.
/// The model's notes say what was assumed, its losses what was left out. `file` is for messages and
/// the scene's name. An error if no triangle is left.
Result<SceneModel> finish_scene(LoadedScene loaded, const std::string& file,
                                const SceneOptions& options);

} // namespace occlude::tools
