#include "scenes/paths.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <glm/geometric.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>

namespace occlude::tools {
namespace {

using nlohmann::json;

Error bad_path(const std::string& file, const std::string& what)
{
    return {ErrorCode::bad_data, fmt::format("{}: {}", file, what)};
}

/// Reads members of one entry, and keeps the first thing that was wrong.
class Entry {
public:
    Entry(const json& value, std::string place)
        : value_(value)
        , place_(std::move(place))
    {
        if (!value_.is_object()) {
            problem_ =
                place_ + " must be an object such as {\"eye\": [0,0,0], \"target\": [0,0,-1]}";
        }
    }

    bool has(const char* key) const { return value_.is_object() && value_.contains(key); }

    void require(const char* key)
    {
        if (!has(key)) {
            fail(fmt::format("{} has no \"{}\"", place_, key));
        }
    }

    void read(const char* key, glm::vec3& out)
    {
        if (!has(key)) {
            return;
        }
        const json& list = value_[key];
        for (size_t i = 0; i < 3; ++i) {
            const bool is_number = list.is_array() && list.size() == 3 && list[i].is_number();
            const float number = is_number ? list[i].get<float>() : 0.0f;
            if (!is_number || !std::isfinite(number)) {
                fail(fmt::format("{}.{} must be three numbers, such as [1.0, 2.0, 3.0]", place_,
                                 key));
                return;
            }
            out[static_cast<int>(i)] = number;
        }
    }

    void read(const char* key, float& out, float least, float most)
    {
        if (!has(key)) {
            return;
        }
        const float number = value_[key].is_number() ? value_[key].get<float>() : NAN;
        if (!(number >= least && number <= most)) {
            fail(fmt::format("{}.{} must be a number from {} to {}", place_, key, least, most));
            return;
        }
        out = number;
    }

    void read(const char* key, bool& out)
    {
        if (has(key) && !value_[key].is_boolean()) {
            fail(fmt::format("{}.{} must be true or false", place_, key));
        } else if (has(key)) {
            out = value_[key].get<bool>();
        }
    }

    void fail(std::string problem)
    {
        if (problem_.empty()) {
            problem_ = std::move(problem);
        }
    }
    const std::string& place() const { return place_; }
    const std::string& problem() const { return problem_; }

private:
    const json& value_;
    std::string place_;
    std::string problem_;
};

Camera read_camera(Entry& entry)
{
    constexpr float kFarthest = 1e15f;
    Camera camera;
    entry.require("eye");
    entry.require("target");
    entry.read("eye", camera.eye);
    entry.read("target", camera.target);
    entry.read("up", camera.up);
    entry.read("fov_y", camera.fov_y, 0.1f, 179.0f);
    entry.read("near", camera.near, 0.0f, kFarthest);
    entry.read("far", camera.far, 0.0f, kFarthest);
    if (camera.eye == camera.target) {
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

Result<std::vector<Camera>> read_frames(const std::string& file, const json& list,
                                        size_t frame_count)
{
    std::vector<Camera> frames;
    for (size_t i = 0; i < list.size() && i < frame_count; ++i) {
        Entry entry(list[i], fmt::format("frames[{}]", i));
        frames.push_back(read_camera(entry));
        if (!entry.problem().empty()) {
            return bad_path(file, entry.problem());
        }
    }
    return frames;
}

Result<std::vector<Camera>> read_keyframes(const std::string& file, const json& list,
                                           size_t frame_count)
{
    std::vector<Keyframe> keys;
    for (size_t i = 0; i < list.size(); ++i) {
        Entry entry(list[i], fmt::format("keyframes[{}]", i));
        Keyframe key;
        key.camera = read_camera(entry);
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

json to_json(const glm::vec3& v)
{
    return json::array({v.x, v.y, v.z});
}

} // namespace

Result<std::vector<Camera>> read_path_file(const std::string& file, size_t frame_count)
{
    std::error_code failed;
    std::ifstream in(file, std::ios::binary);
    if (!in || std::filesystem::is_directory(file, failed)) {
        return Error{ErrorCode::not_found,
                     fmt::format("{}: cannot be read; check the name and permissions", file)};
    }
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    json root;
    try {
        root = json::parse(text);
    } catch (const json::exception& error) {
        return bad_path(file, fmt::format("is not JSON: {}", error.what()));
    }
    if (!root.is_object()) {
        return bad_path(file, "must hold {\"version\": 1, \"frames\": [...]}");
    }
    const auto version = root.find("version");
    if (version == root.end() || *version != 1) {
        return bad_path(file, "\"version\" must be 1");
    }
    for (const char* form : {"frames", "keyframes"}) {
        const auto list = root.find(form);
        if (list == root.end()) {
            continue;
        }
        if (!list->is_array() || list->empty()) {
            return bad_path(file, fmt::format("\"{}\" must be a list with at least one entry: a "
                                              "path needs frames",
                                              form));
        }
        return std::string_view(form) == "frames" ? read_frames(file, *list, frame_count)
                                                  : read_keyframes(file, *list, frame_count);
    }
    return bad_path(file, "has neither \"frames\" nor \"keyframes\"");
}

Result<size_t> write_path_file(const std::string& file, std::span<const Camera> cameras)
{
    json frames = json::array();
    for (const Camera& camera : cameras) {
        json frame{{"eye", to_json(camera.eye)},
                   {"target", to_json(camera.target)},
                   {"up", to_json(camera.up)},
                   {"fov_y", camera.fov_y}};
        if (camera.near > 0.0f) {
            frame["near"] = camera.near;
        }
        if (camera.far > 0.0f) {
            frame["far"] = camera.far;
        }
        frames.push_back(std::move(frame));
    }
    std::ofstream out(file, std::ios::binary);
    out << json{{"version", 1}, {"frames", std::move(frames)}}.dump(1) << '\n';
    out.flush();
    if (!out) {
        return Error{
            ErrorCode::not_found,
            fmt::format("{}: cannot be written; check the folder and its permissions", file)};
    }
    return cameras.size();
}

} // namespace occlude::tools
