// Makes the shape of a mesh: a few boxes that enclose less empty space than one box does.
#pragma once

#include <occlude/hierarchy/item_shapes.h>

#include <glm/vec3.hpp>

#include <cstdint>
#include <span>

namespace occlude {

/// At most `most_boxes` boxes; each triangle of `indices` (three per triangle) lies wholly in one
/// of them, and each box is tight around its triangles. Repeatedly divides the largest box at the
/// place, of 15 per axis, that leaves the least volume. A flat box counts as somewhat thick. Cuts
/// that gain too little are undone, so that a mesh that fills its box keeps one. The largest boxes
/// come first. The result is the same on every machine. Precondition: every index is in
/// `positions`. Empty for no triangles, or for 0 boxes. O(triangles * log(boxes)) if the cuts are
/// even.
Shape tight_boxes(std::span<const glm::vec3> positions, std::span<const uint32_t> indices,
                  uint32_t most_boxes);

} // namespace occlude
