// A generated city: streets between blocks of adjoining houses, with street furniture.
#pragma once

#include "model/scene_model.h"
#include "model/scene_options.h"

#include <occlude/core/result.h>

#include <cstdint>

namespace occlude::tools {

struct CityOptions {
    uint32_t blocks = 16; ///< per side: the city is a square of blocks x blocks
    uint64_t seed = 1;
    uint64_t triangles = 10000000; ///< drawn; the city comes within a few percent below
};

/// Blocks of 66 m, streets of 10 m. Streets along x run through; those along z are shifted from row
/// to row, so that every one of them ends at a facade. The houses around a block touch each other.
/// Some hundred meshes are instanced everywhere; the triangles asked for are spent on their detail
/// (see make_house). Paths: "street", "rise", "roofs", "teleport". Everything follows from the
/// options, without libm: the same on every machine. An error says how many triangles would do.
/// Takes a time proportional to the triangles of the distinct meshes: well under a second usually.
Result<SceneModel> generate_city(const CityOptions& options,
                                 const SceneOptions& scene_options = {});

} // namespace occlude::tools
