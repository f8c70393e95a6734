// What an industrial plant is made of. Each part takes the number of its repeated elements (tubes,
// bars, ribs) and so has as many triangles as one wants.
#pragma once

#include "model/mesh_tools.h"

#include <cstdint>
#include <string>

namespace occlude::tools {

inline constexpr float kPlantPitch = 7.0f; ///< metres between the middles of two bays
inline constexpr float kPlantFloor = 5.0f; ///< between two floors
inline constexpr float kPlantInner = 2.4f; ///< half the side of what stands in a bay

enum class PlantPart : uint8_t {
    boiler,   ///< four walls of tubes around a bundle: hides what is behind it
    bundle,   ///< tubes to and fro with bends, in a frame
    rack,     ///< pipes on a steel frame
    vessel,   ///< an upright tank with rings, a domed end and a ladder
    machine,  ///< a casing with ribs and bolts on a base
    trays,    ///< trays with cables, one above the other
    stairs,   ///< two flights with steps of bars and railings
    grating,  ///< the floor of a bay: bars one sees through
    frame,    ///< columns and beams of a bay, with a railing
    cladding, ///< a wall of corrugated sheet along one side of a bay
    pipework, ///< pipes under the floor above, each laid out at random
    tank,     ///< a large tank of the yard
    count,
};

/// The part around the middle of its bay, standing on y = 0. `elements` >= 1 is how often its
/// dominant element is there; the number of triangles grows with it. Only `pipework` and what is
/// laid out at random depend on the seed.
Mesh make_plant_part(PlantPart part, uint32_t elements, uint64_t seed);

/// Relative number of triangles that a part should get.
float plant_part_weight(PlantPart part);

/// The part's name in lists.
const char* plant_part_name(PlantPart part);

} // namespace occlude::tools
