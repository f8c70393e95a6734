// Square tiles over a target: how many there are.
#pragma once

#include <glm/vec2.hpp>

namespace occlude {

/// How many tiles of tile_px x tile_px pixels cover a target: its size divided by tile_px, rounded
/// up. Precondition: tile_px >= 1.
constexpr glm::ivec2 tiles_in(glm::ivec2 size_px, int tile_px)
{
    return {(size_px.x + tile_px - 1) / tile_px, (size_px.y + tile_px - 1) / tile_px};
}

} // namespace occlude
