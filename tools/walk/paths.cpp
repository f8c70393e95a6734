#include "walk/paths.h"

#include "model/focus.h"
#include "walk/path_tools.h"
#include "walk/walk_path.h"

#include <fmt/format.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string_view>

namespace occlude::tools {
namespace {

constexpr std::string_view kCameraPrefix = "camera:"; // of paths that are cameras of the file
constexpr float kEyeHeight = 1.7f;                    // metres
constexpr float kLongestStep = 0.5f;                  // metres between two frames of a walk
constexpr float kNear = 0.1f;                         // metres
constexpr float kLeastNearShare = 1e-5f;              // of far

/// Two directions that span the ground with `up`.
struct GroundAxes {
    glm::vec3 right;
    glm::vec3 forward;
};
GroundAxes ground_axes(const glm::vec3& up)
{
    const glm::vec3 helper =
        std::abs(up.x) < 0.7f ? glm::vec3{1.0f, 0.0f, 0.0f} : glm::vec3{0.0f, 0.0f, -1.0f};
    const glm::vec3 right = glm::normalize(helper - glm::dot(helper, up) * up);
    return {right, glm::cross(up, right)};
}

glm::vec3 around(const GroundAxes& axes, float degrees)
{
    const float angle = degrees * std::numbers::pi_v<float> / 180.0f;
    return std::cos(angle) * axes.right + std::sin(angle) * axes.forward;
}

/// How far from the middle of the box, in the direction `out`, all of it is in view, on a screen of
/// 4:3 or wider.
float standoff(const Aabb& bounds, const glm::vec3& out, const glm::vec3& up)
{
    constexpr float kUpward = 0.53f; // a little less than tan(30 degrees), half the field of view
    constexpr float kSideways = 4.0f / 3.0f * kUpward;
    const glm::vec3 half = 0.5f * bounds.extent();
    const glm::vec3 right = glm::normalize(glm::cross(up, out));
    const glm::vec3 top = glm::cross(out, right);
    float distance = 0.0f;
    for (int i = 0; i < 8; ++i) {
        const glm::vec3 corner =
            half * glm::vec3{i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 4 ? 1.0f : -1.0f};
        const float across = std::max(std::abs(glm::dot(corner, right)) / kSideways,
                                      std::abs(glm::dot(corner, top)) / kUpward);
        distance = std::max(distance, glm::dot(corner, out) + across);
    }
    return distance > 0.0f ? distance : 1.0f; // a single point
}

/// Looking at the middle of the scene from the direction `degrees` around it and `rise` above.
Camera looking_in(const SceneModel& model, const Aabb& bounds, float degrees, float rise)
{
    const glm::vec3 out = glm::normalize(around(ground_axes(model.up), degrees) + rise * model.up);
    Camera camera;
    camera.eye = bounds.center() + standoff(bounds, out, model.up) * out;
    camera.target = bounds.center();
    camera.up = model.up;
    return camera;
}

std::vector<Keyframe> orbit_keys(const SceneModel& model)
{
    constexpr int kSteps = 48;
    const Aabb bounds = find_focus(model).box;
    std::vector<Keyframe> keys;
    for (int i = 0; i <= kSteps; ++i) {
        const float degrees = 360.0f * static_cast<float>(i) / kSteps;
        keys.push_back({static_cast<float>(i), looking_in(model, bounds, degrees, 0.35f), false});
    }
    return keys;
}

std::vector<Keyframe> overview_keys(const SceneModel& model)
{
    return {{0.0f, looking_in(model, find_focus(model).box, -60.0f, 1.0f), false}};
}

/// What of a walk `frame_count` frames can show at a human pace.
std::vector<Keyframe> paced(std::vector<Keyframe> keys, float unit, size_t frame_count)
{
    const float reach = kLongestStep * unit * static_cast<float>(frame_count);
    float walked = 0.0f;
    for (size_t i = 1; i < keys.size(); ++i) {
        walked += glm::distance(keys[i - 1].camera.eye, keys[i].camera.eye);
        if (walked > reach && i >= 16) {
            keys.resize(i + 1);
        }
    }
    return keys;
}

const SceneModel::NamedPath* find_named(const SceneModel& model, std::string_view name)
{
    for (const SceneModel::NamedPath& path : model.paths) {
        if (path.name == name && !path.keys.empty()) {
            return &path;
        }
    }
    return nullptr;
}

/// The walk that came with the scene or was found in it, or an empty list.
std::vector<Keyframe> walk_keys(const SceneModel& model, size_t frame_count)
{
    for (const char* name : {"street", "walk"}) {
        if (const SceneModel::NamedPath* own = find_named(model, name)) {
            return paced(own->keys, model.unit, frame_count);
        }
    }
    return paced(find_walk(model), model.unit, frame_count);
}

std::vector<Keyframe> auto_keys(const SceneModel& model, size_t frame_count)
{
    if (!model.motion.empty()) { // no floors: what stands anywhere now is elsewhere later
        const SceneModel::NamedPath* orbit = find_named(model, "orbit");
        return orbit != nullptr ? orbit->keys : orbit_keys(model);
    }
    const auto made_for_it =
        std::find_if(model.paths.begin(), model.paths.end(), [](const SceneModel::NamedPath& path) {
            return !path.name.starts_with(kCameraPrefix);
        });
    if (made_for_it != model.paths.end() && find_named(model, "street") == nullptr &&
        find_named(model, "walk") == nullptr) {
        return made_for_it->keys; // the scene has nowhere to walk
    }
    std::vector<Keyframe> keys = walk_keys(model, frame_count);
    return keys.empty() ? orbit_keys(model) : keys;
}

/// Turning once around where the walk is a third done.
std::vector<Keyframe> spin_keys(const SceneModel& model, size_t frame_count)
{
    constexpr int kSteps = 48;
    const std::vector<Keyframe> walk = auto_keys(model, frame_count);
    const Camera start = walk[walk.size() / 3].camera;
    const GroundAxes axes = ground_axes(model.up);
    std::vector<Keyframe> keys;
    for (int i = 0; i <= kSteps; ++i) {
        Keyframe key;
        key.time = static_cast<float>(i);
        key.camera = start;
        key.camera.target = start.eye + model.unit * kEyeHeight *
                                            around(axes, 360.0f * static_cast<float>(i) / kSteps);
        keys.push_back(key);
    }
    return keys;
}

std::vector<Keyframe> keys_by_name(const std::string& name, const SceneModel& model,
                                   size_t frame_count)
{
    if (const SceneModel::NamedPath* path = find_named(model, name)) {
        return name == "street" || name == "walk" ? walk_keys(model, frame_count) : path->keys;
    }
    if (name == "auto") {
        return auto_keys(model, frame_count);
    }
    if (name == "walk") {
        return walk_keys(model, frame_count);
    }
    if (name == "orbit") {
        return orbit_keys(model);
    }
    if (name == "overview") {
        return overview_keys(model);
    }
    if (name == "spin") {
        return spin_keys(model, frame_count);
    }
    if (name == "teleport") {
        return with_cuts(auto_keys(model, frame_count), model.up);
    }
    return {};
}

std::string known_names(const SceneModel& model)
{
    std::string names;
    for (const PathInfo& info : path_names(model)) {
        names += fmt::format("{}{}", names.empty() ? "" : ", ", info.name);
    }
    return names;
}

} // namespace

Result<std::vector<Camera>> load_path(const std::string& name, const SceneModel& model,
                                      size_t frame_count)
{
    if (frame_count == 0) {
        return Error{ErrorCode::invalid_argument,
                     "a path of 0 frames shows nothing; ask for at least 1 frame"};
    }
    if (name.ends_with(".json")) {
        return read_path_file(name, frame_count, model.origin);
    }
    const std::vector<Keyframe> keys = keys_by_name(name, model, frame_count);
    if (!keys.empty()) {
        return interpolate(keys, frame_count);
    }
    if (name == "walk") {
        return Error{
            ErrorCode::unsupported,
            fmt::format("{} has no floors to walk on; use the path orbit or auto", model.name)};
    }
    std::error_code failed;
    if (std::filesystem::exists(name, failed)) {
        return read_path_file(name, frame_count, model.origin);
    }
    return Error{ErrorCode::not_found,
                 fmt::format("no path is called '{}'; known are {}, or give a "
                             "JSON file",
                             name, known_names(model))};
}

std::vector<PathInfo> path_names(const SceneModel& model)
{
    std::vector<PathInfo> infos{
        {"auto", "the path made for the scene, else a walk where there are floors, else an orbit"},
        {"walk", "a walk at human height through free space"},
        {"orbit", "once around the whole scene"},
        {"overview", "standing still, looking down on the whole scene"},
        {"teleport", "the auto path with cuts and turns by 90 degrees"},
        {"spin", "standing in the scene and turning once around"},
    };
    for (const SceneModel::NamedPath& path : model.paths) {
        const auto is_it = [&](const PathInfo& info) { return info.name == path.name; };
        if (std::none_of(infos.begin(), infos.end(), is_it)) {
            const bool is_camera = path.name.starts_with(kCameraPrefix);
            infos.push_back({path.name, is_camera ? "standing still at a camera of the file"
                                                  : "comes with the scene"});
        }
    }
    return infos;
}

// What all cameras should see: the bulk of the scene, unless one of them stands far from it.
static Aabb bounds_to_see(std::span<const Camera> cameras, const SceneModel& model)
{
    constexpr float kNearby = 8.0f; // times the size of the bulk
    const Focus focus = find_focus(model);
    const float reach = kNearby * glm::length(focus.box.extent());
    const bool all_nearby = std::all_of(cameras.begin(), cameras.end(), [&](const Camera& camera) {
        return glm::distance(camera.eye, focus.box.center()) < reach;
    });
    return all_nearby ? focus.box : world_bounds(model);
}

void choose_depth_range(std::span<Camera> cameras, const SceneModel& model)
{
    const Aabb bounds = bounds_to_see(cameras, model);
    float reach = 0.0f; // the farthest corner from any eye
    for (const Camera& camera : cameras) {
        const glm::vec3 away =
            glm::max(glm::abs(camera.eye - bounds.min), glm::abs(camera.eye - bounds.max));
        reach = std::max(reach, glm::length(away));
    }
    const float far = bounds.is_bounded() && reach > 0.0f ? 1.01f * reach : 1000.0f * model.unit;
    for (Camera& camera : cameras) {
        if (camera.far <= 0.0f) {
            camera.far = std::max(far, 2.0f * camera.near);
        }
        if (camera.near <= 0.0f) {
            camera.near = std::min(std::max(kNear * model.unit, kLeastNearShare * camera.far),
                                   1e-3f * camera.far);
        }
    }
}

} // namespace occlude::tools
