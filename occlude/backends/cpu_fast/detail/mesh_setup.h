// From a mesh to prims: the pieces that face one way, their open edges, and the bins they lie in.
#pragma once

#include <occlude/backends/cpu_fast/detail/clipping.h>
#include <occlude/backends/cpu_fast/detail/instance_transform.h>
#include <occlude/backends/cpu_fast/detail/prim.h>
#include <occlude/backends/cpu_fast/detail/triangle_setup.h>
#include <occlude/backends/cpu_fast/occluder_mesh.h>

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
             const SetupKernels& kernels, PrimBatch& out);

private:
    using Triangle = OccluderMesh::Triangle;

    void add_loose(const OccluderMesh& mesh);
    void classify(const OccluderMesh& mesh);
    uint32_t codes_of(const Triangle& triangle) const;
    int8_t clip_triangle(const OccluderMesh& mesh, const Triangle& triangle);
    bool side_wanted(const OccluderMesh& mesh, const OccluderMesh::Piece& piece,
                     int8_t facing) const;
    void add_piece(const OccluderMesh& mesh, const OccluderMesh::Piece& piece, int8_t facing);
    void add_triangles(std::span<const Triangle> triangles, PrimKind kind);
    void add_polygon(const Polygon& polygon, const std::array<bool, 3>& open);
    void add_edge(const Corner& a, const Corner& b);
    void finish_piece(size_t first_prim);
    void bin_from(size_t first_prim);
    void bin(uint32_t index);

    ScreenVertices vertices_;
    std::vector<int8_t> facings_; ///< by triangle: 1 counter-clockwise on the grid, -1, 0 left out
    std::vector<uint32_t> polygon_of_; ///< by triangle, where it was clipped
    std::vector<Polygon> polygons_;
    std::vector<Triangle> alone_; ///< of a piece
    std::vector<Triangle> joined_;
    uint32_t any_code_ = 0;
    TriangleSetup setup_;
    Grid grid_;
    const InstanceTransform* transform_ = nullptr;
    const SetupKernels* kernels_ = nullptr;
    PrimBatch* out_ = nullptr;
};

} // namespace occlude::cpu_fast
