#include <occlude/screen/depth_tiles.h>

#include <occlude/core/tiles.h>

#include <algorithm>

namespace occlude {

void farthest_of_tiles(std::span<const float> depths, glm::ivec2 size_px, int tile_px,
                       std::span<float> tiles)
{
    std::ranges::fill(tiles, 0.0f);
    const auto side = static_cast<size_t>(tile_px);
    const auto width = static_cast<size_t>(size_px.x);
    const auto across = static_cast<size_t>(tiles_in(size_px, tile_px).x);
    for (size_t y = 0; y < static_cast<size_t>(size_px.y); ++y) {
        const float* row = depths.data() + y * width;
        float* out = tiles.data() + y / side * across;
        for (size_t first = 0; first < width; first += side, ++out) {
            float farthest = *out;
            for (size_t x = first; x < std::min(first + side, width); ++x) {
                farthest = row[x] > farthest ? row[x] : farthest;
            }
            *out = farthest;
        }
    }
}

} // namespace occlude
