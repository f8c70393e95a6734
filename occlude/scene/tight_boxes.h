// Makes the shape of a mesh: a few boxes that leave less of space to nothing than one does.
#pragma once

#include <occlude/hierarchy/item_shapes.h>

#include <glm/vec3.hpp>

#include <cstdint>
#include <span>

namespace occlude {

/// At most `most_boxes` boxes, each triangle of `indices` (three per triangle) wholly in one of
/// them and the box tight around its triangles: again and again the largest box is cut at the
/// place, of 15 per axis, that leaves the least volume. A flat box counts as somewhat thick. Cuts
/// that gain nothing in the end are taken back, so that what fills its box has one. The largest
/// come first. The same on every machine. Preconditions: every index is in `positions`. Empty for
/// no triangles, or for 0 boxes. O(triangles * log(boxes)) if the cuts are even.
Shape tight_boxes(std::span<const glm::vec3> positions, std::span<const uint32_t> indices,
                  uint32_t most_boxes);

} // namespace occlude
