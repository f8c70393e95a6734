// From what the user typed to a scene: a file that Assimp reads, or a generator's name and
// parameters.
#pragma once

#include "scenes/scene_model.h"

#include <occlude/core/result.h>

#include <glm/vec2.hpp>

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace occlude::tools {

/// A generator, for `occlude list scenes`.
struct GeneratorInfo {
    std::string name;       ///< "city"
    std::string parameters; ///< "blocks=16,seed=1,..."
    std::string description;
};
std::span<const GeneratorInfo> generators();

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

/// Loads or generates. Errors name the file or the parameter, and what would work.
Result<SceneModel> load_scene(const std::string& source, const SceneOptions& options = {});

/// A path for any scene, by name: "auto" (what was made for the scene, a walk where there are
/// floors, an orbit where the scene is an object), "orbit", "walk", "overview", a name in
/// model.paths, or a JSON file.
Result<std::vector<Camera>> load_path(const std::string& name, const SceneModel& model,
                                      size_t frame_count);

struct PathInfo {
    std::string name;
    std::string description;
};
/// The names load_path knows for this scene.
std::vector<PathInfo> path_names(const SceneModel& model);

/// Near and far for cameras that leave them open: far encloses the scene, near is as large as the
/// scene's unit allows.
void choose_depth_range(std::span<Camera> cameras, const SceneModel& model);

} // namespace occlude::tools
