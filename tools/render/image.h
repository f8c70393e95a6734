// Pictures: writing and comparing them.
#pragma once

#include "render/scene_renderer.h"

#include <occlude/core/result.h>

#include <cstdint>
#include <filesystem>

namespace occlude::tools {

/// Writes an opaque 8-bit RGB PNG with row 0 at the bottom of the picture; alpha is dropped. Fails
/// if the image is empty or the file cannot be written.
Result<bool> write_png(const std::filesystem::path& path, const Image& image);

/// Pixels that differ in any channel; all of them (of the larger image) if the sizes differ.
uint64_t count_differences(const Image& a, const Image& b);

} // namespace occlude::tools
