// A heap of Utah teapots: many equal objects of many triangles, in no order at all.
#pragma once

#include "model/scene_model.h"
#include "model/scene_options.h"

#include <cstdint>

namespace occlude::tools {

struct TeapotsOptions {
    uint64_t count = 5000;
    uint64_t triangles = 2304; ///< of each; rounded to 64 n^2, less the 8 n of make_teapot()
    uint64_t seed = 1;
};

/// `count` teapots at random places and in random orientations in a cube whose side grows with the
/// cube root of their number; they may cut each other. The way of the path "flight" is left free:
/// around an edge of the heap, with the heap filling the view, and through its middle. The same for
/// the same options everywhere.
SceneModel generate_teapots(const TeapotsOptions& options, const SceneOptions& scene_options = {});

} // namespace occlude::tools
