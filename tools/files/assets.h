// The files that the program brings along.
#pragma once

#include <occlude/core/result.h>

#include <filesystem>
#include <string>

namespace occlude::tools {

/// The file `name` (such as "bunny/bunny.glb") in the first folder that has it: the one named by
/// the environment variable OCCLUDE_ASSETS, `share/occlude/assets` of the tree that the program is
/// installed in, the assets of the source tree that it was built from. An error says where it was
/// looked for and what to do.
Result<std::filesystem::path> find_asset(const std::string& name);

} // namespace occlude::tools
