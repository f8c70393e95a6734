// How a scene is read, and cut into items, when it is loaded or generated.
#pragma once

#include <glm/vec3.hpp>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>

namespace occlude::tools {

struct SceneOptions {
    /// Meshes with more triangles are partitioned in space into items of at most this many.
    uint32_t item_triangles = 1024; // docs/scale.md says why
    /// How larger meshes are divided: between whole triangles by their centroids, or by planes that
    /// cut triangles (scene/split.h).
    enum class Split { centroid, exact };
    Split split = Split::centroid;
    /// The folder for meshes that were cut (exact_split.h) and files that took long to read
    /// (load/scene_cache.h). Empty: nothing is kept.
    std::filesystem::path cache_folder = {};

    // The meaning of a file's coordinates; empty: as the file or its format says, or else guessed.
    std::optional<glm::dvec3> origin = {}; ///< the point of the file that becomes (0, 0, 0)
    std::optional<float> units_per_metre = {};
    std::optional<glm::vec3> up = {}; ///< of length 1

    // Limits of reading a file.
    uint32_t load_seconds = 120;  ///< in readers that may hang
    uint64_t load_memory_mib = 0; ///< 0: half of the machine's memory
    /// Called at intervals while a file is read, with the share that is done.
    std::function<void(double)> progress = {};
};

} // namespace occlude::tools
