// What the viewer remembers from one start to the next: a JSON file in the user's configuration.
#pragma once

#include "viewer/overlays.h"

#include <occlude/core/result.h>
#include <occlude/scene/camera_path.h>

#include <glm/vec2.hpp>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace occlude::tools::viewer {

struct Settings {
    glm::ivec2 window_size{1280, 720};
    float scale = 0.0f; ///< of panels; 0: that of the screen
    bool controls = true;
    bool inspector = true;
    bool timeline = false;
    std::array<std::string, 2> algorithms{"chc_plus_plus", "frustum"};
    std::array<OptionSets, 2> options;
    float speed = 1.0f; ///< of flying, in parts of what the scene suggests
    bool measure_references = true;
    std::map<std::string, std::vector<Camera>> bookmarks; ///< by scene
};

/// $XDG_CONFIG_HOME/occlude/viewer.json, or the same below ~/.config; empty where neither is known.
std::filesystem::path settings_file();

/// What the file holds; defaults for what it does not hold or what makes no sense.
Settings load_settings(const std::filesystem::path& file);

/// Makes the folder if it must. Errors name the file and the reason.
Result<bool> save_settings(const std::filesystem::path& file, const Settings& settings);

} // namespace occlude::tools::viewer
