// Normals of meshes that come without, and joining what is equal.
//
// Meshes may be as large as memory allows, so no step keeps a normal per corner: corners are
// grouped by position, and the normals of one position are made at a time.
#include "model/index_table.h"
#include "model/mesh_tools.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <span>
#include <tuple>

namespace occlude::tools {
namespace {

constexpr float kSmoothCosine = 0.766f; // 40 degrees
/// A position with more triangles keeps their own normals, to limit the cost.
constexpr size_t kFanLimit = 64;

glm::vec3 direction_of(const glm::vec3& v)
{
    const float length = glm::length(v);
    return length > 0.0f ? v / length : glm::vec3{0.0f, 1.0f, 0.0f};
}

/// For every vertex the first one at the same position.
std::vector<uint32_t> first_at_position(std::span<const glm::vec3> positions)
{
    IndexTable table(positions.size());
    std::vector<uint32_t> first(positions.size());
    for (uint32_t i = 0; i < positions.size(); ++i) {
        const glm::vec3& p = positions[i];
        const bool equals_itself = p == p; // what is not a number must not fill the table
        first[i] = equals_itself
                       ? table.find_or_insert(hash_of(p), i,
                                              [&](uint32_t other) { return positions[other] == p; })
                       : i;
    }
    return first;
}

/// The corners of triangles, by where they are. A corner is an index into mesh.indices.
class Fans {
public:
    explicit Fans(const Mesh& mesh)
        : begin_(mesh.positions.size() + 1, 0)
        , corners_(mesh.indices.size())
    {
        const std::vector<uint32_t> place = first_at_position(mesh.positions);
        for (const uint32_t vertex : mesh.indices) {
            ++begin_[place[vertex]];
        }
        uint32_t sum = 0; // begin_[i] becomes where the fan of i ends ...
        for (uint32_t& begin : begin_) {
            sum += begin;
            begin = sum;
        }
        for (size_t corner = mesh.indices.size(); corner-- > 0;) { // ... then where it begins
            corners_[--begin_[place[mesh.indices[corner]]]] = static_cast<uint32_t>(corner);
        }
    }
    /// The corners at the position of a vertex, ascending; empty if an earlier vertex is there.
    std::span<const uint32_t> at(size_t vertex) const
    {
        return std::span{corners_}.subspan(begin_[vertex], begin_[vertex + 1] - begin_[vertex]);
    }
    size_t size() const { return begin_.size() - 1; }

private:
    std::vector<uint32_t> begin_;
    std::vector<uint32_t> corners_;
};

/// Twice the area of every triangle, along its normal.
std::vector<glm::vec3> area_normals(const Mesh& mesh)
{
    std::vector<glm::vec3> normals(mesh.indices.size() / 3);
    for (size_t t = 0; t < normals.size(); ++t) {
        const glm::vec3& a = mesh.positions[mesh.indices[3 * t]];
        const glm::vec3& b = mesh.positions[mesh.indices[3 * t + 1]];
        const glm::vec3& c = mesh.positions[mesh.indices[3 * t + 2]];
        normals[t] = glm::cross(b - a, c - a);
    }
    return normals;
}

/// The normal of a corner: of all triangles at its position that meet its own at less than 40
/// degrees.
glm::vec3 smooth_normal(std::span<const glm::vec3> areas, std::span<const uint32_t> fan,
                        uint32_t corner)
{
    const glm::vec3 own = direction_of(areas[corner / 3]);
    glm::vec3 sum{0.0f};
    if (fan.size() <= kFanLimit) {
        for (const uint32_t other : fan) {
            if (glm::dot(direction_of(areas[other / 3]), own) > kSmoothCosine) {
                sum += areas[other / 3];
            }
        }
    }
    const float length = glm::length(sum);
    return length > 0.0f ? sum / length : own;
}

struct CornerNormal {
    glm::vec3 normal;
    uint32_t corner;
};

/// Sets `same[corner]` to the first corner of the fan with an equal normal, and lists those.
void join_equal(std::vector<CornerNormal>& fan, std::vector<uint32_t>& same,
                std::vector<CornerNormal>& firsts)
{
    std::ranges::sort(fan, {}, [](const CornerNormal& c) {
        return std::tuple{c.normal.x, c.normal.y, c.normal.z, c.corner};
    });
    for (size_t i = 0; i < fan.size(); ++i) {
        if (i == 0 || fan[i].normal != fan[i - 1].normal) {
            firsts.push_back(fan[i]);
        }
        same[fan[i].corner] = firsts.back().corner;
    }
}

/// Gives every first corner a vertex, in the order of corners, and the others the same one.
void assign_vertices(Mesh& mesh, const std::vector<uint32_t>& same,
                     std::vector<CornerNormal>& firsts)
{
    std::ranges::sort(firsts, {}, &CornerNormal::corner);
    std::vector<glm::vec3> positions;
    positions.reserve(firsts.size());
    mesh.normals.clear();
    mesh.normals.reserve(firsts.size());
    for (const CornerNormal& first : firsts) {
        positions.push_back(mesh.positions[mesh.indices[first.corner]]);
        mesh.normals.push_back(first.normal);
    }
    mesh.positions = std::move(positions);
    uint32_t next = 0;
    for (size_t corner = 0; corner < mesh.indices.size(); ++corner) {
        mesh.indices[corner] = same[corner] == corner ? next++ : mesh.indices[same[corner]];
    }
}

} // namespace

void make_normals(Mesh& mesh)
{
    std::vector<uint32_t> same(mesh.indices.size()); // by corner: the first one like it
    std::vector<CornerNormal> firsts;
    {
        const std::vector<glm::vec3> areas = area_normals(mesh);
        const Fans fans(mesh);
        std::vector<CornerNormal> fan;
        for (size_t vertex = 0; vertex < fans.size(); ++vertex) {
            fan.clear();
            for (const uint32_t corner : fans.at(vertex)) {
                fan.push_back({smooth_normal(areas, fans.at(vertex), corner), corner});
            }
            join_equal(fan, same, firsts);
        }
    }
    assign_vertices(mesh, same, firsts);
}

void weld(Mesh& mesh)
{
    IndexTable table(mesh.positions.size());
    constexpr uint32_t kUnused = 0xffffffffu;
    std::vector<uint32_t> new_index(mesh.positions.size(), kUnused); // by first equal vertex
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;
    for (uint32_t& index : mesh.indices) {
        const glm::vec3& position = mesh.positions[index];
        const glm::vec3& normal = mesh.normals[index];
        const uint32_t first = table.find_or_insert(
            hash64(hash_of(position), hash_of(normal)), index, [&](uint32_t other) {
                return mesh.positions[other] == position && mesh.normals[other] == normal;
            });
        if (new_index[first] == kUnused) {
            new_index[first] = static_cast<uint32_t>(positions.size());
            positions.push_back(position);
            normals.push_back(normal);
        }
        index = new_index[first];
    }
    mesh.positions = std::move(positions);
    mesh.normals = std::move(normals);
}

} // namespace occlude::tools
