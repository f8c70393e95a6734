#include "model/mesh_tools.h"

#include <occlude/scene/partition.h>
#include <occlude/scene/tight_boxes.h>

#include <glm/geometric.hpp>

#include <cmath>
#include <utility>

namespace occlude::tools {
namespace {

/// A shape has at most kMostBoxes boxes, and one for each kTrianglesPerBox triangles of the part.
constexpr uint32_t kMostBoxes = 16;
constexpr uint32_t kTrianglesPerBox = 32;
glm::vec3 direction_of(const glm::vec3& v)
{
    const float length = glm::length(v);
    return length > 0.0f ? v / length : glm::vec3{0.0f, 1.0f, 0.0f};
}

/// Twice the area of a polygon, along its normal (Newell).
glm::vec3 area_vector(std::span<const glm::vec3> positions, std::span<const uint32_t> polygon)
{
    glm::vec3 sum{0.0f};
    const glm::vec3& origin = positions[polygon[0]];
    for (size_t i = 1; i + 1 < polygon.size(); ++i) {
        sum += glm::cross(positions[polygon[i]] - origin, positions[polygon[i + 1]] - origin);
    }
    return sum;
}

/// True if the corner `at` of the outline is convex and no other corner lies in its triangle.
bool is_ear(std::span<const glm::vec3> positions, std::span<const uint32_t> outline, size_t at,
            const glm::vec3& normal)
{
    const size_t count = outline.size();
    const uint32_t ids[3] = {outline[(at + count - 1) % count], outline[at],
                             outline[(at + 1) % count]};
    const glm::vec3 corners[3] = {positions[ids[0]], positions[ids[1]], positions[ids[2]]};
    const auto side = [&](size_t edge, const glm::vec3& p) {
        const glm::vec3& from = corners[edge];
        return glm::dot(normal, glm::cross(corners[(edge + 1) % 3] - from, p - from));
    };
    if (side(0, corners[2]) <= 0.0f) {
        return false;
    }
    for (uint32_t other : outline) {
        const glm::vec3& p = positions[other];
        const bool is_corner = p == corners[0] || p == corners[1] || p == corners[2];
        if (!is_corner && side(0, p) >= 0.0f && side(1, p) >= 0.0f && side(2, p) >= 0.0f) {
            return false;
        }
    }
    return true;
}

} // namespace

void triangulate(std::span<const glm::vec3> positions, std::span<const uint32_t> polygon,
                 std::vector<uint32_t>& out)
{
    constexpr size_t kMostCorners = 4096; // larger polygons become a fan, to limit the time for
                                          // broken files
    if (polygon.size() < 3) {
        return;
    }
    const glm::vec3 normal = area_vector(positions, polygon);
    std::vector<uint32_t> outline(polygon.begin(), polygon.end());
    while (outline.size() > 3) {
        size_t ear = 0;
        while (ear < outline.size() && !is_ear(positions, outline, ear, normal)) {
            ++ear;
        }
        if (ear == outline.size() || outline.size() > kMostCorners) {
            ear = 1; // crossing or flat: cut any ear
        }
        const size_t before = (ear + outline.size() - 1) % outline.size();
        const size_t after = (ear + 1) % outline.size();
        out.insert(out.end(), {outline[before], outline[ear], outline[after]});
        outline.erase(outline.begin() + static_cast<std::ptrdiff_t>(ear));
    }
    out.insert(out.end(), outline.begin(), outline.end());
}

void partition_mesh(Mesh& mesh, uint32_t item_triangles)
{
    Partition partition = partition_triangles(mesh.positions, mesh.indices, item_triangles);
    mesh.indices = std::move(partition.indices);
    mesh.parts.clear();
    for (const PartitionPart& part : partition.parts) {
        mesh.parts.push_back({part.first_index, part.index_count, part.box});
    }
}

void make_shapes(Mesh& mesh)
{
    for (MeshPart& part : mesh.parts) {
        const uint32_t most = std::min(part.index_count / 3 / kTrianglesPerBox, kMostBoxes);
        if (most < 2) {
            continue;
        }
        Shape boxes =
            tight_boxes(mesh.positions,
                        std::span{mesh.indices}.subspan(part.first_index, part.index_count), most);
        if (boxes.size() > 1) {
            part.shape = std::make_shared<const Shape>(std::move(boxes));
        }
    }
}

void MeshBuilder::quad(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c,
                       const glm::vec3& d)
{
    const auto first = static_cast<uint32_t>(mesh_.positions.size());
    const glm::vec3 normal = direction_of(glm::cross(c - a, d - b));
    mesh_.positions.insert(mesh_.positions.end(), {a, b, c, d});
    mesh_.normals.insert(mesh_.normals.end(), 4, normal);
    mesh_.indices.insert(mesh_.indices.end(),
                         {first, first + 1, first + 2, first, first + 2, first + 3});
}

void MeshBuilder::triangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c)
{
    const auto first = static_cast<uint32_t>(mesh_.positions.size());
    const glm::vec3 normal = direction_of(glm::cross(b - a, c - a));
    mesh_.positions.insert(mesh_.positions.end(), {a, b, c});
    mesh_.normals.insert(mesh_.normals.end(), 3, normal);
    mesh_.indices.insert(mesh_.indices.end(), {first, first + 1, first + 2});
}

