#include "generate/hollow_generators.h"

#include "model/mesh_tools.h"

#include <occlude/core/rng.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace occlude::tools {
namespace {

constexpr float kEyeHeight = 1.7f;

glm::vec3 random_color(Rng& rng)
{
    const float red = rng.range(0.3f, 0.85f);
    const float green = rng.range(0.3f, 0.8f);
    return {red, green, rng.range(0.2f, 0.7f)};
}

/// A square pyramid of base and height 1 on y = 0, without its bottom: each side in n^2 triangles.
Mesh make_pyramid(uint64_t triangles, uint32_t item_triangles)
{
    uint32_t steps = 1;
    while (4ull * (steps + 1) * (steps + 1) <= triangles) {
        ++steps;
    }
    MeshBuilder builder;
    const glm::vec3 top{0.0f, 1.0f, 0.0f};
    constexpr std::array<glm::vec3, 4> kBase{
        {{-0.5f, 0.0f, 0.5f}, {0.5f, 0.0f, 0.5f}, {0.5f, 0.0f, -0.5f}, {-0.5f, 0.0f, -0.5f}}};
    for (size_t side = 0; side < 4; ++side) {
        const glm::vec3& left = kBase[side];
        const glm::vec3& right = kBase[(side + 1) % 4];
        const auto at = [&](uint32_t row, uint32_t i) { // row 0 is the top
            const float down = static_cast<float>(row) / static_cast<float>(steps);
            const float along = static_cast<float>(i) / static_cast<float>(steps);
            return top + down * (left - top) + along * (right - left);
        };
        for (uint32_t row = 0; row < steps; ++row) {
            for (uint32_t i = 0; i <= row; ++i) {
                builder.triangle(at(row, i), at(row + 1, i), at(row + 1, i + 1));
                if (i < row) {
                    builder.triangle(at(row, i), at(row + 1, i + 1), at(row, i + 1));
                }
            }
        }
    }
    Mesh mesh = builder.take("pyramid", item_triangles);
    weld(mesh);
    return mesh;
}

/// A ring around the z axis of radius 3 and thickness 0.5.
Mesh make_ring(uint64_t triangles, uint32_t item_triangles)
{
    constexpr float kRadius = 3.0f;
    constexpr float kThin = 0.25f;
    uint32_t around = 4;
    while (around < 16 && 16ull * around * around <= triangles) {
        around *= 2;
    }
    const std::vector<glm::vec2> large = unit_circle(std::min(2 * around, 32u));
    const std::vector<glm::vec2> small = unit_circle(around);
    const auto at = [&](size_t i, size_t k) {
        const glm::vec2& c = large[i % large.size()];
        const glm::vec2& s = small[k % small.size()];
        const float radius = kRadius + kThin * s.x;
        return glm::vec3{radius * c.x, radius * c.y, kThin * s.y};
    };
    MeshBuilder builder;
    for (size_t i = 0; i < large.size(); ++i) {
        for (size_t k = 0; k < small.size(); ++k) {
            builder.quad(at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1));
        }
    }
    Mesh mesh = builder.take("ring", item_triangles);
    make_normals(mesh);
    return mesh;
}

/// Sideways from one end to the other, looking along -z and a little to and fro.
SceneModel::NamedPath pass(float half, float eye_y, float z)
{
    constexpr uint32_t kSteps = 24;
    SceneModel::NamedPath path{"pass", {}};
    for (uint32_t i = 0; i <= kSteps; ++i) {
        const float share = static_cast<float>(i) / static_cast<float>(kSteps);
        const float sway = 4.0f * share * (1.0f - share) - 0.5f; // -0.5 .. 0.5 .. -0.5
        Keyframe key{2.0f * static_cast<float>(i), {}, false};
        key.camera.eye = {half * (2.0f * share - 1.0f), eye_y, z};
        key.camera.target = key.camera.eye + glm::vec3{4.0f * sway, 0.1f, -10.0f};
        path.keys.push_back(key);
    }
    return path;
}

void add_plain(SceneModel& model, float half, uint32_t item_triangles)
{
    MeshBuilder builder;
    builder.box({-half, -1.0f, -half}, {half, 0.0f, half});
    model.instances.push_back({"plain", static_cast<uint32_t>(model.meshes.size()), glm::mat4{1.0f},
                               glm::vec3{0.45f, 0.42f, 0.36f}});
    model.meshes.push_back(builder.take("plain", item_triangles));
}

/// The smallest number whose square is at least `count`.
uint64_t square_side(uint64_t count)
{
    uint64_t side = 1;
    while (side * side < count) {
        ++side;
    }
    return side;
}

std::string name_of(std::string_view kind, const HollowOptions& options)
{
    return fmt::format("{}:count={},triangles={},seed={}", kind, options.count, options.triangles,
                       options.seed);
}

} // namespace

SceneModel generate_pyramids(const HollowOptions& options, const SceneOptions& scene_options)
{
    constexpr float kPitch = 11.0f; // of pyramids 8 to 10.5 wide
    const uint32_t item_triangles = std::max(scene_options.item_triangles, 1u);
    SceneModel model;
    model.name = name_of("pyramids", options);
    model.meshes.push_back(make_pyramid(options.triangles, item_triangles));
    const uint64_t side = square_side(options.count);
    const float half = 0.5f * kPitch * static_cast<float>(side);
    Rng rng(hash64(options.seed, 61));
    for (uint64_t i = 0; i < options.count; ++i) {
        const float width = rng.range(8.0f, 10.5f);
        glm::mat4 world{1.0f};
        world[0][0] = width;
        world[1][1] = rng.range(8.0f, 12.0f);
        world[2][2] = width;
        world[3] = {kPitch * (static_cast<float>(i % side) + 0.5f) - half, 0.0f,
                    half - kPitch * (static_cast<float>(i / side) + 0.5f), 1.0f};
        model.instances.push_back({fmt::format("pyramid {}", i), 0, world, random_color(rng)});
    }
    add_plain(model, half + 30.0f, item_triangles);
    model.paths = {pass(0.8f * half, kEyeHeight, half + 9.0f)};
    return model;
}

SceneModel generate_rings(const HollowOptions& options, const SceneOptions& scene_options)
{
    constexpr uint64_t kBundle = 8;
    constexpr float kPitch = 7.5f;
    constexpr float kGap = 0.6f; // between the rings of a bundle
    const uint32_t item_triangles = std::max(scene_options.item_triangles, 1u);
    SceneModel model;
    model.name = name_of("rings", options);
    model.meshes.push_back(make_ring(options.triangles, item_triangles));
    const uint64_t side = square_side((options.count + kBundle - 1) / kBundle);
    const float half = 0.5f * kPitch * static_cast<float>(side);
    Rng rng(hash64(options.seed, 67));
    for (uint64_t i = 0; i < options.count; ++i) {
        const uint64_t bundle = i / kBundle;
        glm::mat4 world{1.0f};
        world[3] = {kPitch * (static_cast<float>(bundle % side) + 0.5f) - half, 3.3f,
                    half - kPitch * (static_cast<float>(bundle / side) + 0.5f) -
                        kGap * static_cast<float>(i % kBundle),
                    1.0f};
        model.instances.push_back({fmt::format("ring {}", i), 0, world, random_color(rng)});
    }
    add_plain(model, half + 30.0f, item_triangles);
    model.paths = {pass(0.8f * half, 3.3f, half + 14.0f)};
    return model;
}

} // namespace occlude::tools
