// Operations of loaders and generators on meshes.
#pragma once

#include "model/scene_model.h"

#include <glm/vec2.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace occlude::tools {

/// Sets mesh.parts: one part, or several of at most `item_triangles` each, for which it reorders
/// the indices. Precondition: the mesh has triangles.
void partition_mesh(Mesh& mesh, uint32_t item_triangles);

/// Gives shapes (scene/tight_boxes.h) to the parts of a mesh with so many triangles that a test of
/// all boxes costs a small share of drawing them. The parts must be final. O(triangles).
void make_shapes(Mesh& mesh);

/// Gives a mesh normals from its triangles, and joins its equal vertices. Corners at one position
/// share a normal where their triangles meet at less than 40 degrees; sharper edges stay sharp.
/// O(triangles * triangles per position).
void make_normals(Mesh& mesh);

/// Joins vertices of equal position and normal. O(vertices).
void weld(Mesh& mesh);

/// Cuts a polygon into triangles, appended to `out` in the polygon's winding: ears of the outline
/// seen along its normal, so that concave corners stay concave. A polygon that crosses itself gives
/// some triangles over its corners. Polygons of less than 3 corners give none. O(corners^2).
void triangulate(std::span<const glm::vec3> positions, std::span<const uint32_t> polygon,
                 std::vector<uint32_t>& out);

/// Collects flat-shaded quads and boxes.
class MeshBuilder {
public:
    /// Which faces of a box to leave out.
    enum Faces : uint32_t {
        kNegX = 1,
        kPosX = 2,
        kNegY = 4,
        kPosY = 8,
        kNegZ = 16,
        kPosZ = 32,
        kAllFaces = 63,
    };

    /// Corners counter-clockwise seen from outside: two triangles.
    void quad(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d);
    /// Corners counter-clockwise seen from outside.
    void triangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c);
    /// The given faces of a box, two triangles each.
    void box(const glm::vec3& low, const glm::vec3& high, uint32_t faces = kAllFaces);

    size_t triangles() const { return mesh_.indices.size() / 3; }
    /// The mesh, partitioned; the builder is empty afterwards.
    Mesh take(std::string name, uint32_t item_triangles);

private:
    Mesh mesh_;
};

/// A coordinate frame on a surface: u to the right, v up, w out of it (u x v = w, all of length 1).
struct SurfaceFrame {
    glm::vec3 origin{0.0f};
    glm::vec3 u{1.0f, 0.0f, 0.0f};
    glm::vec3 v{0.0f, 1.0f, 0.0f};
    glm::vec3 w{0.0f, 0.0f, 1.0f};

    glm::vec3 at(float along_u, float along_v, float along_w) const
    {
        return origin + along_u * u + along_v * v + along_w * w;
    }

    /// A rectangle at height `along_w`, seen from outside: two triangles.
    void panel(MeshBuilder& builder, glm::vec2 low, glm::vec2 high, float along_w) const;
    /// A box standing on the surface, without its back: ten triangles.
    void relief(MeshBuilder& builder, const glm::vec3& low, const glm::vec3& high) const;
};

/// `segments` points on the unit circle, counter-clockwise from (1, 0). Computed by square roots
/// only, and so the same on every machine. Precondition: segments is 4, 8, 16 or 32.
std::vector<glm::vec2> unit_circle(uint32_t segments);

/// A tapered upright cylinder without its bottom, 2 or 3 triangles per segment.
void upright_cylinder(MeshBuilder& builder, const glm::vec3& base, float height, float base_radius,
                      float top_radius, uint32_t segments);

} // namespace occlude::tools
