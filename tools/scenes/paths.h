// Camera paths by name and as files. load_path(), path_names() and choose_depth_range() are
// declared in scene_source.h.
//
// A path file is JSON, in world units and degrees; "up", "fov_y", "near" and "far" are optional:
//   {"version": 1, "frames": [{"eye": [x,y,z], "target": [x,y,z], "up": [x,y,z], "fov_y": 60},
//   ...]}
// or, interpolated smoothly, with times in seconds and optional cuts:
//   {"version": 1, "keyframes": [{"time": 0, "eye": [...], "target": [...], "cut": false}, ...]}
#pragma once

#include "scenes/scene_source.h"

#include <string>

namespace occlude::tools {

/// Reads a path file. Frames come as they are, but at most `frame_count` of them; keyframes are
/// interpolated to `frame_count` frames. Errors name the file, the entry and what it must hold.
Result<std::vector<Camera>> read_path_file(const std::string& file, size_t frame_count);

/// Writes cameras as a path file in the frames form. The value is the number of frames.
Result<size_t> write_path_file(const std::string& file, std::span<const Camera> cameras);

} // namespace occlude::tools
