// The projection of boxes, one after the other: the specification of what box_projector_simd.cpp does.
//
// Extremes over a box of x / w, y / w and depth / w are at corners: they are fractions of linear
// functions with a positive denominator. All is done in float, as a device does it. With u = 2^-24
// and S the sum of the absolute terms of a coordinate, a device that transforms to world space first
// is off by up to 8 u S, and the sums here by up to 5 u S; 20 u S are allowed. Since S >= w, what is
// left pays for the quotient (2 u of it) and for the rounding of the error itself.
#include <occlude/core/detail/box_projector.h>

#include <occlude/core/assert.h>

#include <glm/common.hpp>
#include <glm/mat4x4.hpp>

#include <algorithm>
#include <cmath>

namespace occlude {

namespace detail {

static constexpr double kSlop = 20.0 * 0x1p-24;

static glm::dmat4 magnitude(const glm::mat4& m)
{
    return {glm::abs(glm::dvec4{m[0]}), glm::abs(glm::dvec4{m[1]}), glm::abs(glm::dvec4{m[2]}),
            glm::abs(glm::dvec4{m[3]})};
}

BoxProjector::BoxProjector(const View& view)
    : inflation(view.inflation())
{
    const glm::mat4& clip = view.clip_from_world();
    set_columns(view, glm::dmat4{clip}, magnitude(clip));
}

BoxProjector::BoxProjector(const View& view, const glm::mat4& world_from_box)
    : inflation{.per_diagonal = 0.0f, .per_coordinate = 0.0f}
{
    const glm::mat4& clip = view.clip_from_world();
    // A device goes by way of the world, and so do the terms that it rounds.
    set_columns(view, glm::dmat4{clip} * glm::dmat4{world_from_box},
                magnitude(clip) * magnitude(world_from_box));
}

void BoxProjector::set_columns(const View& view, const glm::dmat4& clip,
                               const glm::dmat4& magnitude)
{
    size = glm::vec2{glm::max(view.size_px(), glm::ivec2{0})};
    everywhere.rect = {0, 0, static_cast<int>(size.x), static_cast<int>(size.y)};
    usable = glm::vec3{view.frustum().plane(Frustum::near)} != glm::vec3{0.0f};
    const ClipConvention convention = view.convention();
    const glm::dvec2 half_size = 0.5 * glm::dvec2{size};
    for (int k = 0; k < 4; ++k) {
        glm::dvec4 c = clip[k];
        glm::dvec4 e = magnitude[k];
        c.x = half_size.x * (c.x + c.w);
        e.x = half_size.x * (e.x + e.w);
        c.y = half_size.y * (c.y + c.w);
        e.y = half_size.y * (e.y + e.w);
        if (convention.range == DepthRange::minus_one_to_one) {
            c.z = 0.5 * (c.z + c.w);
            e.z = 0.5 * (e.z + e.w);
        }
        if (convention.order == DepthOrder::near_is_large) {
            c.z = c.w - c.z;
            e.z += e.w;
        }
        column[static_cast<size_t>(k)] = glm::vec4{c};
        slop[static_cast<size_t>(k)] = glm::vec4{kSlop * e};
    }
}

// One coordinate of the eight corners of a box; bit i of an index says low or high on axis i.
using Corners = std::array<float, 8>;

static inline Corners corners(const BoxProjector& p, int row, const glm::vec3& low,
                              const glm::vec3& high)
{
    const float x[2] = {p.column[3][row] + p.column[0][row] * low.x,
                        p.column[3][row] + p.column[0][row] * high.x};
    const float y[2] = {p.column[1][row] * low.y, p.column[1][row] * high.y};
    const float z[2] = {p.column[2][row] * low.z, p.column[2][row] * high.z};
    const float xy[4] = {x[0] + y[0], x[1] + y[0], x[0] + y[1], x[1] + y[1]};
    Corners result;
    for (size_t k = 0; k < 4; ++k) {
        result[k] = xy[k] + z[0];
        result[k + 4] = xy[k] + z[1];
    }
    return result;
}

// Two by two, which a compiler turns into vectors; without NaN the order does not matter.
static float least(const Corners& c)
{
    float half[4];
    for (size_t k = 0; k < 4; ++k) {
        half[k] = c[k] < c[k + 4] ? c[k] : c[k + 4];
    }
    return std::min(std::min(half[0], half[1]), std::min(half[2], half[3]));
}

static float largest(const Corners& c)
{
    float half[4];
    for (size_t k = 0; k < 4; ++k) {
        half[k] = c[k] > c[k + 4] ? c[k] : c[k + 4];
    }
    return std::max(std::max(half[0], half[1]), std::max(half[2], half[3]));
}

ScreenBounds BoxProjector::project(const Aabb& box) const
{
    if (box.is_empty()) {
        return {PixelRect{}, 1.0f, 1.0f, true};
    }
    if (!usable || !box.is_bounded()) {
        return everywhere;
    }
    const float margin = inflation.margin(box);
    const glm::vec3 low = box.min - margin;
    const glm::vec3 high = box.max + margin;
    const glm::vec3 reach = glm::max(glm::abs(low), glm::abs(high));
    const glm::vec4 s = slop[0] * reach.x + slop[1] * reach.y + slop[2] * reach.z + slop[3];

    const Corners w = corners(*this, 3, low, high);
    const Corners z = corners(*this, 2, low, high);
    const float least_w = least(w);
    // Written so that a NaN from overflow says no.
    const bool certain = s.x < kLargestSlop && s.y < kLargestSlop && s.z < kLargestSlop &&
                         s.w < kLargestSlop && least(z) > s.z && least_w > 2.0f * s.w &&
                         least_w > kSmallestW;
    if (!certain) {
        return everywhere;
    }
    Corners over_w;
    for (size_t k = 0; k < 8; ++k) {
        over_w[k] = 1.0f / w[k];
    }
    const float over_least_w = 1.0f / (least_w - s.w);
    const auto range = [&](const Corners& c, float slop_c) -> glm::vec2 {
        Corners quotient;
        for (size_t k = 0; k < 8; ++k) {
            quotient[k] = c[k] * over_w[k];
        }
        const float from = least(quotient);
        const float to = largest(quotient);
        // (v + dv) / (w + dw) differs from v / w by at most (dv + |v / w| dw) / (w - dw).
        const float error = (slop_c + std::max(std::abs(from), std::abs(to)) * s.w) * over_least_w;
        return {from - error, to + error};
    };
    const glm::vec2 x_px = range(corners(*this, 0, low, high), s.x);
    const glm::vec2 y_px = range(corners(*this, 1, low, high), s.y);
    const glm::vec2 depth = range(z, s.z);

    ScreenBounds bounds;
    bounds.valid = true;
    bounds.near_depth = std::clamp(depth[0] - ScreenBounds::kDepthMargin, 0.0f, 1.0f);
    bounds.far_depth = std::clamp(depth[1] + ScreenBounds::kDepthMargin, 0.0f, 1.0f);
    const auto first_x = static_cast<int>(std::clamp(x_px[0], 0.0f, size.x));
    const auto first_y = static_cast<int>(std::clamp(y_px[0], 0.0f, size.y));
    const auto end_x = static_cast<int>(std::ceil(std::clamp(x_px[1], 0.0f, size.x)));
    const auto end_y = static_cast<int>(std::ceil(std::clamp(y_px[1], 0.0f, size.y)));
    if (first_x < end_x && first_y < end_y) {
        bounds.rect = {first_x, first_y, end_x - first_x, end_y - first_y};
    }
    return bounds;
}

} // namespace detail

void project_query_boxes(const View& view, std::span<const QueryBox> boxes,
                         std::span<ScreenBounds> bounds)
{
    OCCLUDE_ASSERT(boxes.size() == bounds.size(), "project_query_boxes needs one result per box");
    const detail::BoxProjector from_world{view, glm::mat4{1.0f}};
    for (size_t i = 0; i < boxes.size(); ++i) {
        const glm::mat4* world_from_box = boxes[i].world_from_box;
        bounds[i] = world_from_box == nullptr
                        ? from_world.project(boxes[i].box)
                        : detail::BoxProjector{view, *world_from_box}.project(boxes[i].box);
    }
}

ScreenBounds project(const View& view, const Aabb& box)
{
    return detail::BoxProjector{view}.project(box);
}

void project_boxes(const View& view, std::span<const Aabb> boxes, std::span<ScreenBounds> bounds,
                   Kernel kernel)
{
    OCCLUDE_ASSERT(boxes.size() == bounds.size(), "project_boxes needs one result per box");
    const detail::BoxProjector projector{view};
    if (kernel == Kernel::simd) {
        detail::project_boxes_simd(projector, boxes, bounds);
        return;
    }
    for (size_t i = 0; i < boxes.size(); ++i) {
        bounds[i] = projector.project(boxes[i]);
    }
}

} // namespace occlude
