#include "generate/plant_shapes.h"

#include "generate/shapes.h"
#include "walk/path_tools.h"

#include <occlude/core/rng.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace occlude::tools::plant {

void beam(MeshBuilder& builder, const glm::vec3& from, const glm::vec3& to, float depth)
{
    const glm::vec3 low = glm::min(from, to);
    const glm::vec3 high = glm::max(from, to);
    const glm::vec3 way = high - low;
    const float half = 0.5f * depth;
    const float thin = 0.06f * depth;
    if (way.y > way.x && way.y > way.z) {
        builder.box({low.x - half, low.y, low.z - half},
                    {low.x + half, high.y, low.z - half + thin});
        builder.box({low.x - half, low.y, low.z + half - thin},
                    {low.x + half, high.y, low.z + half});
        builder.box({low.x - thin, low.y, low.z - half + thin},
                    {low.x + thin, high.y, low.z + half - thin},
                    MeshBuilder::kNegX | MeshBuilder::kPosX);
        return;
    }
    const glm::vec3 wide =
        way.x > way.z ? glm::vec3{0.0f, 0.0f, half} : glm::vec3{half, 0.0f, 0.0f};
    const glm::vec3 web = wide * (thin / half);
    const glm::vec3 up{0.0f, half, 0.0f};
    const glm::vec3 flange{0.0f, thin, 0.0f};
    builder.box(low - wide - up, high + wide - up + flange);
    builder.box(low - wide + up - flange, high + wide + up);
    builder.box(low - web - up + flange, high + web + up - flange);
}

/// A flange with bolts around a pipe.
void flange(MeshBuilder& builder, const glm::vec3& at, const glm::vec3& way, float radius)
{
    rod(builder, at - 0.03f * way, at + 0.03f * way, 1.7f * radius, 16);
    const Across plane = across(way);
    for (const glm::vec2& c : unit_circle(8)) {
        const glm::vec3 bolt = at + 1.4f * radius * (c.x * plane.first + c.y * plane.second);
        rod(builder, bolt - 0.06f * way, bolt + 0.06f * way, 0.12f * radius, 4);
    }
}

/// A rail at hand height with posts and a knee rail, along x.
static void railing(MeshBuilder& builder, const glm::vec3& from, const glm::vec3& to,
                    uint32_t posts)
{
    const glm::vec3 up{0.0f, 1.1f, 0.0f};
    rod(builder, from + up, to + up, 0.025f, 8);
    rod(builder, from + 0.5f * up, to + 0.5f * up, 0.02f, 8);
    for (uint32_t i = 0; i < posts; ++i) {
        const glm::vec3 at = from + (to - from) * ratio(i, posts);
        rod(builder, at, at + up, 0.02f, 8);
    }
}

void make_stairs(MeshBuilder& builder, uint32_t elements)
{
    constexpr uint32_t kSteps = 12; // of each of two flights
    const uint32_t bars = std::max(2u, elements);
    for (uint32_t flight = 0; flight < 2; ++flight) {
        const float side = flight == 0 ? -1.0f : 1.0f;
        const float base = flight == 0 ? 0.0f : 0.5f * kPlantFloor;
        const glm::vec3 start{-1.6f * -side, base, side * 0.75f};
        const glm::vec3 end{1.6f * -side, base + 0.5f * kPlantFloor - 0.1f, side * 0.75f};
        for (uint32_t step = 0; step < kSteps; ++step) {
            const glm::vec3 at = start + (end - start) * ratio(step, kSteps);
            for (uint32_t bar = 0; bar < bars; ++bar) {
                const float x = at.x + 0.26f * ratio(bar, bars) - 0.13f;
                builder.box({x - 0.06f / static_cast<float>(bars), at.y, at.z - 0.5f},
                            {x + 0.06f / static_cast<float>(bars), at.y + 0.03f, at.z + 0.5f});
            }
        }
        for (const float z : {start.z - 0.55f, start.z + 0.55f}) {
            const glm::vec3 low{start.x, start.y, z};
            const glm::vec3 high{end.x, end.y, z};
            rod(builder, low, high, 0.08f, 4); // the string
            railing(builder, low, high, 6);
        }
        builder.box({end.x - 0.6f, end.y, -1.3f}, {end.x + 0.6f, end.y + 0.04f, 1.3f});
    }
}

