// Camera paths by name and as files.
//
// A path file is JSON, in world units and degrees; "up", "fov_y", "near" and "far" are optional:
//   {"version": 1, "frames": [{"eye": [x,y,z], "target": [x,y,z], "up": [x,y,z], "fov_y": 60},
//   ...]}
// or, interpolated smoothly, with times in seconds and optional cuts:
//   {"version": 1, "keyframes": [{"time": 0, "eye": [...], "target": [...], "cut": false}, ...]}
//
// Either may also say how objects of the scene move. Places and turns count from frame to frame of
// the path; "position" is where the object's origin is, in world space, and "rotation" how far it
// is turned from how it stands in the scene, about an axis, in degrees; both stay as in the scene,
// or as in the entry before, if they are not given:
//   {"version": 1, "frames": [...], "movers": [
//     {"object": "gate", "visible": {"from": 0, "to": 99}, "keyframes": [
//       {"frame": 0, "position": [0,0,0]},
//       {"frame": 50, "position": [0,4,0], "rotation": {"axis": [0,1,0], "degrees": 90}}]}]}
// "object" is a name, or an index from 0; "visible" and "keyframes" may each be omitted.
#pragma once

#include "model/scene_model.h"

#include <occlude/core/result.h>

#include <span>
#include <string>
#include <vector>

namespace occlude::tools {

/// A path for any scene, by name: "auto" (what was made for the scene, a walk where there are
/// floors, an orbit where the scene is an object), "orbit", "walk", "overview", a name in
/// model.paths (cameras of the file among them, as "camera:NAME"), or a JSON file, whose positions
/// are in the coordinates of the scene's file.
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

/// Reads a path file. Frames come as they are, but at most `frame_count` of them; keyframes are
/// interpolated to `frame_count` frames. `origin` is subtracted from all positions, in double
/// precision (SceneModel::origin). Errors name the file, the entry and what it must hold; keys that
/// no entry has are errors, too.
Result<std::vector<Camera>> read_path_file(const std::string& file, size_t frame_count,
                                           const glm::dvec3& origin = glm::dvec3{0.0});

/// Takes over the "movers" of a path file, if it has any: model.motion then says something of every
/// instance, and the motion that came with the scene stays for those that the file does not name.
/// The value is the number of movers. Errors name the file, the entry and what it must hold.
Result<size_t> read_movers(const std::string& file, SceneModel& model);

/// Writes cameras as a path file in the frames form. The value is the number of frames.
Result<size_t> write_path_file(const std::string& file, std::span<const Camera> cameras);

} // namespace occlude::tools
