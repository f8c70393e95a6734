// A model of spheres on a ground, its items, and a camera that looks at it.
#pragma once

#include "render/gl_renderer.h"

#include <occlude/core/rng.h>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace occlude::tools {

inline constexpr glm::ivec2 kSize{161, 97};

// A sphere of `bands` bands, each a part.
inline Mesh sphere(uint32_t bands, uint32_t sectors)
{
    Mesh mesh;
    mesh.name = "sphere";
    const float pi = std::numbers::pi_v<float>;
    for (uint32_t band = 0; band <= bands; ++band) {
        const float theta = pi * static_cast<float>(band) / static_cast<float>(bands);
        for (uint32_t sector = 0; sector <= sectors; ++sector) {
            const float phi = 2.0f * pi * static_cast<float>(sector) / static_cast<float>(sectors);
            const glm::vec3 p{std::sin(theta) * std::cos(phi), std::cos(theta),
                              std::sin(theta) * std::sin(phi)};
            mesh.positions.push_back(p);
            mesh.normals.push_back(p);
        }
    }
    for (uint32_t band = 0; band < bands; ++band) {
        MeshPart part;
        part.first_index = static_cast<uint32_t>(mesh.indices.size());
        for (uint32_t sector = 0; sector < sectors; ++sector) {
            const uint32_t a = band * (sectors + 1) + sector;
            const uint32_t b = a + sectors + 1;
            mesh.indices.insert(mesh.indices.end(), {a, a + 1, b, a + 1, b + 1, b});
        }
        part.index_count = static_cast<uint32_t>(mesh.indices.size()) - part.first_index;
        part.box = {glm::vec3{-1.0f}, glm::vec3{1.0f}};
        mesh.parts.push_back(part);
    }
    return mesh;
}

inline Mesh ground()
{
    Mesh mesh;
    mesh.name = "ground";
    mesh.positions = {{-20, 0, -20}, {20, 0, -20}, {20, 0, 20}, {-20, 0, 20}};
    mesh.normals.assign(4, {0, 1, 0});
    mesh.indices = {0, 2, 1, 0, 3, 2};
    mesh.parts = {{0, 6, {{-20, 0, -20}, {20, 0, 20}}}};
    return mesh;
}

// A ground with spheres on it: turned, stretched and mirrored ones.
inline SceneModel test_model()
{
    SceneModel model;
    model.name = "spheres";
    model.meshes = {ground(), sphere(6, 16), sphere(4, 8)};
    model.instances.push_back({"ground", 0, glm::mat4{1.0f}, {0.4f, 0.45f, 0.35f}});
    Rng rng(11);
    for (uint32_t i = 0; i < 40; ++i) {
        const glm::vec3 place{rng.range(-9.0f, 9.0f), rng.range(0.2f, 2.0f),
                              rng.range(-15.0f, 5.0f)};
        glm::mat4 world = glm::translate(glm::mat4{1.0f}, place);
        world = glm::rotate(world, rng.range(0.0f, 6.0f), glm::normalize(glm::vec3{1, 2, 3}));
        const float mirror = i % 3 == 0 ? -1.0f : 1.0f;
        world = glm::scale(world, {mirror * rng.range(0.3f, 1.2f), rng.range(0.3f, 1.2f), 0.8f});
        model.instances.push_back({"sphere " + std::to_string(i),
                                   1 + i % 2,
                                   world,
                                   {rng.range(0.1f, 0.9f), rng.range(0.1f, 0.9f), 0.3f}});
    }
    return model;
}

inline std::vector<SceneModel::Item> items_of(const SceneModel& model)
{
    std::vector<SceneModel::Item> items;
    for (uint32_t i = 0; i < model.instances.size(); ++i) {
        for (uint32_t p = 0; p < model.meshes[model.instances[i].mesh].parts.size(); ++p) {
            items.push_back({i, p});
        }
    }
    return items;
}

inline View test_view(glm::ivec2 size = kSize, ClipConvention convention = {})
{
    const float aspect = static_cast<float>(size.x) / static_cast<float>(size.y);
    glm::mat4 projection = glm::perspectiveRH_NO(1.0f, aspect, 0.1f, 100.0f);
    if (convention.range == DepthRange::zero_to_one) {
        // Near and far exchanged is reversed depth.
        projection = convention.order == DepthOrder::near_is_large
                         ? glm::perspectiveRH_ZO(1.0f, aspect, 100.0f, 0.1f)
                         : glm::perspectiveRH_ZO(1.0f, aspect, 0.1f, 100.0f);
    }
    return View::from_clip(
        projection * glm::lookAt(glm::vec3{0, 4, 10}, glm::vec3{0, 0.5f, -3}, glm::vec3{0, 1, 0}),
        size, convention);
}

} // namespace occlude::tools