void MeshBuilder::box(const glm::vec3& low, const glm::vec3& high, uint32_t faces)
{
    const auto corner = [&](int x, int y, int z) {
        return glm::vec3{x != 0 ? high.x : low.x, y != 0 ? high.y : low.y, z != 0 ? high.z : low.z};
    };
    if ((faces & kNegX) != 0) {
        quad(corner(0, 0, 0), corner(0, 0, 1), corner(0, 1, 1), corner(0, 1, 0));
    }
    if ((faces & kPosX) != 0) {
        quad(corner(1, 0, 1), corner(1, 0, 0), corner(1, 1, 0), corner(1, 1, 1));
    }
    if ((faces & kNegY) != 0) {
        quad(corner(0, 0, 0), corner(1, 0, 0), corner(1, 0, 1), corner(0, 0, 1));
    }
    if ((faces & kPosY) != 0) {
        quad(corner(0, 1, 1), corner(1, 1, 1), corner(1, 1, 0), corner(0, 1, 0));
    }
    if ((faces & kNegZ) != 0) {
        quad(corner(1, 0, 0), corner(0, 0, 0), corner(0, 1, 0), corner(1, 1, 0));
    }
    if ((faces & kPosZ) != 0) {
        quad(corner(0, 0, 1), corner(1, 0, 1), corner(1, 1, 1), corner(0, 1, 1));
    }
}

void SurfaceFrame::panel(MeshBuilder& builder, glm::vec2 low, glm::vec2 high, float along_w) const
{
    builder.quad(at(low.x, low.y, along_w), at(high.x, low.y, along_w), at(high.x, high.y, along_w),
                 at(low.x, high.y, along_w));
}

void SurfaceFrame::relief(MeshBuilder& builder, const glm::vec3& low, const glm::vec3& high) const
{
    const glm::vec3 a = at(low.x, low.y, high.z);
    const glm::vec3 b = at(high.x, low.y, high.z);
    const glm::vec3 c = at(high.x, high.y, high.z);
    const glm::vec3 d = at(low.x, high.y, high.z);
    const glm::vec3 in = (low.z - high.z) * w;
    builder.quad(a, b, c, d);
    builder.quad(a + in, a, d, d + in);
    builder.quad(b, b + in, c + in, c);
    builder.quad(d, c, c + in, d + in);
    builder.quad(a + in, b + in, b, a);
}

std::vector<glm::vec2> unit_circle(uint32_t segments)
{
    glm::vec2 step{0.0f, 1.0f}; // a quarter turn, halved until it is one segment
    for (uint32_t count = 4; count < segments; count *= 2) {
        step = {std::sqrt(0.5f * (1.0f + step.x)), std::sqrt(0.5f * (1.0f - step.x))};
    }
    std::vector<glm::vec2> points{{1.0f, 0.0f}};
    while (points.size() < segments) {
        const glm::vec2 last = points.back();
        points.emplace_back(last.x * step.x - last.y * step.y, last.x * step.y + last.y * step.x);
    }
    return points;
}

void upright_cylinder(MeshBuilder& builder, const glm::vec3& base, float height, float base_radius,
                      float top_radius, uint32_t segments)
{
    const std::vector<glm::vec2> circle = unit_circle(segments);
    const glm::vec3 top = base + glm::vec3{0.0f, height, 0.0f};
    for (size_t i = 0; i < circle.size(); ++i) {
        // Counter-clockwise seen from above, which turns z around.
        const glm::vec3 here{circle[i].x, 0.0f, -circle[i].y};
        const glm::vec2 next_point = circle[(i + 1) % circle.size()];
        const glm::vec3 next{next_point.x, 0.0f, -next_point.y};
        builder.quad(base + base_radius * here, base + base_radius * next, top + top_radius * next,
                     top + top_radius * here);
        if (top_radius > 0.0f) {
            builder.triangle(top, top + top_radius * here, top + top_radius * next);
        }
    }
}

Mesh MeshBuilder::take(std::string name, uint32_t item_triangles)
{
    Mesh mesh = std::exchange(mesh_, {});
    mesh.name = std::move(name);
    partition_mesh(mesh, item_triangles);
    return mesh;
}

} // namespace occlude::tools
