#include "generate/forest_generator.h"

#include "generate/shapes.h"
#include "walk/path_tools.h"

#include <occlude/core/rng.h>

#include <fmt/format.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

namespace occlude::tools {
namespace {

constexpr float kSpacing = 3.6f; // metres between trees, about
constexpr float kFreeWay = 3.2f; // between the walker and a trunk
constexpr float kEyeHeight = 1.7f;
constexpr float kGroundCell = 4.0f;
constexpr uint32_t kVariants = 6; // of each kind

/// Hills: smooth noise of 40 m and, less high, of 15 m.
float ground_height(uint64_t seed, float x, float z)
{
    float height = 0.0f;
    for (const auto& [length, high, salt] :
         {std::tuple{40.0f, 5.0f, 71ull}, std::tuple{15.0f, 0.9f, 73ull}}) {
        const float u = x / length;
        const float v = z / length;
        const float u0 = std::floor(u);
        const float v0 = std::floor(v);
        const auto at = [&, salt = salt](float i, float j) {
            return uniform01(hash64(seed, salt, static_cast<uint64_t>(static_cast<int64_t>(i)),
                                    static_cast<uint64_t>(static_cast<int64_t>(j))));
        };
        const auto smooth = [](float t) { return t * t * (3.0f - 2.0f * t); };
        const float s = smooth(u - u0);
        const float t = smooth(v - v0);
        const float low = (1.0f - s) * at(u0, v0) + s * at(u0 + 1.0f, v0);
        const float far = (1.0f - s) * at(u0, v0 + 1.0f) + s * at(u0 + 1.0f, v0 + 1.0f);
        height += high * ((1.0f - t) * low + t * far);
    }
    return height;
}

/// A direction in the plane, all alike likely.
glm::vec2 random_heading(Rng& rng)
{
    for (;;) {
        const float x = rng.range(-1.0f, 1.0f);
        const glm::vec2 v{x, rng.range(-1.0f, 1.0f)};
        const float square = glm::dot(v, v);
        if (square <= 1.0f && square > 0.05f) {
            return v / std::sqrt(square);
        }
    }
}

glm::vec3 random_in_ball(Rng& rng)
{
    for (;;) {
        const float x = rng.range(-1.0f, 1.0f);
        const float y = rng.range(-1.0f, 1.0f);
        const glm::vec3 v{x, y, rng.range(-1.0f, 1.0f)};
        const float square = glm::dot(v, v);
        if (square <= 1.0f && square > 0.05f) {
            return v;
        }
    }
}

/// A trunk that narrows to a point: 24 triangles.
void add_trunk(MeshBuilder& builder, float height, float radius)
{
    const std::array<glm::vec2, 3> profile{
        {{1.4f * radius, -0.5f}, {radius, 0.4f}, {0.0f, height}}};
    turned(builder, glm::vec3{0.0f}, profile, 8);
}

size_t left_of(size_t budget, const MeshBuilder& builder)
{
    return budget > builder.triangles() ? budget - builder.triangles() : 0;
}

/// Branches that grow close: hanging cones with ragged rims, one above the other, 8 triangles each.
void add_cones(MeshBuilder& builder, Rng& rng, float height, float reach, uint32_t cones)
{
    const std::vector<glm::vec2> circle = unit_circle(8);
    for (uint32_t i = 0; i < cones; ++i) {
        const float up = static_cast<float>(i) / static_cast<float>(cones);
        const float rim = 0.3f + (height - 0.3f) * up;
        const float tip = std::min(rim + 2.2f * height / static_cast<float>(cones), height);
        std::array<glm::vec3, 8> points;
        for (size_t k = 0; k < points.size(); ++k) {
            const float out = reach * (1.0f - up) * rng.range(0.75f, 1.05f);
            points[k] = {out * circle[k].x, rim + rng.range(-0.2f, 0.2f), out * circle[k].y};
        }
        for (size_t k = 0; k < points.size(); ++k) {
            builder.triangle(points[k], glm::vec3{0.0f, tip, 0.0f}, points[(k + 1) % 8]);
        }
    }
}

/// Twigs that hang out of the cones, two triangles each.
void add_twigs(MeshBuilder& builder, Rng& rng, float height, float reach, size_t twigs)
{
    for (size_t i = 0; i < twigs; ++i) {
        // More of them below, where the tree is wide.
        const float up = 1.0f - std::sqrt(1.0f - rng.range(0.0f, 0.995f));
        const glm::vec2 heading = random_heading(rng);
        const float out = reach * (1.0f - up) * rng.range(0.8f, 1.2f) + 0.15f;
        const float in = out * rng.range(0.3f, 0.7f);
        const float y = 0.5f + (height - 0.7f) * up;
        const float droop = rng.range(0.15f, 0.5f) * (out - in);
        const glm::vec3 along{heading.x, 0.0f, heading.y};
        const glm::vec3 aside =
            rng.range(0.12f, 0.32f) * glm::vec3{-heading.y, rng.range(-0.4f, 0.4f), heading.x};
        const glm::vec3 from = in * along + glm::vec3{0.0f, y, 0.0f};
        const glm::vec3 to = out * along + glm::vec3{0.0f, y - droop, 0.0f};
        const glm::vec3 middle = 0.5f * (from + to);
        builder.quad(from, middle - aside, to, middle + aside);
    }
}

Mesh make_spruce(uint64_t seed, size_t budget, uint32_t item_triangles)
{
    Rng rng(seed);
    const float height = rng.range(9.0f, 15.0f);
    const float reach = rng.range(1.8f, 2.4f);
    MeshBuilder builder;
    add_trunk(builder, height, 0.018f * height);
    const size_t cones = std::clamp(left_of(budget, builder) / 16, size_t{3}, size_t{9});
    add_cones(builder, rng, height, reach, static_cast<uint32_t>(cones));
    add_twigs(builder, rng, height, reach, left_of(budget, builder) / 2);
    return builder.take("spruce", item_triangles);
}

/// Foliage that grows close: a closed lump, 32 triangles.
void add_lump(MeshBuilder& builder, Rng& rng, const glm::vec3& middle, const glm::vec3& reach)
{
    const std::vector<glm::vec2> circle = unit_circle(8);
    const glm::vec3 bottom = middle - glm::vec3{0.0f, reach.y, 0.0f};
    const glm::vec3 top = middle + glm::vec3{0.0f, reach.y, 0.0f};
    std::array<std::array<glm::vec3, 8>, 2> rings;
    for (size_t ring = 0; ring < rings.size(); ++ring) {
        for (size_t k = 0; k < 8; ++k) {
            const float out = rng.range(0.75f, 1.0f);
            const float up = (ring == 0 ? -0.45f : 0.45f) + rng.range(-0.15f, 0.15f);
            rings[ring][k] = middle + reach * glm::vec3{out * circle[k].x, up, out * circle[k].y};
        }
    }
    for (size_t k = 0; k < 8; ++k) {
        const size_t next = (k + 1) % 8;
        builder.triangle(bottom, rings[0][k], rings[0][next]);
        builder.quad(rings[0][next], rings[0][k], rings[1][k], rings[1][next]);
        builder.triangle(rings[1][next], rings[1][k], top);
    }
}

Mesh make_broadleaf(uint64_t seed, size_t budget, uint32_t item_triangles)
{
    Rng rng(seed);
    const float height = rng.range(8.0f, 13.0f);
    MeshBuilder builder;
    add_trunk(builder, 0.8f * height, 0.022f * height);
    const glm::vec3 crown{0.0f, 0.55f * height, 0.0f};
    const glm::vec3 reach{rng.range(2.2f, 3.0f), 0.45f * height, rng.range(2.2f, 3.0f)};
    const size_t lumps = std::clamp(left_of(budget, builder) / 48, size_t{1}, size_t{4});
    for (size_t i = 0; i < lumps; ++i) {
        const glm::vec3 offset = lumps == 1 ? glm::vec3{0.0f} : 0.45f * random_in_ball(rng);
        add_lump(builder, rng, crown + reach * offset, (lumps == 1 ? 0.9f : 0.65f) * reach);
    }
    const size_t leaves = left_of(budget, builder) / 2;
    for (size_t i = 0; i < leaves; ++i) {
        const glm::vec3 at = crown + reach * random_in_ball(rng);
        const glm::vec3 along = glm::normalize(random_in_ball(rng));
        const Across plane = across(along);
        const glm::vec3 half = rng.range(0.15f, 0.35f) * along;
        const glm::vec3 aside = rng.range(0.1f, 0.22f) * plane.first;
        builder.quad(at - half, at - aside, at + half, at + aside);
    }
    return builder.take("broad-leaved tree", item_triangles);
}

class Forest {
public:
    Forest(const ForestOptions& options, uint32_t item_triangles)
        : options_(options)
        , item_triangles_(item_triangles)
    {
        while (side_ * side_ < options.trees) {
            ++side_;
        }
        half_ = 0.5f * kSpacing * static_cast<float>(side_);
    }

