#include "generate/plant_shapes.h"

#include "generate/shapes.h"
#include "walk/path_tools.h"

#include <occlude/core/rng.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace occlude::tools::plant {

/// A wall of upright tubes side by side from x = -kIn to kIn in the plane z.
static void tube_wall(MeshBuilder& builder, const SurfaceFrame& frame, uint32_t tubes, float height)
{
    const float radius = kIn / static_cast<float>(tubes);
    for (uint32_t i = 0; i < tubes; ++i) {
        const float x = kIn * (2.0f * ratio(i, tubes) - 1.0f);
        const std::array<glm::vec3, 3> line{
            frame.at(x, 0.2f, 0.0f), frame.at(x, 0.55f * height, 0.0f), frame.at(x, height, 0.0f)};
        tube(builder, line, 1.01f * radius, 8);
    }
    for (const float y : {0.2f, 0.5f * height, height}) { // headers and a stiffening beam
        const std::array<glm::vec3, 2> line{frame.at(-kIn, y, 0.0f), frame.at(kIn, y, 0.0f)};
        tube(builder, line, std::max(0.14f, 1.1f * radius), 8);
    }
}

/// One tube to and fro in an upright plane.
static void serpentine(MeshBuilder& builder, float z, float radius, float half, float low,
                       float high, uint32_t passes)
{
    std::vector<glm::vec3> corners;
    for (uint32_t pass = 0; pass < passes; ++pass) {
        const float y = low + (high - low) * ratio(pass, passes);
        const float side = pass % 2 == 0 ? 1.0f : -1.0f;
        corners.push_back({-side * half, y, z});
        corners.push_back({side * half, y, z});
    }
    const std::vector<glm::vec3> line =
        rounded(corners, 0.5f * (high - low) / static_cast<float>(passes));
    tube(builder, line, radius, 8);
}

void make_boiler(MeshBuilder& builder, uint32_t elements)
{
    const uint32_t tubes = std::max(6u, elements);
    const float height = kUnder - 0.2f;
    for (uint32_t side = 0; side < 4; ++side) {
        const glm::mat4 turn = quarter_turned(side, glm::vec3{0.0f});
        const SurfaceFrame frame{glm::vec3{turn * glm::vec4{0.0f, 0.0f, kIn, 1.0f}},
                                 glm::vec3{turn[0]},
                                 {0.0f, 1.0f, 0.0f},
                                 glm::vec3{turn[2]}};
        tube_wall(builder, frame, tubes, height);
    }
    const uint32_t inner = std::max(1u, tubes / 8);
    for (uint32_t i = 0; i < inner; ++i) {
        serpentine(builder, 1.8f * (2.0f * ratio(i, inner) - 1.0f), 0.04f, 1.8f, 0.5f, height, 6);
    }
}

void make_bundle(MeshBuilder& builder, uint32_t elements)
{
    for (uint32_t i = 0; i < elements; ++i) {
        const float z = 2.1f * (2.0f * ratio(i, elements) - 1.0f);
        const float radius = std::min(0.06f, 1.6f / static_cast<float>(elements));
        serpentine(builder, z, radius, 2.0f, 0.5f, 4.0f, 8);
    }
    for (const float x : {-2.3f, 2.3f}) {
        for (const float z : {-2.3f, 2.3f}) {
            beam(builder, {x, 0.0f, z}, {x, 4.3f, z}, 0.2f);
        }
        beam(builder, {x, 4.2f, -2.3f}, {x, 4.2f, 2.3f}, 0.18f);
        beam(builder, {x, 0.3f, -2.3f}, {x, 0.3f, 2.3f}, 0.18f);
    }
}

void make_rack(MeshBuilder& builder, uint32_t elements, uint64_t seed)
{
    Rng rng(seed);
    const uint32_t levels = std::min(4u, 1 + elements / 6);
    for (uint32_t i = 0; i < elements; ++i) {
        const uint32_t level = i % levels;
        const uint32_t on_level = (elements + levels - 1) / levels;
        const float radius = std::min(rng.range(0.05f, 0.16f), 1.9f / static_cast<float>(on_level));
        const float z = 2.1f * (2.0f * ratio(i / levels, on_level) - 1.0f);
        const float y = 0.9f + 3.2f * ratio(level, levels) + radius;
        const float rise = rng.range(0.2f, 0.5f);
        const float bend = rng.range(-1.2f, 1.2f);
        const std::array<glm::vec3, 4> corners{glm::vec3{-kIn, y, z}, glm::vec3{bend, y, z},
                                               glm::vec3{bend, y + rise, z},
                                               glm::vec3{kIn, y + rise, z}};
        tube(builder, rounded(corners, 0.2f), radius, 16);
        flange(builder, {-1.9f, y, z}, {1.0f, 0.0f, 0.0f}, radius);
        flange(builder, {1.9f, y + rise, z}, {1.0f, 0.0f, 0.0f}, radius);
    }
    for (const float x : {-2.2f, 0.0f, 2.2f}) {
        for (const float z : {-2.3f, 2.3f}) {
            beam(builder, {x, 0.0f, z}, {x, 4.4f, z}, 0.22f);
        }
        for (uint32_t level = 0; level < levels; ++level) {
            const float y = 0.75f + 3.2f * ratio(level, levels);
            beam(builder, {x, y, -2.3f}, {x, y, 2.3f}, 0.18f);
        }
    }
}

