// Objects that fill little of their boxes: where testing boxes finds too much visible.
#pragma once

#include "model/scene_model.h"
#include "model/scene_options.h"

#include <cstdint>

namespace occlude::tools {

struct HollowOptions {
    uint64_t count = 1000;
    uint64_t triangles = 256; ///< of each, about
    uint64_t seed = 1;
};

/// Pyramids in rows and columns on a plain. Whoever stands before a column sees its first pyramid
/// only, but the upper corners of the boxes behind stand out beside its slopes. Path: "pass", along
/// the first row at eye height, looking down the columns. Triangles are rounded to 4 n^2.
SceneModel generate_pyramids(const HollowOptions& options, const SceneOptions& scene_options = {});

/// Bundles of eight thin upright rings close behind each other, all facing the camera. The first
/// ring of a bundle hides most of the others, but every box is as wide as its ring and is seen
/// through it. Path: "pass", along the bundles. Triangles are rounded to 4 m^2 for m = 4, 8, 16.
SceneModel generate_rings(const HollowOptions& options, const SceneOptions& scene_options = {});

} // namespace occlude::tools
