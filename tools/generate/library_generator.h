// A library: very many small objects that hide each other, seen through shelves without backs.
#pragma once

#include "model/scene_model.h"
#include "model/scene_options.h"

#include <cstdint>

namespace occlude::tools {

struct LibraryOptions {
    uint64_t books = 40000;
    uint64_t triangles = 254; ///< of each book, about
    uint64_t seed = 1;
};

/// A hall with rows of shelves on both sides of an aisle, and reading places at one end. Each book
/// is an object, an instance of one of eight books; so is each shelf, of six boards without a back,
/// so that one sees between the books into the next rows. Path: "walk", between the rows. The same
/// for the same options everywhere.
SceneModel generate_library(const LibraryOptions& options, const SceneOptions& scene_options = {});

} // namespace occlude::tools
