// Random boxes: a small scene that stresses a culler without any structure to help it.
#pragma once

#include "model/scene_model.h"
#include "model/scene_options.h"

#include <cstdint>

namespace occlude::tools {

struct BoxesOptions {
    uint32_t count = 1000;
    uint64_t seed = 1;
};

/// `count` boxes of a quarter metre to eight metres at random places in a cube of 100 m around
/// the origin; some long, some flat. The same for the same options everywhere.
SceneModel generate_boxes(const BoxesOptions& options, const SceneOptions& scene_options = {});

} // namespace occlude::tools
