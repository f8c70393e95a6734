#include "files/output_file.h"
#include "walk/path_json.h"
#include "walk/paths.h"

#include <fmt/core.h>

#include <glm/geometric.hpp>

namespace occlude::tools {
namespace {

constexpr const char* kExample = "{\"eye\": [0,0,0], \"target\": [0,0,-1]}";

Camera read_camera(PathEntry& entry, const glm::dvec3& origin)
{
    constexpr float kFarthest = 1e15f;
    Camera camera;
    entry.require("eye");
    entry.require("target");
    glm::dvec3 eye{0.0};
    glm::dvec3 target{0.0, 0.0, -1.0};
    entry.read("eye", eye);
    entry.read("target", target);
    camera.eye = glm::vec3{eye - origin};
    camera.target = glm::vec3{target - origin};
    entry.read("up", camera.up);
    entry.read("fov_y", camera.fov_y, 0.1f, 179.0f);
    entry.read("near", camera.near, 0.0f, kFarthest);
    entry.read("far", camera.far, 0.0f, kFarthest);
    if (eye == target) {
        entry.fail(entry.place() + ": eye and target are the same point");
    }
    if (camera.up == glm::vec3{0.0f}) {
        entry.fail(entry.place() + ".up has no direction");
    }
    if (camera.far > 0.0f && camera.far <= camera.near) {
        entry.fail(entry.place() + ".far must be greater than near");
    }
    return camera;
}

Result<std::vector<Camera>> read_frames(const std::string& file, const Json& list,
                                        size_t frame_count, const glm::dvec3& origin)
{
    std::vector<Camera> frames;
    for (size_t i = 0; i < list.size() && i < frame_count; ++i) {
        PathEntry entry(list.at(i), fmt::format("frames[{}]", i), kExample);
        entry.allow_only({"eye", "target", "up", "fov_y", "near", "far"});
        frames.push_back(read_camera(entry, origin));
        if (!entry.problem().empty()) {
            return bad_path(file, entry.problem());
        }
    }
    return frames;
}

Result<std::vector<Camera>> read_keyframes(const std::string& file, const Json& list,
                                           size_t frame_count, const glm::dvec3& origin)
{
    std::vector<Keyframe> keys;
    for (size_t i = 0; i < list.size(); ++i) {
        PathEntry entry(list.at(i), fmt::format("keyframes[{}]", i), kExample);
        Keyframe key;
        entry.allow_only({"eye", "target", "up", "fov_y", "near", "far", "time", "cut"});
        key.camera = read_camera(entry, origin);
        entry.require("time");
        entry.read("time", key.time, -1e9f, 1e9f);
        entry.read("cut", key.cut);
        if (!keys.empty() && key.time <= keys.back().time) {
            entry.fail(entry.place() + ".time must be later than the one before");
        }
        if (!entry.problem().empty()) {
            return bad_path(file, entry.problem());
        }
        keys.push_back(key);
    }
    return interpolate(keys, frame_count);
}

Json to_json(const glm::vec3& v)
{
    return Json::array({v.x, v.y, v.z});
}

} // namespace

Result<std::vector<Camera>> read_path_file(const std::string& file, size_t frame_count,
                                           const glm::dvec3& origin)
{
    const auto root = read_path_json(file);
    if (!root) {
        return root.error();
    }
    for (const char* form : {"frames", "keyframes"}) {
        const Json* const list = root->find(form);
        if (list == nullptr) {
            continue;
        }
        if (!list->is_array() || list->empty()) {
            return bad_path(file, fmt::format("\"{}\" must be a list with at least one entry: a "
                                              "path needs frames",
                                              form));
        }
        return std::string_view(form) == "frames"
                   ? read_frames(file, *list, frame_count, origin)
                   : read_keyframes(file, *list, frame_count, origin);
    }
    return bad_path(file, "has neither \"frames\" nor \"keyframes\"");
}

Result<size_t> write_path_file(const std::string& file, std::span<const Camera> cameras)
{
    Json frames = Json::array();
    for (const Camera& camera : cameras) {
        Json frame = Json::object({{"eye", to_json(camera.eye)},
                                   {"target", to_json(camera.target)},
                                   {"up", to_json(camera.up)},
                                   {"fov_y", camera.fov_y}});
        if (camera.near > 0.0f) {
            frame.set("near", camera.near);
        }
        if (camera.far > 0.0f) {
            frame.set("far", camera.far);
        }
        frames.push_back(std::move(frame));
    }
    auto out = OutputFile::open(file);
    if (!out) {
        return out.error();
    }
    const std::string text =
        Json::object({{"version", 1}, {"frames", std::move(frames)}}).dump(1) + '\n';
    if (const auto written = out->commit(text); !written) {
        return written.error();
    }
    return cameras.size();
}

} // namespace occlude::tools
