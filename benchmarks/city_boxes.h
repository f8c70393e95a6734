// A city of boxes for benchmarks: what a renderer's objects look like from a street.
//
// Blocks of buildings stand in a square grid with streets between them. A block has 1000 boxes:
//   16    shells: the outside of a building, 12 triangles; they hide nearly everything
//   768   what is on their walls: balconies, signs, windows, 48 to a building
//   64    furniture inside, 4 to a building, never seen from outside
//   152   street furniture on the pavements around the block
// A larger city has more blocks, not larger ones: what a street-level view sees stays about the
// same.
#pragma once

#include <occlude/core/view.h>
#include <occlude/hierarchy/hierarchy.h>

#include <cstddef>
#include <vector>

namespace occlude::bench {

/// `count` boxes, 12 triangles each. Whole blocks: the last one may be cut short.
std::vector<ItemBounds> city_boxes(size_t count);

/// Frame `frame` of `frames` of a walk along a street in the middle of the city of `count` boxes,
/// 6 units above the ground, with a look to the side, 60 degrees high.
View street_view(size_t count, size_t frame, size_t frames, glm::ivec2 size_px);

/// What a perfect renderer would see: through the middle of every pixel the nearest box.
struct Truth {
    std::vector<float> depth;      ///< window depth, row by row from the bottom; 1 where nothing is
    std::vector<uint32_t> visible; ///< places in Hierarchy::items(), ascending, each once
};
Truth look_through_pixels(const Hierarchy& hierarchy, const View& view);

} // namespace occlude::bench