/// Rings around a cylinder, as a profile to be turned.
static std::vector<glm::vec2> ringed(float radius, float low, float high, uint32_t rings)
{
    std::vector<glm::vec2> profile{{radius, low}};
    const float pitch = (high - low) / static_cast<float>(rings);
    for (uint32_t i = 0; i < rings; ++i) {
        const float y = low + pitch * static_cast<float>(i);
        profile.push_back({radius, y + 0.3f * pitch});
        profile.push_back({1.03f * radius, y + 0.4f * pitch});
        profile.push_back({1.03f * radius, y + 0.6f * pitch});
        profile.push_back({radius, y + 0.7f * pitch});
    }
    profile.push_back({radius, high});
    return profile;
}

static void ladder(MeshBuilder& builder, float x, float height, uint32_t rungs)
{
    for (const float z : {-0.22f, 0.22f}) {
        builder.box({x, 0.0f, z - 0.02f}, {x + 0.05f, height, z + 0.02f});
    }
    for (uint32_t i = 0; i < rungs; ++i) {
        const float y = height * ratio(i, rungs);
        rod(builder, {x + 0.025f, y, -0.2f}, {x + 0.025f, y, 0.2f}, 0.014f, 8);
    }
}

void make_vessel(MeshBuilder& builder, uint32_t elements, float radius, float height)
{
    std::vector<glm::vec2> profile = ringed(radius, 0.35f, 0.82f * height, elements);
    profile.insert(profile.begin(), {0.0f, 0.3f});
    profile.push_back({0.8f * radius, 0.9f * height});
    profile.push_back({0.45f * radius, 0.96f * height});
    profile.push_back({0.0f, 0.98f * height});
    turned(builder, glm::vec3{0.0f}, profile, 32);
    for (const glm::vec2& c : unit_circle(4)) {
        const glm::vec2 foot = 0.75f * radius * c;
        builder.box({foot.x - 0.15f, 0.0f, foot.y - 0.15f}, {foot.x + 0.15f, 0.4f, foot.y + 0.15f});
    }
    ladder(builder, 1.05f * radius, 0.9f * height, std::max(4u, elements));
}

void make_machine(MeshBuilder& builder, uint32_t elements)
{
    builder.box({-2.2f, 0.0f, -1.3f}, {2.2f, 0.5f, 1.3f});
    // The casing is turned about x: a tube whose ribs are rods of more than its radius.
    const float length = 4.0f;
    rod(builder, {-2.0f, 1.6f, 0.0f}, {2.0f, 1.6f, 0.0f}, 0.85f, 32);
    for (uint32_t i = 0; i < elements; ++i) {
        const float x = -2.0f + length * ratio(i, elements);
        const float thick = 0.25f * length / static_cast<float>(elements);
        const float radius = i % 3 == 0 ? 1.08f : 0.97f;
        rod(builder, {x - thick, 1.6f, 0.0f}, {x + thick, 1.6f, 0.0f}, radius, 32);
        if (i % 3 == 0) {
            for (const glm::vec2& c : unit_circle(8)) {
                const glm::vec3 bolt{x, 1.6f + 0.98f * c.x, 0.98f * c.y};
                rod(builder, bolt - glm::vec3{1.5f * thick, 0.0f, 0.0f},
                    bolt + glm::vec3{1.5f * thick, 0.0f, 0.0f}, 0.05f, 8);
            }
        }
    }
    for (const float x : {-1.5f, 1.5f}) {
        const std::array<glm::vec3, 3> corners{glm::vec3{x, 2.3f, 0.0f}, glm::vec3{x, 3.6f, 0.0f},
                                               glm::vec3{x, 3.6f, 2.2f}};
        tube(builder, rounded(corners, 0.5f), 0.25f, 16);
        builder.box({x - 0.3f, 0.5f, -0.8f}, {x + 0.3f, 1.2f, 0.8f});
    }
}

void make_trays(MeshBuilder& builder, uint32_t elements, uint64_t seed)
{
    constexpr uint32_t kTrays = 6;
    Rng rng(seed);
    const uint32_t per_tray = std::max(1u, elements / kTrays);
    for (uint32_t tray = 0; tray < kTrays; ++tray) {
        const float y = 0.5f + 0.65f * static_cast<float>(tray);
        for (const float z : {-1.2f, 1.2f}) {
            const float half = 0.6f;
            builder.box({-kIn, y, z - half}, {kIn, y + 0.01f, z + half});
            builder.box({-kIn, y, z - half}, {kIn, y + 0.12f, z - half + 0.02f});
            builder.box({-kIn, y, z + half - 0.02f}, {kIn, y + 0.12f, z + half});
        }
        for (uint32_t i = 0; i < per_tray; ++i) {
            const float radius = rng.range(0.008f, 0.03f);
            const float row = i % 2 == 0 ? -1.2f : 1.2f;
            const float z = row + 1.0f * ratio(i / 2, (per_tray + 1) / 2) - 0.5f;
            std::vector<glm::vec3> line;
            for (uint32_t k = 0; k <= 6; ++k) {
                line.push_back({kIn * (static_cast<float>(k) / 3.0f - 1.0f),
                                y + 0.012f + radius + rng.range(0.0f, 0.03f),
                                z + rng.range(-0.03f, 0.03f)});
            }
            tube(builder, line, radius, 8);
        }
    }
    for (const float x : {-2.0f, 0.0f, 2.0f}) {
        for (const float z : {-1.9f, 0.0f, 1.9f}) {
            beam(builder, {x, 0.0f, z}, {x, 4.4f, z}, 0.12f);
        }
    }
}

} // namespace occlude::tools::plant
