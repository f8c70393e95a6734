#include "load/clean_mesh.h"

#include "model/index_table.h"
#include "model/mesh_tools.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace occlude::tools {
namespace {

bool usable(const glm::vec3& v)
{
    // Written so that NaN answers false.
    return std::abs(v.x) <= kLargestCoordinate && std::abs(v.y) <= kLargestCoordinate &&
           std::abs(v.z) <= kLargestCoordinate;
}

/// For every vertex the first one at the same position.
std::vector<uint32_t> first_at_position(const std::vector<glm::vec3>& positions)
{
    IndexTable table(positions.size());
    std::vector<uint32_t> first(positions.size());
    for (uint32_t i = 0; i < positions.size(); ++i) {
        if (!usable(positions[i])) { // equals nothing, so it must not fill the table
            first[i] = i;
            continue;
        }
        first[i] = table.find_or_insert(hash_of(positions[i]), i, [&](uint32_t other) {
            return positions[other] == positions[i];
        });
    }
    return first;
}

using Places = std::array<uint32_t, 3>;

Places sorted(Places places)
{
    std::sort(places.begin(), places.end());
    return places;
}

/// Whether two triangles over the same three different points have the same side out.
bool same_side_out(const Places& a, const Places& b)
{
    return (b[0] == a[0] && b[1] == a[1]) || (b[0] == a[1] && b[1] == a[2]) ||
           (b[0] == a[2] && b[1] == a[0]);
}

/// The kept triangles of a mesh, to find those that repeat one of them.
class KnownTriangles {
public:
    explicit KnownTriangles(size_t most)
        : table_(most)
    {
        triangles_.reserve(most);
    }
    /// Whether an earlier triangle lies over the same points; counts it.
    bool repeats_one(const Places& places, LoadedMesh& counts)
    {
        const Places key = sorted(places);
        const auto candidate = static_cast<uint32_t>(triangles_.size());
        const uint32_t found =
            table_.find_or_insert(hash64(key[0], key[1], key[2]), candidate,
                                  [&](uint32_t i) { return sorted(triangles_[i]) == key; });
        if (found == candidate) {
            triangles_.push_back(places);
            return false;
        }
        const bool same = same_side_out(triangles_[found], places);
        ++(same ? counts.repeated : counts.backs);
        return same;
    }

private:
    IndexTable table_;
    std::vector<Places> triangles_;
};

/// Keeps the triangles that can be drawn, in their order.
void drop_bad_triangles(LoadedMesh& mesh, Repeats repeats)
{
    const std::vector<uint32_t> place = first_at_position(mesh.positions);
    const size_t count = mesh.indices.size() / 3;
    KnownTriangles known(count);
    size_t kept = 0;
    for (size_t t = 0; t < count; ++t) {
        const uint32_t corners[3] = {mesh.indices[3 * t], mesh.indices[3 * t + 1],
                                     mesh.indices[3 * t + 2]};
        if (!usable(mesh.positions[corners[0]]) || !usable(mesh.positions[corners[1]]) ||
            !usable(mesh.positions[corners[2]])) {
            ++mesh.left_out.non_finite;
            continue;
        }
        const Places places{place[corners[0]], place[corners[1]], place[corners[2]]};
        if (places[0] == places[1] || places[1] == places[2] || places[2] == places[0]) {
            ++mesh.left_out.degenerate;
            continue;
        }
        if (known.repeats_one(places, mesh) && repeats == Repeats::drop) {
            continue;
        }
        std::copy(corners, corners + 3, mesh.indices.begin() + static_cast<std::ptrdiff_t>(kept));
        kept += 3;
    }
    mesh.indices.resize(kept);
}

void normalize_all(std::vector<glm::vec3>& normals)
{
    for (glm::vec3& normal : normals) {
        const float length = glm::length(normal);
        const bool has_direction = length > 0.0f && length <= kLargestCoordinate;
        normal = has_direction ? normal / length : glm::vec3{0.0f, 1.0f, 0.0f};
    }
}

} // namespace

Mesh clean_mesh(LoadedMesh& source, Repeats repeats)
{
    const size_t triangles = source.indices.size();
    drop_bad_triangles(source, repeats);
    Mesh mesh;
    mesh.name = std::move(source.name);
    mesh.indices = std::move(source.indices);
    if (mesh.indices.empty()) {
        source.positions = {};
        source.normals = {};
        return mesh;
    }
    const bool has_normals = !source.normals.empty();
    mesh.positions = std::move(source.positions);
    mesh.normals = std::move(source.normals);
    mesh.indices.shrink_to_fit();
    if (!has_normals) {
        make_normals(mesh);
        return mesh;
    }
    normalize_all(mesh.normals);
    const bool every_corner_alone = mesh.positions.size() >= mesh.indices.size();
    if (every_corner_alone || mesh.indices.size() < triangles) {
        weld(mesh); // also drops vertices that only dropped triangles used
    }
    return mesh;
}

} // namespace occlude::tools
