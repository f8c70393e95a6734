// An industrial plant: a dense core that hides much of itself through many leaks, and an open
// fringe.
#pragma once

#include "model/scene_model.h"
#include "model/scene_options.h"

#include <occlude/core/result.h>

#include <cstdint>

namespace occlude::tools {

struct PlantOptions {
    uint64_t triangles = 2000000; ///< drawn; the plant comes within a tenth
    uint64_t objects = 1185;
    uint64_t seed = 1;
};

/// Bays of 7 m on up to six floors: in each a frame, a floor of gratings, pipework laid out at
/// random (a mesh of its own), and a boiler, tube bundle, pipe rack, vessel, machine, rack of cable
/// trays or stairs, of which there are a few meshes each; sheet along two sides; on the open sides
/// a yard with pipe racks and tanks. `triangles` decides about the number of tubes, bars and pipes.
/// Path: "walk", on the ground, through the core and out into the yard. An error says how many
/// triangles would do. The same for the same options everywhere. Takes seconds for 13 million
/// triangles.
Result<SceneModel> generate_plant(const PlantOptions& options,
                                  const SceneOptions& scene_options = {});

} // namespace occlude::tools
