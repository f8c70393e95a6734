#include "generate/city_furniture.h"

#include <occlude/core/rng.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>

namespace occlude::tools {
namespace {

constexpr uint32_t kNoBottom = MeshBuilder::kAllFaces & ~MeshBuilder::kNegY;
constexpr size_t kLeastBudget = 40;

/// A vector of length at most 1, uniform in the ball.
glm::vec3 in_ball(Rng& rng)
{
    for (;;) {
        const glm::vec3 p{rng.range(-1.0f, 1.0f), rng.range(-1.0f, 1.0f), rng.range(-1.0f, 1.0f)};
        if (glm::dot(p, p) <= 1.0f) {
            return p;
        }
    }
}

void make_tree(MeshBuilder& builder, uint64_t seed, size_t budget)
{
    Rng rng(seed);
    const float trunk = rng.range(2.2f, 3.0f);
    const float crown = rng.range(1.5f, 2.1f);
    const glm::vec3 center{0.0f, trunk + 0.8f * crown, 0.0f};
    const uint32_t segments = budget >= 200 ? 8 : 4;
    upright_cylinder(builder, {0.0f, -0.05f, 0.0f}, trunk + 0.5f, 0.16f, 0.1f, segments);
    // A closed heart, so that the tree hides something, and leaves around it.
    const std::array<glm::vec3, 6> axes{{{1.0f, 0.0f, 0.0f},
                                         {0.0f, 0.0f, -1.0f},
                                         {-1.0f, 0.0f, 0.0f},
                                         {0.0f, 0.0f, 1.0f},
                                         {0.0f, 1.0f, 0.0f},
                                         {0.0f, -1.0f, 0.0f}}};
    for (size_t i = 0; i < 4; ++i) {
        const glm::vec3 a = center + 0.75f * crown * axes[i];
        const glm::vec3 b = center + 0.75f * crown * axes[(i + 1) % 4];
        builder.triangle(a, b, center + 0.75f * crown * axes[4]);
        builder.triangle(b, a, center + 0.75f * crown * axes[5]);
    }
    // The fewer leaves, the larger.
    const size_t leaves = (budget - builder.triangles()) / 2;
    const float size = leaves > 400 ? 0.22f : leaves > 80 ? 0.4f : 0.8f;
    for (size_t i = 0; i < leaves; ++i) {
        const glm::vec3 p = in_ball(rng);
        const glm::vec3 out = p * crown * (1.3f - 0.3f * glm::dot(p, p));
        const glm::vec3 u = size * in_ball(rng);
        const glm::vec3 v = size * in_ball(rng);
        const glm::vec3 at = center + out;
        builder.quad(at - u - v, at + u - v, at + u + v, at - u + v);
    }
}

/// A wheel: an upright disc with its axle along z.
void wheel(MeshBuilder& builder, const glm::vec3& center, float radius, uint32_t segments)
{
    constexpr float kHalfWidth = 0.1f;
    const std::vector<glm::vec2> circle = unit_circle(segments);
    for (size_t i = 0; i < circle.size(); ++i) {
        const glm::vec2 p = radius * circle[i];
        const glm::vec2 q = radius * circle[(i + 1) % circle.size()];
        const glm::vec3 side{0.0f, 0.0f, kHalfWidth};
        const glm::vec3 a = center + glm::vec3{p, 0.0f};
        const glm::vec3 b = center + glm::vec3{q, 0.0f};
        builder.quad(a + side, a - side, b - side, b + side);
        builder.triangle(center + side, a + side, b + side);
        builder.triangle(center - side, b - side, a - side);
    }
}

/// Rows of small boxes on a surface until the budget is spent: grilles, louvres, ribs.
void ribs(MeshBuilder& builder, const SurfaceFrame& frame, glm::vec2 low, glm::vec2 high,
          uint32_t count, size_t budget)
{
    const float pitch = (high.y - low.y) / static_cast<float>(count);
    for (uint32_t i = 0; i < count && builder.triangles() + 10 <= budget; ++i) {
        const float v = low.y + pitch * static_cast<float>(i);
        frame.relief(builder, {low.x, v, 0.0f}, {high.x, v + 0.5f * pitch, 0.02f});
    }
}

void make_car(MeshBuilder& builder, uint64_t seed, size_t budget)
{
    Rng rng(seed);
    const float roof = rng.range(1.35f, 1.65f);
    const float waist = 0.85f;
    builder.box({-2.1f, 0.25f, -0.88f}, {2.1f, waist, 0.88f});
    // The cabin, narrower above.
    const std::array<glm::vec3, 4> foot{
        {{-1.5f, waist, 0.8f}, {1.1f, waist, 0.8f}, {1.1f, waist, -0.8f}, {-1.5f, waist, -0.8f}}};
    const std::array<glm::vec3, 4> head{
        {{-1.1f, roof, 0.65f}, {0.4f, roof, 0.65f}, {0.4f, roof, -0.65f}, {-1.1f, roof, -0.65f}}};
    for (size_t i = 0; i < 4; ++i) {
        builder.quad(foot[i], foot[(i + 1) % 4], head[(i + 1) % 4], head[i]);
    }
    builder.quad(head[0], head[1], head[2], head[3]);
    const uint32_t segments = budget >= 2400 ? 32 : budget >= 700 ? 16 : 8;
    if (builder.triangles() + 16 * size_t{segments} <= budget) {
        for (float x : {-1.35f, 1.35f}) {
            for (float z : {-0.82f, 0.82f}) {
                wheel(builder, {x, 0.33f, z}, 0.33f, segments);
            }
        }
    }
    const auto detail = [&](const glm::vec3& low, const glm::vec3& high) {
        if (builder.triangles() + 12 <= budget) {
            builder.box(low, high);
        }
    };
    for (float z : {-0.7f, 0.45f}) {
        detail({2.08f, 0.55f, z}, {2.14f, 0.72f, z + 0.25f});   // head lights
        detail({-2.14f, 0.55f, z}, {-2.08f, 0.72f, z + 0.25f}); // tail lights
    }
    for (float z : {-1.0f, 0.86f}) {
        detail({0.75f, 0.9f, z}, {0.9f, 1.05f, z + 0.14f}); // mirrors
    }
    detail({2.05f, 0.3f, -0.8f}, {2.2f, 0.45f, 0.8f}); // bumpers
    detail({-2.2f, 0.3f, -0.8f}, {-2.05f, 0.45f, 0.8f});
    for (float x : {-0.95f, 0.05f}) {
        detail({x, 0.7f, 0.87f}, {x + 0.2f, 0.74f, 0.91f}); // handles
        detail({x, 0.7f, -0.91f}, {x + 0.2f, 0.74f, -0.87f});
    }
    const SurfaceFrame nose{
        {2.1f, 0.0f, 0.0f}, {0.0f, 0.0f, -1.0f}, {0.0f, 1.0f, 0.0f}, {1.0f, 0.0f, 0.0f}};
    ribs(builder, nose, {-0.4f, 0.5f}, {0.4f, 0.75f}, 12, budget);
    const SurfaceFrame top{
        {0.0f, roof, 0.0f}, {1.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -1.0f}, {0.0f, 1.0f, 0.0f}};
    ribs(builder, top, {-1.0f, -0.6f}, {0.3f, 0.6f}, 8, budget);
    // Seats and tread are where a rich budget goes.
    for (uint32_t i = 0; i < 120; ++i) {
        const std::vector<glm::vec2> circle = unit_circle(32);
        const glm::vec2 p = 0.33f * circle[i % 32];
        const float x = (i / 32) % 2 == 0 ? -1.35f : 1.35f;
        const float z = i / 64 == 0 ? -0.82f : 0.82f;
        const glm::vec3 at{x + p.x, 0.33f + p.y, z};
        detail(at - glm::vec3{0.02f, 0.02f, 0.09f}, at + glm::vec3{0.02f, 0.02f, 0.09f});
    }
}

void make_lamp(MeshBuilder& builder, size_t budget)
{
    const uint32_t segments = budget >= 400 ? 16 : budget >= 100 ? 8 : 4;
    upright_cylinder(builder, {0.0f, -0.05f, 0.0f}, 5.6f, 0.09f, 0.05f, segments);
    builder.box({-0.04f, 5.45f, 0.0f}, {0.04f, 5.55f, 1.2f});
    if (builder.triangles() + 12 <= budget) {
        builder.box({-0.15f, 5.35f, 0.9f}, {0.15f, 5.47f, 1.5f});
    }
    if (builder.triangles() + 3 * size_t{segments} <= budget) {
        upright_cylinder(builder, {0.0f, -0.02f, 0.0f}, 0.8f, 0.16f, 0.12f, segments);
    }
    for (float y = 1.0f; y < 5.0f && builder.triangles() + 3 * size_t{segments} <= budget;
         y += 0.5f) {
        upright_cylinder(builder, {0.0f, y, 0.0f}, 0.05f, 0.11f, 0.11f, segments);
    }
}

void make_bench(MeshBuilder& builder, size_t budget)
{
    for (float x : {-0.8f, 0.8f}) {
        builder.box({x - 0.04f, -0.05f, -0.25f}, {x + 0.04f, 0.42f, 0.25f}, kNoBottom);
    }
    const uint32_t slats = budget >= 140 ? 5 : 1;
    for (uint32_t i = 0; i < slats && builder.triangles() + 12 <= budget; ++i) {
        const float pitch = 0.5f / static_cast<float>(slats);
        const float z = -0.25f + pitch * static_cast<float>(i);
        builder.box({-0.9f, 0.42f, z}, {0.9f, 0.46f, z + 0.85f * pitch});
    }
    for (uint32_t i = 0; i < slats && builder.triangles() + 12 <= budget; ++i) {
        const float pitch = 0.4f / static_cast<float>(slats);
        const float y = 0.55f + pitch * static_cast<float>(i);
        builder.box({-0.9f, y, -0.3f}, {0.9f, y + 0.85f * pitch, -0.26f});
    }
}

void make_bin(MeshBuilder& builder, size_t budget)
{
    const uint32_t segments = budget >= 100 ? 16 : 8;
    upright_cylinder(builder, {0.0f, -0.05f, 0.0f}, 0.95f, 0.24f, 0.28f, segments);
    for (uint32_t i = 0; i < 16; ++i) {
        const glm::vec2 p = 0.27f * unit_circle(16)[i];
        if (builder.triangles() + 12 <= budget) {
            builder.box({p.x - 0.02f, 0.1f, p.y - 0.02f}, {p.x + 0.02f, 0.8f, p.y + 0.02f});
        }
    }
}

void make_sign(MeshBuilder& builder, uint64_t seed, size_t budget)
{
    upright_cylinder(builder, {0.0f, -0.05f, 0.0f}, 2.9f, 0.04f, 0.04f, 4);
    builder.box({-0.4f, 2.3f, 0.04f}, {0.4f, 2.8f, 0.07f});
    const SurfaceFrame face{{0.0f, 0.0f, 0.07f}};
    const auto lines = 3 + uniform_below(mix64(seed), 4);
    ribs(builder, face, {-0.35f, 2.35f}, {0.35f, 2.75f}, lines, budget);
}

} // namespace

size_t furniture_limit(Furniture kind)
{
    constexpr std::array<size_t, kFurnitureKinds> kLimits{4000, 2400, 700, 160, 240, 90};
    return kLimits[static_cast<uint32_t>(kind)];
}

Mesh make_furniture(Furniture kind, uint64_t seed, size_t budget, uint32_t item_triangles)
{
    MeshBuilder builder;
    budget = std::max(budget, kLeastBudget);
    switch (kind) {
    case Furniture::tree:
        make_tree(builder, seed, budget);
        return builder.take("tree", item_triangles);
    case Furniture::car:
        make_car(builder, seed, budget);
        return builder.take("car", item_triangles);
    case Furniture::lamp:
        make_lamp(builder, budget);
        return builder.take("lamp", item_triangles);
    case Furniture::bench:
        make_bench(builder, budget);
        return builder.take("bench", item_triangles);
    case Furniture::bin:
        make_bin(builder, budget);
        return builder.take("bin", item_triangles);
    case Furniture::sign:
        make_sign(builder, seed, budget);
        return builder.take("sign", item_triangles);
    }
    return {};
}

} // namespace occlude::tools
