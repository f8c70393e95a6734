// What the tests of the CPU device draw: small scenes in pixels, random scenes, views in every
// convention.
#pragma once

#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/core/rng.h>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <utility>
#include <vector>

namespace occlude::test {

struct TestMesh {
    std::vector<glm::vec3> positions;
    std::vector<uint32_t> indices;
    glm::mat4 world_from_mesh{1.0f};
};

class TestScene : public CpuScene {
public:
    CpuItem item(ItemId id) const override
    {
        if (id.value >= meshes.size()) {
            return {};
        }
        const TestMesh& mesh = meshes[id.value];
        return {mesh.positions, mesh.indices, mesh.world_from_mesh, Aabb::everything()};
    }

    ItemId add(TestMesh mesh)
    {
        meshes.push_back(std::move(mesh));
        return ItemId{meshes.size() - 1};
    }

    // One triangle, corners in pixels and window depth: for views from pixel_view().
    ItemId add_triangle(glm::vec3 a, glm::vec3 b, glm::vec3 c)
    {
        return add({{a, b, c}, {0, 1, 2}});
    }

    // Two triangles that share the diagonal from (low.x, low.y) to (high.x, high.y).
    ItemId add_rectangle(glm::vec2 low, glm::vec2 high, float depth)
    {
        return add({{{low.x, low.y, depth},
                     {high.x, low.y, depth},
                     {high.x, high.y, depth},
                     {low.x, high.y, depth}},
                    {0, 1, 2, 0, 2, 3}});
    }

    std::vector<ItemId> all() const
    {
        std::vector<ItemId> ids;
        for (size_t i = 0; i < meshes.size(); ++i) {
            ids.push_back(ItemId{i});
        }
        return ids;
    }

    std::vector<TestMesh> meshes;
};

constexpr ClipConvention kOpenGl{DepthRange::minus_one_to_one, DepthOrder::near_is_small};
constexpr ClipConvention kConventions[] = {
    kOpenGl,
    {DepthRange::minus_one_to_one, DepthOrder::near_is_large},
    {DepthRange::zero_to_one, DepthOrder::near_is_small},
    {DepthRange::zero_to_one, DepthOrder::near_is_large},
};

// World coordinates are pixels and window depth: an orthographic view, exact for powers of two.
inline View pixel_view(glm::ivec2 size)
{
    const glm::vec2 scale = 2.0f / glm::vec2{size};
    glm::mat4 clip{1.0f};
    clip[0][0] = scale.x;
    clip[1][1] = scale.y;
    clip[3] = {-1.0f, -1.0f, 0.0f, 1.0f};
    return View::from_clip(clip, size, {DepthRange::zero_to_one, DepthOrder::near_is_small});
}

inline View perspective_view(glm::vec3 eye, glm::vec3 target, glm::ivec2 size,
                             ClipConvention convention, float near = 0.1f, float far = 100.0f)
{
    const float aspect = static_cast<float>(size.x) / static_cast<float>(size.y);
    if (convention.order == DepthOrder::near_is_large) {
        std::swap(near, far);
    }
    const float fov_y = glm::radians(60.0f);
    const glm::mat4 projection = convention.range == DepthRange::minus_one_to_one
                                     ? glm::perspectiveRH_NO(fov_y, aspect, near, far)
                                     : glm::perspectiveRH_ZO(fov_y, aspect, near, far);
    const glm::mat4 camera = glm::lookAt(eye, target, glm::vec3{0.0f, 1.0f, 0.0f});
    return View::from_clip(projection * camera, size, convention);
}

inline void draw_frame(CpuDevice& device, const View& view, const std::vector<ItemId>& items)
{
    device.begin_frame(view);
    device.draw(items, DrawPass::shade);
    device.end_frame();
}

inline size_t covered(const CpuDevice& device)
{
    return static_cast<size_t>(std::count_if(device.depth().begin(), device.depth().end(),
                                             [](float depth) { return depth < 1.0f; }));
}

inline size_t owned_by(const CpuDevice& device, ItemId item)
{
    size_t count = 0;
    for (size_t pixel = 0; pixel < device.depth().size(); ++pixel) {
        count += device.owner(pixel).item == item ? 1 : 0;
    }
    return count;
}

inline glm::vec3 random_point(Rng& rng, float extent)
{
    const float x = rng.range(-extent, extent);
    const float y = rng.range(-extent, extent);
    const float z = rng.range(-extent, extent);
    return {x, y, z};
}

inline glm::mat4 random_transform(Rng& rng)
{
    glm::mat4 m = glm::translate(glm::mat4{1.0f}, random_point(rng, 6.0f));
    const glm::vec3 axis = random_point(rng, 1.0f) + glm::vec3{0.0f, 1.5f, 0.0f};
    m = glm::rotate(m, rng.range(0.0f, 6.2f), glm::normalize(axis));
    const float scale = rng.range(0.3f, 1.5f);
    const float mirror = rng.below(2) == 0 ? -1.0f : 1.0f;
    return glm::scale(m, {mirror * scale, scale * rng.range(0.5f, 2.0f), scale});
}

// A flat axis-aligned wall that fills its box, of up to 8 x 8 cells: the vertices along its sides
// are snapped one by one, while its box has only the corners.
inline TestMesh random_wall(Rng& rng)
{
    TestMesh mesh;
    const glm::vec3 low = random_point(rng, 6.0f);
    const float side = rng.range(0.5f, 5.0f);
    const int axis_u = static_cast<int>(rng.below(3));
    const int axis_v = (axis_u + 1) % 3;
    const uint32_t cells = 1 + rng.below(8);
    for (uint32_t v = 0; v <= cells; ++v) {
        for (uint32_t u = 0; u <= cells; ++u) {
            glm::vec3 p = low;
            p[axis_u] += side * static_cast<float>(u) / static_cast<float>(cells);
            p[axis_v] += side * static_cast<float>(v) / static_cast<float>(cells);
            mesh.positions.push_back(p);
            if (u < cells && v < cells) {
                const uint32_t i = v * (cells + 1) + u;
                const uint32_t above = i + cells + 1;
                mesh.indices.insert(mesh.indices.end(), {i, i + 1, above + 1, i, above + 1, above});
            }
        }
    }
    return mesh;
}

// Clusters, needles, walls and specks of about a pixel.
inline TestMesh random_mesh(Rng& rng)
{
    TestMesh mesh;
    const uint32_t kind = rng.below(8);
    if (kind == 0) {
        return random_wall(rng);
    }
    mesh.world_from_mesh = random_transform(rng);
    const float extent = kind <= 3 ? rng.range(0.004f, 0.02f) : 1.0f;
    const uint32_t triangles = 1 + rng.below(6);
    for (uint32_t i = 0; i < 3 * triangles; ++i) {
        glm::vec3 p = random_point(rng, extent);
        if (kind == 4) {
            p.x *= 0.01f;
        }
        mesh.positions.push_back(p);
        mesh.indices.push_back(i);
    }
    return mesh;
}

inline TestScene random_scene(Rng& rng, int meshes)
{
    TestScene scene;
    for (int i = 0; i < meshes; ++i) {
        scene.add(random_mesh(rng));
    }
    return scene;
}

} // namespace occlude::test
