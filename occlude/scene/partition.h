// Splits a mesh in space, so that parts of it can be culled one by one.
#pragma once

#include <occlude/core/aabb.h>

#include <glm/vec3.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace occlude {

/// A run of the reordered index buffer.
struct PartitionPart {
    uint32_t first_index = 0;
    uint32_t index_count = 0; ///< three per triangle
    Aabb box;                 ///< tight around the positions used, in their space
};

struct Partition {
    std::vector<uint32_t> indices;    ///< the triangles given, reordered; corners keep their order
    std::vector<PartitionPart> parts; ///< covers all indices, in order
};

/// The triangles of `indices` (three per triangle) in parts of at most `max_triangles`. Recursively
/// divides the triangles' centroids along the longest axis of the centroids' box, where the surface
/// area heuristic is least and at least a quarter is left on either side. Triangles stay whole, so
/// boxes of neighbouring parts may overlap. The result is the same on every machine: ties are
/// broken by triangle number, and within a part triangles keep their order. Preconditions: every
/// index is in `positions`, max_triangles > 0. Empty for no triangles. O(n log^2 n).
Partition partition_triangles(std::span<const glm::vec3> positions,
                              std::span<const uint32_t> indices, uint32_t max_triangles);

} // namespace occlude
