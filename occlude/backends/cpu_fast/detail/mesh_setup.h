// From a mesh to prims: transform, clip, snap, find the pieces that face one way and their open
// edges.
#pragma once

#include <occlude/backends/cpu_fast/detail/instance_transform.h>
#include <occlude/backends/cpu_fast/detail/prim.h>
#include <occlude/backends/cpu_fast/occluder_mesh.h>

#include <glm/vec4.hpp>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace occlude::cpu_fast {

/// Scratch memory of one thread.
class MeshSetup {
public:
    /// Appends the prims of an instance.
    void add(const OccluderMesh& mesh, const InstanceTransform& transform, const Grid& grid,
             PrimBatch& out);

private:
    struct Vertex {
        glm::vec4 clip{0.0f}; ///< in cells, as InstanceTransform::column gives it
        Corner corner;        ///< only if code has no bit of kNeedsClipping
        uint8_t code = 0;
    };
    struct PolygonCorner {
        glm::dvec4 clip{0.0};
        Corner corner;
        bool given = false; ///< a vertex of the mesh that needs no clipping
        uint8_t edge = 0;   ///< where the edge that starts here comes from: see clip()
    };
    /// A triangle and one more corner for each plane.
    struct Polygon {
        static constexpr size_t kMaxCorners = 3 + 6;
        std::array<PolygonCorner, kMaxCorners> corners{};
        size_t count = 0;
    };

    void transform_vertices(const OccluderMesh& mesh, const InstanceTransform& transform);
    void classify(const OccluderMesh& mesh, const InstanceTransform& transform);
    int8_t clipped_facing(const OccluderMesh::Triangle& triangle,
                          const InstanceTransform& transform);
    void clip(const InstanceTransform& transform, Polygon& polygon) const;
    void snap(Polygon& polygon) const;
    bool side_wanted(const OccluderMesh& mesh, const OccluderMesh::Piece& piece, int8_t facing,
                     const InstanceTransform& transform) const;
    void emit_piece(const OccluderMesh& mesh, const OccluderMesh::Piece& piece, int8_t facing);
    void emit_polygon(const Polygon& polygon, const std::array<bool, 3>& open, int8_t facing);
    void emit_triangle(const Corner& a, const Corner& b, const Corner& c, PrimKind kind);
    void emit_edge(const Corner& a, const Corner& b);
    void finish_piece(size_t first_prim);
    void bin(uint32_t index);

    std::vector<Vertex> vertices_;
    std::vector<int8_t> facings_; ///< by triangle: 1 counter-clockwise on the grid, -1, 0 left out
    std::vector<uint32_t> polygon_of_; ///< by triangle, where it was clipped
    std::vector<Polygon> polygons_;
    bool any_clipped_ = false;
    float z_slack_ = 0.0f;
    Growth growth_;
    Grid grid_;
    PrimBatch* out_ = nullptr;
};

} // namespace occlude::cpu_fast
