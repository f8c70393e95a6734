// What Assimp must not be given.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace occlude::tools {

/// What is wrong with a file that Assimp (5.2) would crash over, read for ever or take for whole,
/// and the remedy; nothing for all others, broken or not. `file_size` in bytes. Reads the header of
/// a PLY or GLB file, and the JSON of glTF, which costs some 10 ms a megabyte.
std::optional<std::string> unreadable_by_assimp(const std::string& file, uintmax_t file_size);

} // namespace occlude::tools
