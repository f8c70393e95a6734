#include "generate/moving_generators.h"

#include "model/mesh_tools.h"

#include <occlude/core/rng.h>

#include <fmt/format.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace occlude::tools {
namespace {

constexpr float kHalfCube = 35.0f; // metres, of the movers

glm::vec3 random_point(Rng& rng, float half)
{
    const float x = rng.range(-half, half);
    const float y = rng.range(-half, half);
    return {x, y, rng.range(-half, half)};
}

glm::vec3 random_direction(Rng& rng)
{
    glm::vec3 point = random_point(rng, 1.0f);
    while (glm::dot(point, point) > 1.0f || glm::dot(point, point) < 0.01f) {
        point = random_point(rng, 1.0f);
    }
    return glm::normalize(point);
}

glm::vec3 random_color(Rng& rng)
{
    const float red = rng.range(0.2f, 0.9f);
    const float green = rng.range(0.2f, 0.9f);
    return {red, green, rng.range(0.2f, 0.9f)};
}

/// Where the surface of a blob is in a direction: bumps that fade with the angle to their middle.
struct Bump {
    glm::vec3 direction;
    float height = 0.0f;
    int sharpness = 1; ///< how many times the cosine is squared
};

std::vector<Bump> random_bumps(Rng& rng)
{
    constexpr int kBumps = 6;
    std::vector<Bump> bumps{{glm::normalize(glm::vec3{0.35f, 1.0f, 0.0f}), 0.7f, 6},
                            {glm::normalize(glm::vec3{-0.35f, 1.0f, 0.0f}), 0.7f, 6}};
    for (int i = 0; i < kBumps; ++i) {
        const glm::vec3 direction = random_direction(rng);
        bumps.push_back({direction, rng.range(0.05f, 0.3f), 2});
    }
    return bumps;
}

glm::vec3 on_blob(std::span<const Bump> bumps, const glm::vec3& direction)
{
    float radius = 1.0f;
    for (const Bump& bump : bumps) {
        float share = std::max(glm::dot(direction, bump.direction), 0.0f);
        for (int i = 0; i < bump.sharpness; ++i) {
            share *= share;
        }
        radius += bump.height * share;
    }
    return radius * direction;
}

/// Scales the farthest point to a distance of 1.
void fit_into_unit_sphere(std::vector<glm::vec3>& positions)
{
    float farthest = 0.0f;
    for (const glm::vec3& position : positions) {
        farthest = std::max(farthest, glm::length(position));
    }
    for (glm::vec3& position : positions) {
        position /= farthest;
    }
}

/// One of the six faces of a cube of side 2, cut into steps x steps squares, as part of a blob.
void add_cube_face(Mesh& mesh, std::span<const Bump> bumps, int face, uint32_t steps)
{
    const int axis = face / 2;
    const float side = face % 2 == 0 ? 1.0f : -1.0f;
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    for (uint32_t row = 0; row <= steps; ++row) {
        for (uint32_t column = 0; column <= steps; ++column) {
            glm::vec3 point;
            point[axis] = side;
            point[(axis + 1) % 3] =
                2.0f * static_cast<float>(column) / static_cast<float>(steps) - 1.0f;
            point[(axis + 2) % 3] =
                2.0f * static_cast<float>(row) / static_cast<float>(steps) - 1.0f;
            mesh.positions.push_back(on_blob(bumps, glm::normalize(point)));
        }
    }
    for (uint32_t row = 0; row < steps; ++row) {
        for (uint32_t column = 0; column < steps; ++column) {
            const uint32_t a = first + row * (steps + 1) + column;
            const uint32_t d = a + steps + 1;
            const uint32_t b = side > 0.0f ? a + 1 : d;
            const uint32_t c = side > 0.0f ? d : a + 1;
            mesh.indices.insert(mesh.indices.end(), {a, b, c, d + 1, c, b});
        }
    }
}

/// Once around the cube, so near that it fills the view.
SceneModel::NamedPath path_orbit(float half)
{
    constexpr uint32_t kSteps = 32;
    SceneModel::NamedPath path{"orbit", {}};
    const std::vector<glm::vec2> circle = unit_circle(kSteps);
    for (uint32_t i = 0; i <= kSteps; ++i) {
        const glm::vec2 at = 2.7f * half * circle[i % kSteps];
        Camera camera;
        camera.eye = {at.x, 0.6f * half, at.y};
        camera.target = glm::vec3{0.0f};
        path.keys.push_back({static_cast<float>(i), camera, false});
    }
    return path;
}

/// A third of the orbit: in as many frames, at a third of its pace.
SceneModel::NamedPath path_pass(float half)
{
    SceneModel::NamedPath path = path_orbit(half);
    path.name = "pass";
    path.keys.resize(path.keys.size() / 3 + 1);
    return path;
}

/// Through the middle of the cube, from corner to corner, in a loop.
SceneModel::NamedPath path_inside(float half)
{
    SceneModel::NamedPath path{"inside", {}};
    const glm::vec3 stations[] = {{0.5f, 0.3f, 0.5f},   {-0.5f, -0.2f, 0.4f}, {-0.4f, 0.1f, -0.5f},
                                  {0.4f, -0.3f, -0.4f}, {0.5f, 0.3f, 0.5f},   {-0.5f, -0.2f, 0.4f}};
    for (size_t i = 0; i + 1 < std::size(stations); ++i) {
        Camera camera;
        camera.eye = half * stations[i];
        camera.target = half * stations[i + 1];
        path.keys.push_back({static_cast<float>(i), camera, false});
    }
    return path;
}

InstanceMotion random_motion(Rng& rng, float slowest, float fastest, float most_spin)
{
    InstanceMotion motion;
    const glm::vec3 direction = random_direction(rng);
    motion.velocity = rng.range(slowest, fastest) * direction;
    const glm::vec3 axis = random_direction(rng);
    motion.spin = rng.range(0.1f * most_spin, most_spin) * axis;
    return motion;
}

/// Comes and goes: present for a third to two thirds of a period of 24 to 120 frames.
void make_passing(InstanceMotion& motion, Rng& rng)
{
    motion.period = 24 + rng.below(97);
    motion.present = motion.period / 3 + rng.below(motion.period / 3);
    motion.phase = rng.below(motion.period);
}

glm::vec3 random_size(Rng& rng, bool slab)
{
    glm::vec3 size{rng.range(0.5f, 3.0f), rng.range(0.5f, 3.0f), rng.range(0.5f, 3.0f)};
    if (slab) { // large and thin: what hides others
        size.x += 9.0f;
        size.y += 6.0f;
        size.z *= 0.2f;
    }
    return size;
}

} // namespace

