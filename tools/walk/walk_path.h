// Finds a walk through the free space of any scene.
#pragma once

#include "model/scene_model.h"

#include <vector>

namespace occlude::tools {

/// Keys of a walk at human height over the floors of the scene; empty if it has no floors to speak
/// of. Deterministic.
std::vector<Keyframe> find_walk(const SceneModel& model);

} // namespace occlude::tools
