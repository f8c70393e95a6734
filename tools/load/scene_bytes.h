// A loaded scene as bytes: what a child process hands back, and what the cache keeps.
#pragma once

#include "load/loaded_scene.h"

#include <cstdint>
#include <cstdio>
#include <optional>
#include <span>

namespace occlude::tools {

/// Appends the scene to a stream. False if the stream fails.
bool write_scene(std::FILE* out, const LoadedScene& scene);

/// The scene in `bytes`; nothing if they are not all of one, or not of this version. Indices of
/// vertices, meshes and materials are checked.
std::optional<LoadedScene> read_scene(std::span<const uint8_t> bytes);

} // namespace occlude::tools
