// A city of boxes for benchmarks, as a renderer sees its objects from a street.
//
// Blocks of buildings stand in a square grid with streets between them. A block has 1000 boxes:
//   16    shells: the outside of a building, 12 triangles; they hide nearly everything
//   768   balconies, signs and windows on the walls, 48 to a building
//   64    furniture inside, 4 to a building, never visible from outside
//   152   street furniture on the pavements around the block
// A larger city has more blocks of the same size, so that a view from a street sees about the same
// number of boxes.
#pragma once

#include <occlude/core/view.h>
#include <occlude/hierarchy/hierarchy.h>

#include <cstddef>
#include <vector>

namespace occlude::bench {

/// `count` boxes, 12 triangles each, in whole blocks. The last block may be incomplete.
std::vector<ItemBounds> city_boxes(size_t count);

/// View number `frame` of `frames` of a walk along a street in the middle of the city of `count`
/// boxes, 6 units above the ground. The camera looks to the side, 60 degrees high.
View street_view(size_t count, size_t frame, size_t frames, glm::ivec2 size_px);

/// The visible boxes: the nearest box at the middle of every pixel.
struct Truth {
    std::vector<float> depth;      ///< window depth, row by row from the bottom; 1 where nothing is
    std::vector<uint32_t> visible; ///< places in Hierarchy::items(), ascending, each once
};
Truth look_through_pixels(const Hierarchy& hierarchy, const View& view);

} // namespace occlude::bench
