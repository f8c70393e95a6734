// A forest: leaky occluders.
#pragma once

#include "model/scene_model.h"
#include "model/scene_options.h"

#include <cstdint>

namespace occlude::tools {

struct ForestOptions {
    uint64_t triangles = 1700000; ///< drawn; the forest comes within a few percent
    uint64_t trees = 10000;
    uint64_t seed = 1;
};

/// Trees on rolling ground, in no order but close. Each is an object, an instance of one of twelve:
/// broad-leaved ones with a crown of lumps, and spruces of hanging cones. These hide; around them
/// are single leaves and twigs of two triangles each, as many as the budget leaves, and one sees
/// through between them. Path: "walk", at eye height on a winding way that is left free. The same
/// for the same options everywhere.
SceneModel generate_forest(const ForestOptions& options, const SceneOptions& scene_options = {});

} // namespace occlude::tools
