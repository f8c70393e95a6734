#include <occlude/backends/cpu_fast/detail/instance_transform.h>

#include <occlude/backends/cpu_fast/detail/prim.h>
#include <occlude/core/absolute.h>
#include <occlude/screen/projection.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <bit>
#include <limits>

namespace occlude::cpu_fast {

namespace {

// Triangles are cut this many half screens from its middle, so that positions stay small.
constexpr double kGuard = 4.0;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// True if all corners of a box are beyond one side of the view.
bool outside(const std::array<glm::vec4, 8>& corners, glm::vec2 size, float least_w)
{
    unsigned shared = ~0u;
    for (const glm::vec4& c : corners) {
        unsigned code = c.w < least_w ? 1u : 0u;
        code |= c.x < 0.0f ? 2u : 0u;
        code |= c.x > size.x * c.w ? 4u : 0u;
        code |= c.y < 0.0f ? 8u : 0u;
        code |= c.y > size.y * c.w ? 16u : 0u;
        code |= c.z > c.w ? 32u : 0u;
        shared &= code;
    }
    return shared != 0;
}

} // namespace

Grid::Grid(glm::ivec2 size, int cell)
    : size_px(size)
    , cell_px(cell)
    , size_cells((size + cell - 1) / cell)
    , size_bins((size_cells.x + kBinWidth - 1) / kBinWidth,
                (size_cells.y + kBinHeight - 1) / kBinHeight)
{
}

// Rounding: every device, and the float transform here, misses the clip position of a point by at
// most `error` each, because a point's position is a convex combination of its triangle's. Inside
// of the screen, where |x|, |y| < 2 w, that moves it by up to moved / w cells. Instances that are
// far enough away pay little for that; others are cut where it becomes kMostDisplacement. In depth
// it is error / w, which is linear on the screen like depth itself: part of the map.
InstanceTransform::InstanceTransform(const View& view, const Grid& grid,
                                     const glm::mat4& world_from_mesh, const Aabb& box)
{
    const View own = view.in_object(world_from_mesh);
    if (!own.usable() || !box.is_bounded()) {
        return;
    }
    const glm::dvec2 half = 0.5 * glm::dvec2{grid.size_px} / double(grid.cell_px);
    glm::dmat4 rows = glm::transpose(own.clip_from_relative());
    const ClipConvention convention = view.convention();
    if (convention.range == DepthRange::minus_one_to_one) {
        rows[2] = 0.5 * (rows[2] + rows[3]);
    }
    if (convention.order == DepthOrder::near_is_large) {
        rows[2] = rows[3] - rows[2];
    }
    const glm::dvec3 toward = glm::dvec3{own.orthographic() ? rows[2] : rows[3]};
    const double turn = glm::dot(glm::cross(glm::dvec3{rows[0]}, glm::dvec3{rows[1]}), toward);
    front_sign = turn < 0.0 ? 1.0f : -1.0f;
    rows[0] = half.x * (rows[0] + rows[3]);
    rows[1] = half.y * (rows[1] + rows[3]);
    for (int row = 0; row < 4; ++row) { // from positions instead of those relative to the origin
        rows[row].w -= glm::dot(glm::dvec3{rows[row]}, own.origin());
    }
    const glm::mat4 columns{glm::transpose(rows)};
    for (int i = 0; i < 4; ++i) {
        column[static_cast<size_t>(i)] = columns[i];
    }

    const glm::vec3 reach{glm::max(detail::absolute(glm::dvec3{box.min} - own.origin()),
                                   detail::absolute(glm::dvec3{box.max} - own.origin()))};
    const glm::dvec4 error = 2.0 * glm::dvec4{own.clip_rounding(1.001f * reach)};
    const double moved =
        1.1 * std::max(half.x * (error.x + 2.0 * error.w), half.y * (error.y + 2.0 * error.w));
    const auto depth_error = static_cast<float>(error.z + 2.0 * error.w);
    column[3].z += depth_error;
    least_z = view.ignores_near_plane() ? -kInfinity : 3.0f * depth_error;
    guard_low = glm::vec2{half * (1.0 - kGuard)};
    guard_high = glm::vec2{half * (1.0 + kGuard)};

    std::array<glm::vec4, 8> corners;
    float box_w = kInfinity;
    nearest = 1.0f;
    for (size_t i = 0; i < corners.size(); ++i) {
        const glm::vec3 p{(i & 1) != 0 ? box.max.x : box.min.x,
                          (i & 2) != 0 ? box.max.y : box.min.y,
                          (i & 4) != 0 ? box.max.z : box.min.z};
        corners[i] = column[0] * p.x + column[1] * p.y + column[2] * p.z + column[3];
        box_w = std::min(box_w, corners[i].w);
        tie_break = 31 * tie_break + std::bit_cast<uint32_t>(corners[i].x + corners[i].y);
        nearest = std::min(nearest, corners[i].w > 0.0f ? corners[i].z / corners[i].w : 0.0f);
    }
    const double displacement = box_w > 0.0f ? std::clamp(moved / (0.99 * double{box_w}),
                                                          double{Growth::kLeastDisplacement},
                                                          double{Growth::kMostDisplacement})
                                             : double{Growth::kMostDisplacement};
    least_w = static_cast<float>(moved / displacement);
    growth = Growth(static_cast<float>(1.001 * displacement));
    z_slack = ScreenBounds::kDepthMargin + view.inflation().depth_bias;
    usable = !outside(corners, glm::vec2{2.0 * half}, least_w) && least_w > 0.0f &&
             least_w < kInfinity && z_slack < 1.0f;
}

} // namespace occlude::cpu_fast
