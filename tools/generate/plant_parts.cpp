#include "generate/plant_parts.h"

#include "generate/shapes.h"
#include "walk/path_tools.h"

#include <occlude/core/rng.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace occlude::tools {
namespace {

constexpr float kIn = kPlantInner;
constexpr float kBay = 0.5f * kPlantPitch;
constexpr float kUnder = kPlantFloor - 0.45f; // where the beams of the floor above begin

float ratio(uint32_t i, uint32_t count)
{
    return (static_cast<float>(i) + 0.5f) / static_cast<float>(count);
}

/// An upright or level I-beam between two points: flanges along `side`.
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

/// A wall of upright tubes side by side from x = -kIn to kIn in the plane z.
void tube_wall(MeshBuilder& builder, const SurfaceFrame& frame, uint32_t tubes, float height)
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
void serpentine(MeshBuilder& builder, float z, float radius, float half, float low, float high,
                uint32_t passes)
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
std::vector<glm::vec2> ringed(float radius, float low, float high, uint32_t rings)
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

void ladder(MeshBuilder& builder, float x, float height, uint32_t rungs)
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

/// A rail at hand height with posts and a knee rail, along x.
void railing(MeshBuilder& builder, const glm::vec3& from, const glm::vec3& to, uint32_t posts)
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

} // namespace

Mesh make_plant_part(PlantPart part, uint32_t elements, uint64_t seed)
{
    constexpr uint32_t kWhole = 0xffffffffu;
    MeshBuilder builder;
    switch (part) {
    case PlantPart::boiler:
        make_boiler(builder, elements);
        break;
    case PlantPart::bundle:
        make_bundle(builder, elements);
        break;
    case PlantPart::rack:
        make_rack(builder, elements, seed);
        break;
    case PlantPart::vessel:
        make_vessel(builder, elements, 1.9f, 4.4f);
        break;
    case PlantPart::machine:
        make_machine(builder, elements);
        break;
    case PlantPart::trays:
        make_trays(builder, elements, seed);
        break;
    case PlantPart::stairs:
        make_stairs(builder, elements);
        break;
    case PlantPart::grating:
        make_grating(builder, elements);
        break;
    case PlantPart::frame:
        make_frame(builder, elements);
        break;
    case PlantPart::cladding:
        make_cladding(builder, elements);
        break;
    case PlantPart::pipework:
        make_pipework(builder, elements, seed);
        break;
    case PlantPart::tank:
    case PlantPart::count:
        make_vessel(builder, elements, 4.5f, 9.0f);
        break;
    }
    return builder.take(plant_part_name(part), kWhole);
}

float plant_part_weight(PlantPart part)
{
    constexpr std::array<float, static_cast<size_t>(PlantPart::count)> kWeights{
        2.5f, 2.5f, 2.0f, 1.0f, 1.2f, 2.0f, 1.0f, 0.7f, 0.4f, 0.3f, 1.5f, 1.0f};
    return kWeights[static_cast<size_t>(part)];
}

const char* plant_part_name(PlantPart part)
{
    constexpr std::array<const char*, static_cast<size_t>(PlantPart::count)> kNames{
        "boiler", "tube bundle", "pipe rack", "vessel",   "machine",  "cable trays",
        "stairs", "grating",     "frame",     "cladding", "pipework", "tank"};
    return kNames[static_cast<size_t>(part)];
}

} // namespace occlude::tools
