// A city of separate boxes: very many objects of very few triangles.
#pragma once

#include "model/scene_model.h"
#include "model/scene_options.h"

#include <cstdint>

namespace occlude::tools {

struct BoxCityOptions {
    uint64_t count = 40000;  ///< objects, the ground among them
    uint64_t triangles = 12; ///< of each, about: 12 times what a subdivided face allows
    uint64_t seed = 1;
};

/// Blocks of 60 m between straight streets of 12 m. About a hundred boxes make a block: houses that
/// stand wall to wall around it, houses in the yard, and smaller boxes on the roofs, in the yard,
/// and on the pavement. All of them, and the ground, are instances of one unit box. Paths: "street"
/// (at eye height, turning at crossings), "roofs" (rising above them). The same for the same
/// options everywhere.
SceneModel generate_boxcity(const BoxCityOptions& options, const SceneOptions& scene_options = {});

/// A box of side 1 on y = 0, centred in x and z, each face an even grid. Of all grids of a, b and c
/// cells along the edges, with the longest at most twice the shortest, it has the one whose
/// 4 (ab + bc + ca) triangles are nearest to `triangles`; 12 and 252 are met exactly.
Mesh make_subdivided_box(uint64_t triangles, uint32_t item_triangles);

} // namespace occlude::tools
