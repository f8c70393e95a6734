#include "viewer/settings.h"

#include "files/output_file.h"

#include <occlude/cull/registry.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdlib>
#include <fstream>

namespace occlude::tools::viewer {

namespace {

using nlohmann::json;
namespace fs = std::filesystem;

json to_json(const glm::vec3& v)
{
    return json::array({v.x, v.y, v.z});
}

glm::vec3 to_vector(const json& value)
{
    return {value.at(0).get<float>(), value.at(1).get<float>(), value.at(2).get<float>()};
}

json to_json(const Camera& camera)
{
    return {{"eye", to_json(camera.eye)},
            {"target", to_json(camera.target)},
            {"up", to_json(camera.up)},
            {"fov_y", camera.fov_y}};
}

Camera to_camera(const json& value)
{
    return {.eye = to_vector(value.at("eye")),
            .target = to_vector(value.at("target")),
            .up = to_vector(value.at("up")),
            .fov_y = value.at("fov_y").get<float>()};
}

// Reads one member; what is missing or of another kind leaves the default.
template <class Read>
void try_member(const json& object, const char* key, Read&& read)
{
    if (const auto member = object.find(key); member != object.end()) {
        try {
            read(*member);
        } catch (const json::exception&) { // somebody edited the file: the default stays
        }
    }
}

template <class T>
void take(const json& object, const char* key, T& out)
{
    try_member(object, key, [&](const json& value) { out = value.get<T>(); });
}

void clean_up(Settings& settings)
{
    constexpr int kLeastSide = 320;
    constexpr int kMostSide = 16384;
    settings.window_size = glm::clamp(settings.window_size, kLeastSide, kMostSide);
    settings.scale = settings.scale > 0.0f ? std::clamp(settings.scale, 0.5f, 4.0f) : 0.0f;
    settings.speed = std::clamp(settings.speed, 0.01f, 100.0f);
    const Settings defaults;
    for (size_t i = 0; i < settings.algorithms.size(); ++i) {
        if (find_algorithm(settings.algorithms[i]) == nullptr) {
            settings.algorithms[i] = defaults.algorithms[i];
        }
    }
}

} // namespace

fs::path settings_file()
{
    const auto folder = [](const char* variable) {
        const char* value = std::getenv(variable);
        return value != nullptr ? fs::path{value} : fs::path{};
    };
    fs::path config = folder("XDG_CONFIG_HOME");
    if (config.empty()) {
        config = folder("HOME");
        if (config.empty()) {
            return {};
        }
        config /= ".config";
    }
    return config / "occlude" / "viewer.json";
}

Settings load_settings(const fs::path& file)
{
    Settings settings;
    std::ifstream stream{file};
    const json object = json::parse(stream, nullptr, false);
    if (!object.is_object()) {
        return settings;
    }
    try_member(object, "window_size", [&](const json& size) {
        settings.window_size = {size.at(0).get<int>(), size.at(1).get<int>()};
    });
    take(object, "scale", settings.scale);
    take(object, "controls", settings.controls);
    take(object, "inspector", settings.inspector);
    take(object, "timeline", settings.timeline);
    take(object, "algorithms", settings.algorithms);
    take(object, "options", settings.options);
    take(object, "speed", settings.speed);
    take(object, "measure_references", settings.measure_references);
    try_member(object, "bookmarks", [&](const json& scenes) {
        for (const auto& [scene, cameras] : scenes.items()) {
            for (const json& camera : cameras) {
                settings.bookmarks[scene].push_back(to_camera(camera));
            }
        }
    });
    clean_up(settings);
    return settings;
}

Result<bool> save_settings(const fs::path& file, const Settings& settings)
{
    json object{{"version", 1},
                {"window_size", {settings.window_size.x, settings.window_size.y}},
                {"scale", settings.scale},
                {"controls", settings.controls},
                {"inspector", settings.inspector},
                {"timeline", settings.timeline},
                {"algorithms", settings.algorithms},
                {"options", settings.options},
                {"speed", settings.speed},
                {"measure_references", settings.measure_references}};
    for (const auto& [scene, cameras] : settings.bookmarks) {
        for (const Camera& camera : cameras) {
            object["bookmarks"][scene].push_back(to_json(camera));
        }
    }
    std::error_code ignored; // opening the file says what is wrong
    fs::create_directories(file.parent_path(), ignored);
    auto output = OutputFile::open(file);
    if (!output) {
        return output.error();
    }
    constexpr int kIndent = 2;
    return output->commit(object.dump(kIndent) + "\n");
}

} // namespace occlude::tools::viewer
