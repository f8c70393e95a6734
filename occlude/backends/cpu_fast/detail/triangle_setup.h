// From vertices of a mesh to prims: transform, orientation, lines and depth planes. By vectors, and
// one after the other as the specification says.
#pragma once

#include <occlude/backends/cpu_fast/detail/instance_transform.h>
#include <occlude/backends/cpu_fast/detail/prim.h>
#include <occlude/backends/cpu_fast/occluder_mesh.h>
#include <occlude/screen/kernel.h>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace occlude::cpu_fast {

/// Why a vertex cannot be used as it is: bits of its code.
constexpr uint32_t kBeforeLeastW = 1;
constexpr uint32_t kBeforeNear = 2;
constexpr uint32_t kBeyondGuardLeft = 4;
constexpr uint32_t kBeyondGuardRight = 8;
constexpr uint32_t kBeyondGuardBottom = 16;
constexpr uint32_t kBeyondGuardTop = 32;
constexpr uint32_t kNotFinite = 64;

/// The vertices of an instance on the grid. Where the code is not 0, the corner is (0, 0, 0).
struct ScreenVertices {
    std::vector<int32_t> x; ///< 1/256 cell
    std::vector<int32_t> y;
    std::vector<float> z;
    std::vector<uint32_t> code;

    /// Room for `count` vertices and the rest of a vector. Never shrinks.
    void reserve(size_t count);
    Corner corner(uint32_t i) const { return {x[i], y[i], z[i]}; }
};

/// Which triangles become prims, and which.
struct TriangleSetup {
    glm::ivec2 size{0}; ///< of the grid, in whole sub-tiles
    Growth growth{};
    PrimKind kind = PrimKind::triangle; ///< triangle or alone
    uint32_t piece = 0;
    bool counterclockwise = true; ///< those that are so on the grid
    bool clockwise = true;
};

struct SetupKernels {
    /// Fills `out` for all positions. Returns the codes of all vertices, or'ed.
    uint32_t (*transform)(std::span<const glm::vec3> positions, const InstanceTransform& transform,
                          ScreenVertices& out);
    /// For each triangle 1 if it is counter-clockwise on the grid, -1 if clockwise, 0 without area.
    void (*facings)(std::span<const OccluderMesh::Triangle> triangles,
                    const ScreenVertices& vertices, int8_t* facings);
    /// Writes the prims of those that may fill a cell, in order; returns how many.
    /// Precondition: room for all triangles at `out`.
    size_t (*triangles)(std::span<const OccluderMesh::Triangle> triangles,
                        const ScreenVertices& vertices, const TriangleSetup& setup, Prim* out);
};

const SetupKernels& setup_kernels(Kernel kernel);
const SetupKernels& simd_setup_kernels();

/// A position in clip space, in cells, as InstanceTransform::column gives it.
glm::vec4 clip_position(const InstanceTransform& transform, const glm::vec3& position);

/// Twice the area of a triangle on the grid, exactly; positive if it is counter-clockwise.
inline int64_t twice_area(const Corner& a, const Corner& b, const Corner& c)
{
    return int64_t{b.x - a.x} * (c.y - a.y) - int64_t{b.y - a.y} * (c.x - a.x);
}

/// The prim of one triangle, whatever its orientation. False if it has no area or fills no cell.
bool make_triangle(const Corner& a, const Corner& b, const Corner& c, const TriangleSetup& setup,
                   Prim& prim);
/// A band around an edge. False if it has no length, or touches no cell of the grid.
bool make_edge(const Corner& a, const Corner& b, const TriangleSetup& setup, Prim& prim);

/// How far the grown cells reach in subcells, rounded up.
inline int32_t subcells_of(float growth_cells)
{
    return static_cast<int32_t>(growth_cells * static_cast<float>(kSubcells)) + 1;
}

/// Depth planes in float: errors of 2^-22 times the condition of the area, and of planes in bins.
constexpr float kPlaneRounding = 0x1p-22f;
constexpr float kDepthRounding = 0x1p-21f;
/// Areas that are known to less than this are too thin for a plane: flat at their farthest depth.
constexpr float kThinnest = 0x1p-20f;

} // namespace occlude::cpu_fast
