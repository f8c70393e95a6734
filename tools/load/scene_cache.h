// What took long to read, kept for the next time.
#pragma once

#include "load/loaded_scene.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace occlude::tools {

/// A hash of all bytes of a file; 0 if it cannot be read.
uint64_t content_hash(const std::filesystem::path& file);

/// The scene that was kept for `file`, if it and all files that were read with it hold what they
/// held then.
std::optional<LoadedScene> find_cached_scene(const std::filesystem::path& folder,
                                             const std::string& file);

/// Keeps a scene under the hash of its first source: under another name first, renamed when
/// complete. Nothing happens if it has no sources, or the folder cannot be written.
void keep_scene(const std::filesystem::path& folder, const LoadedScene& scene);

} // namespace occlude::tools
