// From what the user typed to a scene: the name of a file, or of a generator with its parameters.
#pragma once

#include "model/scene_model.h"
#include "model/scene_options.h"

#include <occlude/core/result.h>

#include <span>
#include <string>

namespace occlude::tools {

/// A generator, for `occlude list scenes`.
struct GeneratorInfo {
    std::string name;       ///< "city"
    std::string parameters; ///< "blocks=16,seed=1,..."
    std::string description;
};
std::span<const GeneratorInfo> generators();

/// Loads or generates. Errors name the file or the parameter, and what would work.
Result<SceneModel> load_scene(const std::string& source, const SceneOptions& options = {});

} // namespace occlude::tools