void make_grating(MeshBuilder& builder, uint32_t elements)
{
    constexpr uint32_t kMostBars = 200;
    const uint32_t bars = std::clamp(elements, 8u, kMostBars);
    const uint32_t pieces = std::max(1u, elements / kMostBars);
    const float top = 0.0f;
    const float step = kPlantPitch / static_cast<float>(pieces);
    const float thick = 0.3f * kPlantPitch / static_cast<float>(bars);
    for (uint32_t i = 0; i < bars; ++i) {
        const float z = kBay * (2.0f * ratio(i, bars) - 1.0f);
        for (uint32_t piece = 0; piece < pieces; ++piece) {
            const float x = -kBay + step * static_cast<float>(piece);
            builder.box({x, top - 0.04f, z - 0.5f * thick}, {x + step, top, z + 0.5f * thick},
                        MeshBuilder::kPosY | MeshBuilder::kNegY | MeshBuilder::kNegZ |
                            MeshBuilder::kPosZ);
        }
    }
    for (uint32_t i = 0; i < 8; ++i) {
        const float x = kBay * (2.0f * ratio(i, 8) - 1.0f);
        builder.box({x - 0.02f, top - 0.08f, -kBay}, {x + 0.02f, top - 0.041f, kBay});
    }
}

void make_frame(MeshBuilder& builder, uint32_t elements)
{
    const float column = kIn + 0.25f;
    for (const float x : {-column, column}) {
        for (const float z : {-column, column}) {
            beam(builder, {x, 0.0f, z}, {x, kPlantFloor - 0.09f, z}, 0.3f);
            const uint32_t stiffeners = elements;
            for (uint32_t i = 0; i < stiffeners; ++i) {
                const float y = 0.1f + 4.3f * ratio(i, stiffeners);
                const float half = std::min(0.01f, 0.5f / static_cast<float>(stiffeners));
                builder.box({x - 0.145f, y - half, z - 0.13f}, {x + 0.145f, y + half, z + 0.13f});
            }
        }
        beam(builder, {x, kUnder + 0.15f, -kBay}, {x, kUnder + 0.15f, kBay}, 0.3f);
        beam(builder, {-kBay, kUnder + 0.15f, x}, {kBay, kUnder + 0.15f, x}, 0.28f);
    }
}

void make_cladding(MeshBuilder& builder, uint32_t elements)
{
    const uint32_t ribs = std::max(4u, elements);
    const float pitch = kPlantPitch / static_cast<float>(ribs);
    const float deep = std::min(0.06f, 0.4f * pitch);
    for (uint32_t i = 0; i < ribs; ++i) {
        const float x = -kBay + pitch * static_cast<float>(i);
        const std::array<glm::vec2, 5> line{{{x, 0.0f},
                                             {x + 0.2f * pitch, 0.0f},
                                             {x + 0.4f * pitch, deep},
                                             {x + 0.8f * pitch, deep},
                                             {x + pitch, 0.0f}}};
        for (size_t k = 1; k < line.size(); ++k) {
            const glm::vec2& a = line[k - 1];
            const glm::vec2& b = line[k];
            builder.quad({a.x, 0.0f, a.y}, {b.x, 0.0f, b.y}, {b.x, kPlantFloor, b.y},
                         {a.x, kPlantFloor, a.y});
        }
    }
    beam(builder, {-kBay, 0.5f * kPlantFloor, -0.15f}, {kBay, 0.5f * kPlantFloor, -0.15f}, 0.2f);
}

void make_pipework(MeshBuilder& builder, uint32_t elements, uint64_t seed)
{
    Rng rng(seed);
    for (uint32_t i = 0; i < elements; ++i) {
        const float radius = rng.range(0.025f, 0.12f);
        const uint32_t turn = rng.below(4);
        const glm::mat4 world = quarter_turned(turn, glm::vec3{0.0f});
        // In at one side, up or down and aside a few times, out at the other.
        std::vector<glm::vec3> corners;
        glm::vec3 at{-kBay, rng.range(2.9f, kUnder - 0.15f), rng.range(-kBay + 0.2f, kBay - 0.2f)};
        corners.push_back(at);
        while (at.x < kBay - 1.2f) {
            at.x += rng.range(0.5f, 2.0f);
            corners.push_back(at);
            if (rng.below(2) == 0) {
                at.y = std::clamp(at.y + (rng.below(2) == 0 ? 0.5f : -0.5f), 2.8f, kUnder - 0.1f);
            }
            const float aside = rng.below(2) == 0 ? 0.7f : -0.7f;
            at.z = std::abs(at.z + aside) < kBay - 0.2f ? at.z + aside : at.z - aside;
            corners.push_back(at);
        }
        at.x = kBay;
        corners.push_back(at);
        std::vector<glm::vec3> line = rounded(corners, 0.18f);
        for (glm::vec3& point : line) {
            point = glm::vec3{world * glm::vec4{point, 1.0f}};
        }
        tube(builder, line, radius, 8);
        const glm::vec3 way{world[0]};
        flange(builder, line.front() + 0.12f * way, way, radius);
    }
}

} // namespace occlude::tools::plant
