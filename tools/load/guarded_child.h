// Code of others that reads files, in a process of its own: it may crash, hang or eat memory there.
#pragma once

#include "load/loaded_scene.h"

#include <occlude/core/result.h>

#include <cstdint>
#include <functional>
#include <string>

namespace occlude::tools {

/// Tells how much of the work is done, 0 to 1.
using ReadProgress = std::function<void(double share)>;

struct ChildLimits {
    uint32_t seconds = 120;     ///< of time, by the clock on the wall
    uint64_t memory_mib = 4096; ///< that it may have more than this process has
};

/// What `read` returns, computed in a child process. Errors of `read` come back as they are; a
/// crash, an exhausted limit or an exception become an error that names `file`, what happened and a
/// remedy. `reader` is how the message calls the code ("Assimp"). What `read` tells of its progress
/// is handed to `progress` (which may be empty) in this process, a few times a second.
Result<LoadedScene>
read_in_child(const std::string& file, const std::string& reader, const ChildLimits& limits,
              const ReadProgress& progress,
              const std::function<Result<LoadedScene>(const ReadProgress& progress)>& read);

} // namespace occlude::tools
