// A lattice of nearly cubic cells over a box; maps points to cells.
#pragma once

#include <occlude/core/aabb.h>
#include <occlude/core/assert.h>

#include <cstdint>

namespace occlude {

/// Cells of one size that fill the box, nearly cubes; an axis along which the box is flat has one.
struct Lattice {
    glm::dvec3 low{0.0};
    glm::dvec3 cell_size{0.0};
    glm::uvec3 count{1}; ///< cells along each axis

    /// At least `cells` cells and few more, at most kMaxPerAxis along each axis; one cell if the
    /// box is a point. Precondition: `box` is bounded; otherwise there is one cell around
    /// everything.
    static Lattice over(const Aabb& box, uint64_t cells);

    /// The cell of a point, or the nearest cell if the point is outside. Precondition: no
    /// coordinate is NaN; otherwise the first cell along that axis.
    glm::uvec3 cell(const glm::vec3& point) const;

    /// The index of a cell. Precondition: it is less than `count` along each axis.
    uint64_t index(const glm::uvec3& cell) const
    {
        OCCLUDE_ASSERT(cell.x < count.x && cell.y < count.y && cell.z < count.z,
                       "a cell lies in its lattice");
        return (uint64_t{cell.z} * count.y + cell.y) * count.x + cell.x;
    }
    /// The cell of an index. Precondition: it is less than cell_count().
    glm::uvec3 at(uint64_t index) const
    {
        OCCLUDE_ASSERT(index < cell_count(), "the index is beyond the cells of the lattice");
        return {static_cast<uint32_t>(index % count.x),
                static_cast<uint32_t>(index / count.x % count.y),
                static_cast<uint32_t>(index / count.x / count.y)};
    }
    uint64_t cell_count() const { return uint64_t{count.x} * count.y * count.z; }

    static constexpr uint32_t kMaxPerAxis = 1024;
};

} // namespace occlude
