// An old town: narrow, winding streets between blocks with courtyards.
#pragma once

#include "model/scene_model.h"
#include "model/scene_options.h"

#include <occlude/core/result.h>

#include <cstdint>

namespace occlude::tools {

struct ViennaOptions {
    uint64_t blocks = 16;         ///< per side
    uint64_t triangles = 8000000; ///< drawn; the town comes within a tenth
    uint64_t seed = 1;
};

/// Blocks between crossings that were moved off an even grid, so that no street is straight for
/// more than a block; streets of 9 m. Houses with steep roofs, wall to wall around every block,
/// wings into the courtyards, rows of dormers on the roofs, trees in the yards, lamps at the
/// houses: some sixty meshes, instanced. Paths: "street" (at eye height), "rise" (up between the
/// houses until one sees over the roofs), "roofs" (over them). An error says how many triangles
/// would do. The same for the same options everywhere.
Result<SceneModel> generate_vienna(const ViennaOptions& options,
                                   const SceneOptions& scene_options = {});

} // namespace occlude::tools
