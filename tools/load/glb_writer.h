// Scenes as binary glTF files.
#pragma once

#include "model/scene_model.h"

#include <occlude/core/result.h>

#include <string>

namespace occlude::tools {

/// The scene as the bytes of a .glb file: every mesh once, one node per instance, with its name and
/// its exact matrix. A mesh gets one material in the mean colour of its instances, because glTF
/// keeps colours with meshes and instancing matters more. Where the scene is not in metres, has
/// another axis up or lies elsewhere, a node above all others makes it so. Paths, motion and parts
/// are not written. An error if the file would be larger than glTF allows (4 GiB).
Result<std::string> to_glb(const SceneModel& model);

} // namespace occlude::tools
