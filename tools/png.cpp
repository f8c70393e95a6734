#include "png.h"

#include <cstdint>
#include <vector>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wunused-variable"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#include <stb_image_write.h>
#pragma GCC diagnostic pop

namespace occlude::tools {

static void append(void* context, void* data, int size)
{
    static_cast<std::string*>(context)->append(static_cast<const char*>(data),
                                               static_cast<size_t>(size));
}

std::string encode_png(const Image& image)
{
    constexpr int kChannels = 3;
    std::vector<uint8_t> rgb;
    rgb.reserve(image.pixels.size() * kChannels);
    // PNG starts with the top row, images with the bottom one.
    for (int y = image.size.y - 1; y >= 0; --y) {
        for (int x = 0; x < image.size.x; ++x) {
            const uint32_t pixel =
                image.pixels[static_cast<size_t>(y) * static_cast<size_t>(image.size.x) +
                             static_cast<size_t>(x)];
            for (int channel = 0; channel < kChannels; ++channel) {
                rgb.push_back(static_cast<uint8_t>(pixel >> (8 * channel)));
            }
        }
    }
    std::string png;
    stbi_write_png_to_func(append, &png, image.size.x, image.size.y, kChannels, rgb.data(),
                           image.size.x * kChannels);
    return png;
}

} // namespace occlude::tools
