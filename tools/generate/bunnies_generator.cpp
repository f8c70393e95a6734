#include "generate/bunnies_generator.h"

#include "files/assets.h"
#include "generate/moving_generators.h"
#include "load/scene_loader.h"
#include "model/mesh_tools.h"

#include <fmt/format.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <map>
#include <set>

namespace occlude::tools {
namespace {

/// The mesh with all vertices in a cell of a grid of `cells` cells along the longest side joined.
Mesh clustered(const Mesh& mesh, uint32_t cells)
{
    Aabb box;
    for (const glm::vec3& p : mesh.positions) {
        box = merge(box, {p, p});
    }
    const glm::vec3 extent = box.extent();
    const float cell =
        std::max({extent.x, extent.y, extent.z}) / static_cast<float>(cells) * 1.0001f;
    std::map<std::array<int, 3>, uint32_t> cluster_at;
    std::vector<uint32_t> cluster_of;
    std::vector<uint32_t> members;
    Mesh result;
    result.name = mesh.name;
    for (const glm::vec3& p : mesh.positions) {
        const glm::ivec3 at{glm::floor((p - box.min) / cell)};
        const auto [found, is_new] = cluster_at.try_emplace(
            {at.x, at.y, at.z}, static_cast<uint32_t>(result.positions.size()));
        if (is_new) {
            result.positions.emplace_back(0.0f);
            members.push_back(0);
        }
        result.positions[found->second] += p;
        ++members[found->second];
        cluster_of.push_back(found->second);
    }
    for (size_t i = 0; i < members.size(); ++i) {
        result.positions[i] /= static_cast<float>(members[i]);
    }
    std::set<std::array<uint32_t, 3>> seen;
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        std::array<uint32_t, 3> corners{};
        for (size_t k = 0; k < 3; ++k) {
            corners[k] = cluster_of[mesh.indices[i + k]];
        }
        const auto& p = result.positions;
        const glm::vec3 one = p[corners[1]] - p[corners[0]];
        const glm::vec3 two = p[corners[2]] - p[corners[0]];
        const float longest = std::max(glm::dot(one, one), glm::dot(two, two));
        if (glm::length(glm::cross(one, two)) <= 1e-4f * longest) {
            continue; // has become a line or a point
        }
        std::array<uint32_t, 3> sorted = corners;
        std::sort(sorted.begin(), sorted.end());
        if (seen.insert(sorted).second) {
            result.indices.insert(result.indices.end(), corners.begin(), corners.end());
        }
    }
    make_normals(result);
    return result;
}

/// Moves the middle of the box to the origin and scales the farthest point to a distance of 1.
void fit_into_unit_sphere(Mesh& mesh)
{
    Aabb box;
    for (const glm::vec3& p : mesh.positions) {
        box = merge(box, {p, p});
    }
    const glm::vec3 middle = box.center();
    float farthest = 0.0f;
    for (const glm::vec3& p : mesh.positions) {
        farthest = std::max(farthest, glm::distance(p, middle));
    }
    for (glm::vec3& p : mesh.positions) {
        p = (p - middle) / farthest;
    }
}

} // namespace

void simplify(Mesh& mesh, uint64_t most_triangles)
{
    if (mesh.indices.size() / 3 <= most_triangles) {
        return;
    }
    uint32_t enough = 1; // cells
    uint32_t too_many = 1024;
    while (too_many - enough > 1) {
        const uint32_t middle = (enough + too_many) / 2;
        const bool fits = clustered(mesh, middle).indices.size() / 3 <= most_triangles;
        (fits ? enough : too_many) = middle;
    }
    mesh = clustered(mesh, enough);
}

Result<SceneModel> generate_bunnies(const BunniesOptions& options,
                                    const SceneOptions& scene_options)
{
    const auto file = find_asset("bunny/bunny.glb");
    if (!file) {
        return file.error();
    }
    auto bunny = load_scene_file(file->string());
    if (!bunny) {
        return bunny.error();
    }
    SceneModel model;
    model.name = fmt::format("bunnies:count={},triangles={},seed={}", options.count,
                             options.triangles, options.seed);
    Mesh& mesh = model.meshes.emplace_back(std::move(bunny->meshes.at(0)));
    mesh.name = "bunny";
    simplify(mesh, options.triangles);
    fit_into_unit_sphere(mesh);
    partition_mesh(mesh, std::max(scene_options.item_triangles, 1u));
    fill_crowd(model, options.count, options.seed, "bunny");
    return model;
}

} // namespace occlude::tools
