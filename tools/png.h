// Images as PNG files.
#pragma once

#include "render/scene_renderer.h"

#include <string>

namespace occlude::tools {

/// The bytes of a PNG file of the image, alpha left out.
std::string encode_png(const Image& image);

} // namespace occlude::tools
