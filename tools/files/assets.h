// The files that come with the program.
#pragma once

#include <occlude/core/result.h>

#include <filesystem>
#include <string>

namespace occlude::tools {

/// The file `name` (such as "bunny/bunny.glb") in the first folder that has it: the folder in the
/// environment variable OCCLUDE_ASSETS, `share/occlude/assets` of the tree in which the program is
/// installed, the assets of the source tree that it was built from. An error lists these folders
/// and says what to do.
Result<std::filesystem::path> find_asset(const std::string& name);

} // namespace occlude::tools
