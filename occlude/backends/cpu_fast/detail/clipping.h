// Cutting a triangle where the eye is too near, and far off the screen.
#pragma once

#include <occlude/backends/cpu_fast/detail/instance_transform.h>
#include <occlude/backends/cpu_fast/detail/prim.h>

#include <glm/vec4.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace occlude::cpu_fast {

/// Where an edge of a clipped polygon comes from, besides the three edges of its triangle.
constexpr uint8_t kCutEdge = 3;
constexpr uint8_t kGuardEdge = 4; ///< far off the screen

struct PolygonCorner {
    glm::dvec4 clip{0.0}; ///< in cells, as InstanceTransform::column gives it
    Corner corner;
    bool given = false; ///< a vertex of the mesh that needs no clipping
    uint8_t edge = 0;   ///< of the triangle, the one that starts here; kCutEdge or kGuardEdge
};

/// A triangle and one more corner for each plane.
struct Polygon {
    static constexpr size_t kMaxCorners = 3 + 6;
    std::array<PolygonCorner, kMaxCorners> corners{};
    size_t count = 0;

    /// 1 if all triangles of its fan are counter-clockwise on the grid, -1 if all are clockwise, 0
    /// if neither.
    int8_t facing() const;
};

/// Cuts the polygon and gives corners that the cuts made their places on the grid. Both triangles
/// of an edge find the same corner on it.
void clip(const InstanceTransform& transform, Polygon& polygon);

} // namespace occlude::cpu_fast
