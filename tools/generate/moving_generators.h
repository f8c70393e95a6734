// Scenes in which every object moves.
#pragma once

#include "model/scene_model.h"
#include "model/scene_options.h"

#include <cstdint>

namespace occlude::tools {

struct MoversOptions {
    uint32_t count = 2000;
    uint64_t seed = 1;
    uint64_t triangles = 500000; ///< of all objects together, about
};

/// `count` boxes, slabs and lumps that fly straight and tumble in a cube of 70 m; one in four
/// appears and vanishes again and again. The same for the same options everywhere.
SceneModel generate_movers(const MoversOptions& options, const SceneOptions& scene_options = {});

struct BlobsOptions {
    uint32_t count = 300;
    uint64_t seed = 1;
    uint64_t triangles = 70000; ///< of each, about
};

/// `count` blobs of 1 m, packed so densely that they interpenetrate, on straight ways that bounce
/// off the walls of the cube that holds them: the crowd of bunnies on which dynamic scenes are
/// traditionally measured, with a generated mesh of as many triangles in the place of the bunny.
SceneModel generate_blobs(const BlobsOptions& options, const SceneOptions& scene_options = {});

/// Adds `count` instances of the model's only mesh, which lies within 1 m of the origin, called
/// `name` and a number, on straight ways through the cube that holds them; and the paths "orbit",
/// "inside" and "pass".
void fill_crowd(SceneModel& model, uint64_t count, uint64_t seed, const std::string& name);

/// A closed mesh of about `triangles` triangles (at least 12) within 1 m of the origin: a sphere
/// with random bumps and two long ears.
Mesh make_blob(uint64_t seed, uint64_t triangles, uint32_t item_triangles);

} // namespace occlude::tools
