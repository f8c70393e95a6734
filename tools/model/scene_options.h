// How a scene is cut into items when it is loaded or generated.
#pragma once

#include <cstdint>
#include <filesystem>

namespace occlude::tools {

struct SceneOptions {
    /// Meshes with more triangles are partitioned in space into items of at most this many.
    uint32_t item_triangles = 2048;
    /// Where they are parted: between whole triangles by their centroids, or by planes that cut
    /// triangles (scene/split.h).
    enum class Split { centroid, exact };
    Split split = Split::centroid;
    /// Keeps meshes that were cut; see exact_split.h. Empty: they are cut every time.
    std::filesystem::path cache_folder = {};
};

} // namespace occlude::tools
