// Normals for meshes without, and joining equal vertices, against what they mean.
#include "model/mesh_tools.h"

#include <occlude/core/rng.h>

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <cmath>
#include <cstdint>
#include <set>
#include <tuple>
#include <vector>

#include <sys/resource.h>

namespace occlude::tools {
namespace {

constexpr float kSmoothCosine = 0.766f; // 40 degrees, as mesh_tools.h says

/// Triangles over few points, so that many meet at each; vertices repeat points.
Mesh crumpled_mesh(uint64_t seed, uint32_t points, uint32_t triangles)
{
    Rng rng(seed);
    std::vector<glm::vec3> place;
    for (uint32_t i = 0; i < points; ++i) {
        place.push_back(
            {rng.range(-1.0f, 1.0f), 0.2f * rng.range(-1.0f, 1.0f), rng.range(-1.0f, 1.0f)});
    }
    Mesh mesh;
    for (uint32_t t = 0; t < triangles; ++t) {
        const auto a = static_cast<uint32_t>(rng.below(points));
        for (const uint32_t corner : {a, (a + 1) % points, (a + 2 + t % 3) % points}) {
            const auto count = static_cast<uint32_t>(mesh.positions.size());
            uint32_t vertex = 0;
            while (vertex < count && mesh.positions[vertex] != place[corner]) {
                ++vertex;
            }
            if (vertex == count || t % 2 == 0) { // every other triangle has its own vertices
                vertex = count;
                mesh.positions.push_back(place[corner]);
            }
            mesh.indices.push_back(vertex);
        }
    }
    return mesh;
}

glm::vec3 area_normal(const Mesh& mesh, size_t t)
{
    const auto corner = [&](size_t k) { return mesh.positions[mesh.indices[3 * t + k]]; };
    return glm::cross(corner(1) - corner(0), corner(2) - corner(0));
}

bool has_corner_at(const Mesh& mesh, size_t t, const glm::vec3& p)
{
    return mesh.positions[mesh.indices[3 * t]] == p ||
           mesh.positions[mesh.indices[3 * t + 1]] == p ||
           mesh.positions[mesh.indices[3 * t + 2]] == p;
}

glm::vec3 expected_normal(const Mesh& mesh, size_t corner)
{
    const glm::vec3 own = glm::normalize(area_normal(mesh, corner / 3));
    glm::vec3 sum{0.0f};
    for (size_t t = 0; t < mesh.indices.size() / 3; ++t) {
        const glm::vec3 area = area_normal(mesh, t);
        if (has_corner_at(mesh, t, mesh.positions[mesh.indices[corner]]) &&
            glm::dot(glm::normalize(area), own) > kSmoothCosine) {
            sum += area;
        }
    }
    return glm::normalize(sum);
}

size_t different_vertices(const Mesh& mesh)
{
    std::set<std::tuple<float, float, float, float, float, float>> seen;
    for (const uint32_t i : mesh.indices) {
        const glm::vec3& p = mesh.positions[i];
        const glm::vec3& n = mesh.normals[i];
        seen.insert({p.x, p.y, p.z, n.x, n.y, n.z});
    }
    return seen.size();
}

TEST(MakeNormals, AreThoseOfAllTrianglesThatMeetSmoothly)
{
    constexpr uint64_t kSeed = 7;
    const Mesh flat = crumpled_mesh(kSeed, 40, 150);
    Mesh mesh = flat;
    make_normals(mesh);
    ASSERT_EQ(mesh.indices.size(), flat.indices.size());
    size_t smoothed = 0;
    for (size_t corner = 0; corner < mesh.indices.size(); ++corner) {
        EXPECT_EQ(mesh.positions[mesh.indices[corner]], flat.positions[flat.indices[corner]]);
        const glm::vec3 normal = mesh.normals[mesh.indices[corner]];
        EXPECT_LT(glm::distance(normal, expected_normal(flat, corner)), 1e-4f)
            << "corner " << corner;
        smoothed +=
            glm::distance(normal, glm::normalize(area_normal(flat, corner / 3))) > 1e-3f ? 1 : 0;
    }
    EXPECT_EQ(mesh.positions.size(), different_vertices(mesh)) << "equal vertices are joined";
    EXPECT_EQ(mesh.normals.size(), mesh.positions.size());
    EXPECT_GT(smoothed, mesh.indices.size() / 10) << "seed " << kSeed << " proves nothing";
    EXPECT_LT(smoothed, mesh.indices.size()) << "seed " << kSeed << " proves nothing";
}

TEST(MakeNormals, OfAHugeFanAreTheTrianglesOwn)
{
    Mesh fan;
    fan.positions.push_back({0.0f, 1.0f, 0.0f});
    constexpr uint32_t kTriangles = 100;
    for (uint32_t i = 0; i <= kTriangles; ++i) {
        const float angle = 6.28318f * static_cast<float>(i) / kTriangles;
        fan.positions.push_back({std::cos(angle), 0.9f, std::sin(angle)});
    }
    for (uint32_t i = 1; i <= kTriangles; ++i) {
        fan.indices.insert(fan.indices.end(), {0, i, i + 1});
    }
    const Mesh before = fan;
    make_normals(fan);
    for (size_t t = 0; t < kTriangles; ++t) {
        EXPECT_LT(
            glm::distance(fan.normals[fan.indices[3 * t]], glm::normalize(area_normal(before, t))),
            1e-5f);
    }
}

TEST(Weld, JoinsEqualVerticesInTheOrderOfTheirUse)
{
    Mesh mesh;
    mesh.positions = {{9, 9, 9}, {1, 0, 0}, {0, 0, 0}, {0, 1, 0}, {-0.0f, 0, 0}, {0, 0, 0}};
    mesh.normals = {{0, 1, 0}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 1, 0}};
    mesh.indices = {2, 1, 3, 4, 3, 5};
    weld(mesh);
    EXPECT_EQ(mesh.indices, (std::vector<uint32_t>{0, 1, 2, 0, 2, 3}))
        << "vertex 0 is not used, 4 equals 2, and 5 has another normal";
    EXPECT_EQ(mesh.positions[1], glm::vec3(1, 0, 0));
    EXPECT_EQ(mesh.normals[3], glm::vec3(0, 1, 0));
}

long peak_memory_bytes()
{
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss * 1024;
}

TEST(MakeNormals, TakeMemoryNearTheSizeOfTheMesh)
{
    constexpr uint32_t kSide = 600;
    Mesh mesh;
    mesh.positions.reserve(size_t{kSide} * kSide);
    for (uint32_t i = 0; i < kSide * kSide; ++i) {
        mesh.positions.emplace_back(i % kSide, std::sin(0.01f * static_cast<float>(i)), i / kSide);
    }
    for (uint32_t i = 0; i + kSide + 1 < kSide * kSide; ++i) {
        mesh.indices.insert(mesh.indices.end(), {i, i + kSide, i + 1});
    }
    const auto size = static_cast<long>(2 * sizeof(glm::vec3) * mesh.positions.size() +
                                        sizeof(uint32_t) * mesh.indices.size());
    const long before = peak_memory_bytes();
    make_normals(mesh);
    EXPECT_LT(peak_memory_bytes() - before, 4 * size) << "a mesh of " << size << " bytes";
}

} // namespace
} // namespace occlude::tools