    SceneModel generate()
    {
        model_.name = fmt::format("forest:triangles={},trees={},seed={}", options_.triangles,
                                  options_.trees, options_.seed);
        lay_out_way();
        Mesh ground = make_ground();
        const uint64_t ground_triangles = ground.indices.size() / 3;
        const uint64_t left =
            options_.triangles > ground_triangles ? options_.triangles - ground_triangles : 0;
        const auto budget = static_cast<size_t>(left / options_.trees);
        for (uint32_t i = 0; i < kVariants; ++i) {
            model_.meshes.push_back(
                make_spruce(hash64(options_.seed, i, 79), budget, item_triangles_));
        }
        for (uint32_t i = 0; i < kVariants; ++i) {
            model_.meshes.push_back(
                make_broadleaf(hash64(options_.seed, i, 83), budget, item_triangles_));
        }
        plant();
        model_.instances.push_back({"ground", static_cast<uint32_t>(model_.meshes.size()),
                                    glm::mat4{1.0f}, glm::vec3{0.34f, 0.30f, 0.18f}});
        model_.meshes.push_back(std::move(ground));
        const WalkStyle style{.look_ahead = 6.0f};
        model_.paths = {{"walk", walk_along(way_, style)}};
        return std::move(model_);
    }

private:
    float height_at(float x, float z) const { return ground_height(options_.seed, x, z); }

