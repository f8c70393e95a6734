// The farthest depth of each tile of a depth buffer, on the CPU.
#pragma once

#include <glm/vec2.hpp>

#include <span>

namespace occlude {

/// Writes the farthest depth of each tile of tile_px x tile_px pixels, tile by tile from the lower
/// left; the right and the upper edge of the target cut tiles off. Preconditions: tile_px >= 1; one
/// depth >= 0 per pixel of `size_px`, row by row; one value per tile (tiles_in(), core/tiles.h).
/// About 0.1 ns per pixel.
void farthest_of_tiles(std::span<const float> depths, glm::ivec2 size_px, int tile_px,
                       std::span<float> tiles);

} // namespace occlude
