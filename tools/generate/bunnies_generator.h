// A crowd of moving Stanford bunnies.
#pragma once

#include "model/scene_model.h"
#include "model/scene_options.h"

#include <occlude/core/result.h>

#include <cstdint>

namespace occlude::tools {

struct BunniesOptions {
    uint64_t count = 300;
    uint64_t triangles = 70000; ///< of each, at most; the scan has 69,451
    uint64_t seed = 1;
};

/// `count` bunnies, packed so densely that they cut each other, on straight ways that bounce off
/// the walls of the cube that holds them: generate_blobs() with the bunny itself. With fewer
/// triangles it is simplified (see simplify()). Paths: "orbit", "inside". An error if the bunny's
/// file cannot be found; see find_asset().
Result<SceneModel> generate_bunnies(const BunniesOptions& options,
                                    const SceneOptions& scene_options = {});

/// Joins the vertices in every cell of the finest even grid that leaves at most `most_triangles`,
/// at their mean, and makes new normals; parts are not kept. A mesh of as few stays as it is.
void simplify(Mesh& mesh, uint64_t most_triangles);

} // namespace occlude::tools
