#include "walk/path_json.h"
#include "walk/paths.h"

#include <fmt/core.h>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include <vector>

namespace occlude::tools {
namespace {

constexpr uint32_t kLastFrame = 1000000000;

/// The instance that a mover names, or what is wrong with the name.
Result<uint32_t> find_object(const Json& object, const SceneModel& model)
{
    const size_t count = model.instances.size();
    if (object.is_unsigned() && object.unsigned_number() < count) {
        return static_cast<uint32_t>(object.unsigned_number());
    }
    if (!object.is_string()) {
        return Error{ErrorCode::bad_data,
                     fmt::format("must be an object's name, or its index from 0 to {}", count - 1)};
    }
    const std::string& name = object.text();
    size_t found = 0;
    uint32_t index = 0;
    for (uint32_t i = 0; i < count; ++i) {
        if (model.instances[i].name == name) {
            ++found;
            index = i;
        }
    }
    if (found == 1) {
        return index;
    }
    return Error{ErrorCode::bad_data,
                 found == 0
                     ? fmt::format("no object of {} is called '{}'; give another name, or an index "
                                   "from 0 to {}",
                                   model.name, name, count - 1)
                     : fmt::format("{} objects are called '{}'; give an index from 0 to {} instead",
                                   found, name, count - 1)};
}

void read_rotation(const Json& value, PathEntry& key_entry, glm::quat& out)
{
    PathEntry entry(value, key_entry.place() + ".rotation", "{\"axis\": [0,1,0], \"degrees\": 90}");
    glm::vec3 axis{0.0f};
    float degrees = 0.0f;
    entry.allow_only({"axis", "degrees"});
    entry.require("axis");
    entry.require("degrees");
    entry.read("axis", axis);
    entry.read("degrees", degrees, -1e6f, 1e6f);
    const float length = glm::length(axis);
    if (entry.problem().empty() && !(length > 0.0f)) {
        entry.fail(entry.place() + ".axis has no direction");
    }
    if (!entry.problem().empty()) {
        key_entry.fail(entry.problem());
        return;
    }
    out = glm::angleAxis(glm::radians(degrees), axis / length);
}

/// The keys of one mover into `motion`; what is wrong with them into `mover`.
void read_keys(const Json& list, PathEntry& mover, const SceneModel& model, uint32_t index,
               InstanceMotion& motion)
{
    if (!list.is_array() || list.empty()) {
        mover.fail(mover.place() + ".keyframes must be a list with at least one entry");
        return;
    }
    MotionKey key;
    // In the coordinates of the file, as the path's positions are.
    glm::dvec3 position =
        glm::dvec3{glm::vec3{model.instances[index].world_from_mesh[3]}} + model.origin;
    for (size_t i = 0; i < list.size(); ++i) {
        PathEntry entry(list.at(i), fmt::format("{}.keyframes[{}]", mover.place(), i),
                        "{\"frame\": 0, \"position\": [0,0,0]}");
        entry.allow_only({"frame", "position", "rotation"});
        entry.require("frame");
        entry.read("frame", key.frame, kLastFrame);
        entry.read("position", position);
        key.position = glm::vec3{position - model.origin};
        if (entry.has("rotation")) {
            read_rotation(list.at(i).at("rotation"), entry, key.rotation);
        }
        if (!motion.keys.empty() && key.frame <= motion.keys.back().frame) {
            entry.fail(entry.place() + ".frame must be later than the one before");
        }
        if (!entry.problem().empty()) {
            mover.fail(entry.problem());
            return;
        }
        motion.keys.push_back(key);
    }
}

void read_visible(const Json& value, PathEntry& mover, InstanceMotion& motion)
{
    PathEntry entry(value, mover.place() + ".visible", "{\"from\": 0, \"to\": 99}");
    entry.allow_only({"from", "to"});
    entry.read("from", motion.first_frame, kLastFrame);
    entry.read("to", motion.last_frame, kLastFrame);
    if (motion.first_frame > motion.last_frame) {
        entry.fail(entry.place() + ".to must not be before from");
    }
    if (!entry.problem().empty()) {
        mover.fail(entry.problem());
    }
}

} // namespace

Result<size_t> read_movers(const std::string& file, SceneModel& model)
{
    const auto root = read_path_json(file);
    if (!root) {
        return root.error();
    }
    const Json* const movers = root->find("movers");
    if (movers == nullptr) {
        return size_t{0};
    }
    if (!movers->is_array()) {
        return bad_path(file, "\"movers\" must be a list");
    }
    std::vector<InstanceMotion> motions = model.motion.instances;
    motions.resize(model.instances.size());
    std::vector<bool> named(model.instances.size(), false);
    for (size_t i = 0; i < movers->size(); ++i) {
        const Json& value = movers->at(i);
        PathEntry mover(value, fmt::format("movers[{}]", i),
                        "{\"object\": \"gate\", \"keyframes\": [...]}");
        mover.allow_only({"object", "keyframes", "visible"});
        mover.require("object");
        if (!mover.problem().empty()) {
            return bad_path(file, mover.problem());
        }
        const auto index = find_object(value.at("object"), model);
        if (!index) {
            return bad_path(file,
                            fmt::format("{}.object: {}", mover.place(), index.error().message));
        }
        if (named[*index]) {
            mover.fail(mover.place() + ".object is moved by an entry before it already");
        }
        named[*index] = true;
        motions[*index] = {};
        if (mover.has("keyframes")) {
            read_keys(value.at("keyframes"), mover, model, *index, motions[*index]);
        }
        if (mover.has("visible")) {
            read_visible(value.at("visible"), mover, motions[*index]);
        }
        if (!mover.has("keyframes") && !mover.has("visible")) {
            mover.fail(mover.place() + " has neither \"keyframes\" nor \"visible\"");
        }
        if (!mover.problem().empty()) {
            return bad_path(file, mover.problem());
        }
    }
    if (!movers->empty()) {
        model.motion.instances = std::move(motions);
    }
    return movers->size();
}

} // namespace occlude::tools