Mesh make_blob(uint64_t seed, uint64_t triangles, uint32_t item_triangles)
{
    Rng rng(seed);
    const std::vector<Bump> bumps = random_bumps(rng);
    uint32_t steps = 1; // 12 triangles for one
    while (12ull * (steps + 1) * (steps + 1) <= triangles) {
        ++steps;
    }
    Mesh mesh;
    mesh.name = fmt::format("blob {}", seed);
    for (int face = 0; face < 6; ++face) {
        add_cube_face(mesh, bumps, face, steps);
    }
    fit_into_unit_sphere(mesh.positions);
    make_normals(mesh);
    partition_mesh(mesh, item_triangles);
    return mesh;
}

SceneModel generate_movers(const MoversOptions& options, const SceneOptions& scene_options)
{
    constexpr uint32_t kLumps = 4;
    SceneModel model;
    model.name = fmt::format("movers:count={},seed={},triangles={}", options.count, options.seed,
                             options.triangles);
    MeshBuilder builder;
    builder.box(glm::vec3{-0.5f}, glm::vec3{0.5f});
    model.meshes.push_back(builder.take("box", scene_options.item_triangles));
    // Every third object is a lump and gets what the boxes leave of the triangles.
    const uint64_t lumps = std::max<uint64_t>(options.count / 3, 1);
    const uint64_t boxes_take = 12 * (options.count - lumps);
    const uint64_t left = options.triangles > boxes_take ? options.triangles - boxes_take : 0;
    for (uint32_t i = 0; i < kLumps; ++i) {
        model.meshes.push_back(
            make_blob(hash64(options.seed, i), left / lumps, scene_options.item_triangles));
    }
    model.motion.box = {glm::vec3{-kHalfCube}, glm::vec3{kHalfCube}};
    Rng rng(options.seed);
    for (uint32_t i = 0; i < options.count; ++i) {
        const bool lump = i % 3 == 2;
        const glm::vec3 size = random_size(rng, i % 6 == 1);
        glm::mat4 world_from_mesh{1.0f};
        for (int axis = 0; axis < 3; ++axis) {
            world_from_mesh[axis][axis] = lump ? size.x : size[axis];
        }
        world_from_mesh[3] = glm::vec4{random_point(rng, kHalfCube), 1.0f};
        model.instances.push_back({fmt::format("mover {}", i), lump ? 1 + rng.below(kLumps) : 0,
                                   world_from_mesh, random_color(rng)});
        InstanceMotion motion = random_motion(rng, 0.02f, 0.2f, 0.03f);
        if (i % 4 == 3) {
            make_passing(motion, rng);
        }
        model.motion.instances.push_back(motion);
    }
    model.paths = {path_orbit(kHalfCube), path_inside(kHalfCube)};
    return model;
}

void fill_crowd(SceneModel& model, uint64_t count, uint64_t seed, const std::string& name)
{
    // Metres between middles, of things 2 m across: so dense that one part in eight is seen from
    // outside (bunnies in parts of 1000 triangles), as published: 2584 of 22,344.
    constexpr float kSpacing = 0.65f;
    uint64_t side = 1;
    while (side * side * side < count) {
        ++side;
    }
    const float half = 0.5f * kSpacing * static_cast<float>(side);
    model.motion.box = {glm::vec3{-half}, glm::vec3{half}};
    Rng rng(seed);
    for (uint64_t i = 0; i < count; ++i) {
        glm::mat4 world_from_mesh{1.0f};
        world_from_mesh[3] = glm::vec4{random_point(rng, half), 1.0f};
        model.instances.push_back(
            {fmt::format("{} {}", name, i), 0, world_from_mesh, random_color(rng)});
        model.motion.instances.push_back(random_motion(rng, 0.005f, 0.03f, 0.0f));
    }
    model.paths = {path_orbit(half), path_inside(half), path_pass(half)};
}

SceneModel generate_blobs(const BlobsOptions& options, const SceneOptions& scene_options)
{
    SceneModel model;
    model.name = fmt::format("blobs:count={},seed={},triangles={}", options.count, options.seed,
                             options.triangles);
    model.meshes.push_back(
        make_blob(options.seed, options.triangles, scene_options.item_triangles));
    fill_crowd(model, options.count, options.seed, "blob");
    return model;
}

} // namespace occlude::tools
