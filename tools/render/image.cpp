#include "render/image.h"

#include "files/output_file.h"

#include <algorithm>
#include <string>
#include <vector>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#pragma GCC diagnostic ignored "-Wunused-function"
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb_image_write.h>
#pragma GCC diagnostic pop

namespace occlude::tools {

namespace {

void append(void* context, void* data, int size)
{
    static_cast<std::string*>(context)->append(static_cast<const char*>(data),
                                               static_cast<size_t>(size));
}

// RGB bytes, top row first.
std::vector<uint8_t> rgb_top_down(const Image& image)
{
    const auto width = static_cast<size_t>(image.size.x);
    const auto height = static_cast<size_t>(image.size.y);
    std::vector<uint8_t> bytes;
    bytes.reserve(width * height * 3);
    for (size_t row = height; row-- > 0;) {
        for (size_t x = 0; x < width; ++x) {
            const uint32_t pixel = image.pixels[row * width + x];
            for (const uint32_t shift : {0u, 8u, 16u}) {
                bytes.push_back(static_cast<uint8_t>(pixel >> shift & 0xff));
            }
        }
    }
    return bytes;
}

} // namespace

Result<bool> write_png(const std::filesystem::path& path, const Image& image)
{
    if (image.size.x <= 0 || image.size.y <= 0 ||
        image.pixels.size() !=
            static_cast<size_t>(image.size.x) * static_cast<size_t>(image.size.y)) {
        return Error{ErrorCode::invalid_argument,
                     "cannot write '" + path.string() + "': the image has no pixels"};
    }
    auto file = OutputFile::open(path);
    if (!file) {
        return file.error();
    }
    return file->commit(encode_png(image));
}

std::string encode_png(const Image& image)
{
    const std::vector<uint8_t> bytes = rgb_top_down(image);
    std::string encoded;
    stbi_write_png_to_func(append, &encoded, image.size.x, image.size.y, 3, bytes.data(),
                           image.size.x * 3);
    return encoded;
}

Image shrunk(const Image& image, int max_width)
{
    const int factor = (image.size.x + max_width - 1) / max_width;
    if (factor <= 1) {
        return image;
    }
    const auto area = static_cast<uint32_t>(factor * factor);
    Image small{image.size / factor, {}};
    small.pixels.reserve(static_cast<size_t>(small.size.x) * static_cast<size_t>(small.size.y));
    for (int y = 0; y < small.size.y; ++y) {
        for (int x = 0; x < small.size.x; ++x) {
            uint32_t pixel = 0;
            for (uint32_t shift = 0; shift < 32; shift += 8) {
                uint32_t sum = area / 2; // rounds to the nearest
                for (int i = 0; i < factor * factor; ++i) {
                    const int row = y * factor + i / factor;
                    const int column = x * factor + i % factor;
                    sum += image.pixels[static_cast<size_t>(row * image.size.x + column)] >> shift &
                           0xffu;
                }
                pixel |= sum / area << shift;
            }
            small.pixels.push_back(pixel);
        }
    }
    return small;
}

uint64_t count_differences(const Image& a, const Image& b)
{
    if (a.size != b.size) {
        return std::max(a.pixels.size(), b.pixels.size());
    }
    uint64_t count = 0;
    for (size_t i = 0; i < a.pixels.size(); ++i) {
        count += a.pixels[i] != b.pixels[i] ? 1 : 0;
    }
    return count;
}

} // namespace occlude::tools