    void lay_out_way()
    {
        constexpr std::array<glm::vec2, 6> kTurns{{{-0.8f, -0.3f},
                                                   {-0.35f, 0.25f},
                                                   {0.05f, -0.2f},
                                                   {0.3f, 0.3f},
                                                   {0.7f, 0.1f},
                                                   {0.75f, -0.7f}}};
        std::vector<glm::vec3> corners;
        for (const glm::vec2& turn : kTurns) {
            corners.emplace_back(half_ * turn.x, 0.0f, half_ * turn.y);
        }
        way_ = resampled(rounded(corners, 0.25f * half_), 1.0f);
        for (glm::vec3& point : way_) {
            point.y = height_at(point.x, point.z) + kEyeHeight;
        }
    }

    bool is_free(float x, float z) const
    {
        return std::all_of(way_.begin(), way_.end(), [&](const glm::vec3& on_way) {
            const float dx = on_way.x - x;
            const float dz = on_way.z - z;
            return dx * dx + dz * dz > kFreeWay * kFreeWay;
        });
    }

    /// One tree per cell of a grid, moved about in it, and off the way.
    void plant()
    {
        Rng rng(hash64(options_.seed, 89));
        for (uint64_t i = 0; i < options_.trees; ++i) {
            const float column = static_cast<float>(i % side_);
            const float row = static_cast<float>(i / side_);
            float x = 0.0f;
            float z = 0.0f;
            float room = 0.38f; // of a cell, to either side; more if the way runs through it
            do {
                x = kSpacing * (column + 0.5f + rng.range(-room, room)) - half_;
                z = kSpacing * (row + 0.5f + rng.range(-room, room)) - half_;
                room += 0.02f;
            } while (!is_free(x, z));
            const glm::vec2 heading = random_heading(rng);
            glm::mat4 world = turned_about_y(heading.x, heading.y, {x, height_at(x, z), z});
            const float size = rng.range(0.8f, 1.15f);
            for (int axis = 0; axis < 3; ++axis) {
                world[axis] *= size;
            }
            const uint32_t mesh = rng.below(2 * kVariants);
            const float light = rng.range(0.75f, 1.2f);
            const glm::vec3 green =
                mesh < kVariants ? glm::vec3{0.13f, 0.30f, 0.16f} : glm::vec3{0.32f, 0.44f, 0.14f};
            model_.instances.push_back({fmt::format("tree {}", i), mesh, world, light * green});
        }
    }

    Mesh make_ground() const
    {
        const auto cells = static_cast<uint32_t>(2.0f * (half_ + 20.0f) / kGroundCell);
        const float low = -0.5f * kGroundCell * static_cast<float>(cells);
        Mesh mesh;
        mesh.name = "ground";
        for (uint32_t row = 0; row <= cells; ++row) {
            for (uint32_t column = 0; column <= cells; ++column) {
                const float x = low + kGroundCell * static_cast<float>(column);
                const float z = low + kGroundCell * static_cast<float>(row);
                mesh.positions.emplace_back(x, height_at(x, z), z);
            }
        }
        for (uint32_t row = 0; row < cells; ++row) {
            for (uint32_t column = 0; column < cells; ++column) {
                const uint32_t a = row * (cells + 1) + column;
                const uint32_t below = a + cells + 1;
                mesh.indices.insert(mesh.indices.end(), {a, below, below + 1, a, below + 1, a + 1});
            }
        }
        make_normals(mesh);
        partition_mesh(mesh, item_triangles_);
        return mesh;
    }

    ForestOptions options_;
    uint32_t item_triangles_;
    uint64_t side_ = 1; ///< trees along a side
    float half_ = 0.0f;
    std::vector<glm::vec3> way_;
    SceneModel model_;
};

} // namespace

SceneModel generate_forest(const ForestOptions& options, const SceneOptions& scene_options)
{
    return Forest(options, std::max(scene_options.item_triangles, 1u)).generate();
}

} // namespace occlude::tools
