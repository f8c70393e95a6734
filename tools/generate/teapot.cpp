// The control points are M. Newell's ("The Utilization of Procedure Models in Digital Image
// Synthesis", University of Utah, 1975) in the form in which they are commonly published (F. Crow,
// "The Origins of the Teapot", IEEE CG&A 7(1), 1987). Of the 32 patches most are mirror images of
// others, so they are written here as what they are: rings of a turned body, and halves of the
// handle and the spout.
#include "generate/teapot.h"

#include "model/mesh_tools.h"

#include <array>
#include <span>

namespace occlude::tools {
namespace {

using Patch = std::array<glm::vec3, 16>; // four rows of four control points

/// A circle around the axis, as four quarter curves with the control points (radius, 0),
/// (radius, bulge), (bulge, radius), (0, radius).
struct Ring {
    float height;
    float radius;
    float bulge;
};

constexpr Ring kPole{0.0f, 0.0f, 0.0f};
using Profile = std::array<Ring, 4>;
constexpr std::array<Profile, 6> kTurned{{
    // the rim
    {{{2.4f, 1.4f, 0.784f},
      {2.53125f, 1.3375f, 0.749f},
      {2.53125f, 1.4375f, 0.805f},
      {2.4f, 1.5f, 0.84f}}},
    // the body, above and below its widest place
    {{{2.4f, 1.5f, 0.84f}, {1.875f, 1.75f, 0.98f}, {1.35f, 2.0f, 1.12f}, {0.9f, 2.0f, 1.12f}}},
    {{{0.9f, 2.0f, 1.12f}, {0.45f, 2.0f, 1.12f}, {0.225f, 1.5f, 0.84f}, {0.15f, 1.5f, 0.84f}}},
    // the knob and the lid
    {{{3.15f, 0.0f, 0.0f}, {3.15f, 0.8f, 0.45f}, {2.85f, 0.0f, 0.0f}, {2.7f, 0.2f, 0.112f}}},
    {{{2.7f, 0.2f, 0.112f}, {2.55f, 0.4f, 0.224f}, {2.55f, 1.3f, 0.728f}, {2.4f, 1.3f, 0.728f}}},
    // the bottom, from its edge to its middle
    {{{0.15f, 1.5f, 0.84f}, {0.075f, 1.5f, 0.84f}, {0.0f, 1.425f, 0.798f}, kPole}},
}};

/// One row of a half: points (x, height) of its inner and outer curve, and how far it bulges to the
/// side.
struct HalfRow {
    glm::vec2 inner;
    glm::vec2 outer;
    float side;
};
using Half = std::array<HalfRow, 4>;
constexpr std::array<Half, 4> kHalves{{
    // the handle
    {{{{-1.6f, 2.025f}, {-1.5f, 2.25f}, 0.3f},
      {{-2.3f, 2.025f}, {-2.5f, 2.25f}, 0.3f},
      {{-2.7f, 2.025f}, {-3.0f, 2.25f}, 0.3f},
      {{-2.7f, 1.8f}, {-3.0f, 1.8f}, 0.3f}}},
    {{{{-2.7f, 1.8f}, {-3.0f, 1.8f}, 0.3f},
      {{-2.7f, 1.575f}, {-3.0f, 1.35f}, 0.3f},
      {{-2.5f, 1.125f}, {-2.65f, 0.9375f}, 0.3f},
      {{-2.0f, 0.9f}, {-1.9f, 0.6f}, 0.3f}}},
    // the spout
    {{{{1.7f, 1.425f}, {1.7f, 0.6f}, 0.66f},
      {{2.6f, 1.425f}, {3.1f, 0.825f}, 0.66f},
      {{2.3f, 2.1f}, {2.4f, 2.025f}, 0.25f},
      {{2.7f, 2.4f}, {3.3f, 2.4f}, 0.25f}}},
    {{{{2.7f, 2.4f}, {3.3f, 2.4f}, 0.25f},
      {{2.8f, 2.475f}, {3.525f, 2.49375f}, 0.25f},
      {{2.9f, 2.475f}, {3.45f, 2.5125f}, 0.15f},
      {{2.8f, 2.4f}, {3.2f, 2.4f}, 0.15f}}},
}};

Patch turned_patch(const Profile& profile, uint32_t quarter)
{
    Patch patch;
    for (size_t row = 0; row < 4; ++row) {
        const Ring& ring = profile[row];
        const glm::vec2 points[4] = {{ring.radius, 0.0f},
                                     {ring.radius, ring.bulge},
                                     {ring.bulge, ring.radius},
                                     {0.0f, ring.radius}};
        for (size_t i = 0; i < 4; ++i) {
            glm::vec2 at = points[i];
            for (uint32_t turn = 0; turn < quarter; ++turn) {
                at = {-at.y, at.x};
            }
            patch[4 * row + i] = {at.x, ring.height, -at.y};
        }
    }
    return patch;
}

Patch half_patch(const Half& half, float side)
{
    Patch patch;
    for (size_t row = 0; row < 4; ++row) {
        const HalfRow& r = half[row];
        patch[4 * row + 0] = {r.inner.x, r.inner.y, 0.0f};
        patch[4 * row + 1] = {r.inner.x, r.inner.y, side * r.side};
        patch[4 * row + 2] = {r.outer.x, r.outer.y, side * r.side};
        patch[4 * row + 3] = {r.outer.x, r.outer.y, 0.0f};
    }
    return patch;
}

/// A point of a cubic curve (de Casteljau). Exact at both ends, and where the control points are
/// one: neighbours meet in the same points, and poles are points.
glm::vec3 on_curve(const std::array<glm::vec3, 4>& control, float t)
{
    std::array<glm::vec3, 4> points = control;
    for (size_t left = 3; left > 0; --left) {
        for (size_t i = 0; i < left; ++i) {
            points[i] = t < 1.0f ? points[i] + t * (points[i + 1] - points[i]) : points[i + 1];
        }
    }
    return points[0];
}

glm::vec3 on_patch(const Patch& patch, float along_rows, float along_row)
{
    std::array<glm::vec3, 4> rows;
    for (size_t row = 0; row < 4; ++row) {
        rows[row] =
            on_curve({patch[4 * row], patch[4 * row + 1], patch[4 * row + 2], patch[4 * row + 3]},
                     along_row);
    }
    return on_curve(rows, along_rows);
}

/// `flip`: the patch is a mirror image, so its triangles turn the other way.
void add_patch(Mesh& mesh, const Patch& patch, uint32_t steps, bool flip)
{
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    for (uint32_t row = 0; row <= steps; ++row) {
        for (uint32_t i = 0; i <= steps; ++i) {
            mesh.positions.push_back(on_patch(patch,
                                              static_cast<float>(row) / static_cast<float>(steps),
                                              static_cast<float>(i) / static_cast<float>(steps)));
        }
    }
    const auto add = [&](uint32_t a, uint32_t b, uint32_t c) {
        const std::vector<glm::vec3>& p = mesh.positions;
        if (p[a] != p[b] && p[b] != p[c] && p[c] != p[a]) {
            mesh.indices.insert(mesh.indices.end(), {a, flip ? c : b, flip ? b : c});
        }
    };
    for (uint32_t row = 0; row < steps; ++row) {
        for (uint32_t i = 0; i < steps; ++i) {
            const uint32_t a = first + row * (steps + 1) + i;
            const uint32_t below = a + steps + 1;
            add(a, below, below + 1);
            add(a, below + 1, a + 1);
        }
    }
}

} // namespace

uint32_t teapot_steps(uint64_t triangles)
{
    const auto off = [&](uint64_t steps) {
        const uint64_t has = 2 * kTeapotPatches * steps * steps;
        return has > triangles ? has - triangles : triangles - has;
    };
    uint32_t steps = 1;
    while (off(steps + 1) < off(steps)) {
        ++steps;
    }
    return steps;
}

Mesh make_teapot(uint32_t steps, uint32_t item_triangles)
{
    Mesh mesh;
    mesh.name = "teapot";
    for (const Profile& profile : kTurned) {
        for (uint32_t quarter = 0; quarter < 4; ++quarter) {
            add_patch(mesh, turned_patch(profile, quarter), steps, false);
        }
    }
    for (const Half& half : kHalves) {
        add_patch(mesh, half_patch(half, 1.0f), steps, true);
        add_patch(mesh, half_patch(half, -1.0f), steps, false);
    }
    make_normals(mesh);
    partition_mesh(mesh, item_triangles);
    return mesh;
}

} // namespace occlude::tools
