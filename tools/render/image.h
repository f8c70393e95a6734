// Pictures: writing and comparing them.
#pragma once

#include "render/scene_renderer.h"

#include <occlude/core/result.h>

#include <cstdint>
#include <filesystem>
#include <string>

namespace occlude::tools {

/// Writes an opaque 8-bit RGB PNG with row 0 at the bottom of the picture; alpha is dropped. Fails
/// if the image is empty or the file cannot be written.
Result<bool> write_png(const std::filesystem::path& path, const Image& image);

/// The bytes of such a PNG. Precondition: the image has pixels.
std::string encode_png(const Image& image);

/// The image reduced by the smallest whole factor that brings it to at most `max_width` pixels;
/// each pixel is the mean of the pixels that it covers. Incomplete blocks of a row or column are
/// dropped.
Image shrunk(const Image& image, int max_width);

/// The number of pixels that differ in any channel; all pixels of the larger image if the sizes
/// differ.
uint64_t count_differences(const Image& a, const Image& b);

} // namespace occlude::tools
