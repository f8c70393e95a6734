#include <occlude/device/detail/sure_pixels.h>

#include <glm/common.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace occlude::detail {

namespace {

// A pixel counts as shown only if its depth is farther than the box by this share of the depth
// range, because the device computes the box's depth in another order.
constexpr double kDepthSlop = 1e-4;
// ... and only if it lies inside the box's outline by this many pixels.
constexpr double kOutlineSlopPx = 0.125;
// In units of the rounding that View::clip_rounding() allows a device in one coordinate of a
// corner.
constexpr float kRoundings = 4.0f;

// The convex outline of a box on the target, in pixels, and its farthest window depth. Both slops
// grow with the rounding of corners far from the origin on a device that computes in float.
struct Outline {
    std::vector<glm::dvec2> corners_px; ///< counter-clockwise; empty if nothing is sure
    double farthest01 = 0.0;
    double slop_px = kOutlineSlopPx;
    double depth_slop = kDepthSlop;
};

double cross(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c)
{
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

std::vector<glm::dvec2> convex_hull(std::array<glm::dvec2, 8> points)
{
    std::sort(points.begin(), points.end(), [](const glm::dvec2& a, const glm::dvec2& b) {
        return a.x != b.x ? a.x < b.x : a.y < b.y;
    });
    std::vector<glm::dvec2> hull;
    const auto add_chain = [&](auto first, auto last) {
        const size_t base = hull.size();
        for (auto point = first; point != last; ++point) {
            while (hull.size() >= base + 2 &&
                   cross(hull[hull.size() - 2], hull.back(), *point) <= 0.0) {
                hull.pop_back();
            }
            hull.push_back(*point);
        }
        hull.pop_back(); // it starts the next chain
    };
    add_chain(points.begin(), points.end());
    add_chain(points.rbegin(), points.rend());
    return hull;
}

// How far the terms that a device rounds in a corner's position reach, along each axis of the world
// and relative to the view's origin. The terms are the position itself, or the products of a box's
// own map.
glm::dvec3 reach_of(const QueryBox& box, const glm::dmat4& relative_from_box,
                    const glm::dvec4& corner)
{
    if (box.world_from_box == nullptr) {
        return glm::abs(glm::dvec3{relative_from_box * corner});
    }
    glm::dvec4 reach = glm::abs(relative_from_box[3]);
    for (int axis = 0; axis < 3; ++axis) {
        reach += glm::abs(relative_from_box[axis] * corner[axis]);
    }
    return glm::dvec3{reach};
}

// Empty if the box reaches behind the eye, or so near it that float cannot tell.
Outline outline_of(const QueryBox& box, const View& view)
{
    if (!view.usable()) {
        return {};
    }
    const glm::dmat4& clip_from_relative = view.clip_from_relative();
    glm::dmat4 relative_from_box{box.world_from_box ? *box.world_from_box : glm::mat4{1.0f}};
    relative_from_box[3] -= glm::dvec4{view.origin(), 0.0};
    const glm::dmat4 clip_from_box = clip_from_relative * relative_from_box;
    const bool reversed = view.convention().order == DepthOrder::near_is_large;
    const bool zero_to_one = view.convention().range == DepthRange::zero_to_one;
    const glm::dvec2 size{view.size_px()};
    std::array<glm::dvec2, 8> points;
    Outline outline;
    for (unsigned i = 0; i < 8; ++i) {
        const glm::dvec4 corner{i & 1 ? box.box.max.x : box.box.min.x,
                                i & 2 ? box.box.max.y : box.box.min.y,
                                i & 4 ? box.box.max.z : box.box.min.z, 1.0};
        const glm::dvec4 clip = clip_from_box * corner;
        const glm::dvec3 reach = reach_of(box, relative_from_box, corner);
        const glm::dvec4 error{kRoundings * view.clip_rounding(glm::vec3{reach})};
        const double least_w = clip.w - error.w;
        if (!(least_w > 0.0)) {
            return {};
        }
        const glm::dvec3 ndc = glm::dvec3{clip} / clip.w;
        const glm::dvec3 ndc_error = (glm::dvec3{error} + glm::abs(ndc) * error.w) / least_w;
        points[i] = (glm::dvec2{ndc} * 0.5 + 0.5) * size;
        outline.slop_px = std::max(outline.slop_px, kOutlineSlopPx + 0.5 * ndc_error.x * size.x);
        outline.slop_px = std::max(outline.slop_px, kOutlineSlopPx + 0.5 * ndc_error.y * size.y);
        outline.depth_slop = std::max(outline.depth_slop, kDepthSlop + ndc_error.z);
        const double stored = zero_to_one ? ndc.z : ndc.z * 0.5 + 0.5;
        outline.farthest01 = std::max(outline.farthest01, reversed ? 1.0 - stored : stored);
    }
    outline.corners_px = convex_hull(points);
    return outline;
}

bool contains_pixel(const Outline& outline, int x, int y)
{
    const double low = -outline.slop_px;
    const double high = 1.0 + outline.slop_px;
    const glm::dvec2 origin{x, y};
    for (size_t i = 0; i < outline.corners_px.size(); ++i) {
        const glm::dvec2& a = outline.corners_px[i];
        const glm::dvec2& b = outline.corners_px[(i + 1) % outline.corners_px.size()];
        for (const glm::dvec2& offset : {glm::dvec2{low, low}, glm::dvec2{high, low},
                                         glm::dvec2{low, high}, glm::dvec2{high, high}}) {
            if (cross(a, b, origin + offset) <= 0.0) {
                return false;
            }
        }
    }
    return outline.corners_px.size() >= 3;
}

} // namespace

int sure_pixels(const QueryBox& box, const View& view, std::span<const float> depth)
{
    if (depth.empty()) {
        return 0;
    }
    const Outline outline = outline_of(box, view);
    if (outline.corners_px.empty()) {
        return 0;
    }
    glm::dvec2 low = outline.corners_px.front();
    glm::dvec2 high = low;
    for (const glm::dvec2& corner : outline.corners_px) {
        low = glm::min(low, corner);
        high = glm::max(high, corner);
    }
    const glm::dvec2 size{view.size_px()};
    const glm::ivec2 begin{glm::clamp(glm::floor(low), glm::dvec2{0.0}, size)};
    const glm::ivec2 end{glm::clamp(glm::ceil(high), glm::dvec2{0.0}, size)};
    int count = 0;
    for (int y = begin.y; y < end.y; ++y) {
        for (int x = begin.x; x < end.x; ++x) {
            const float there = depth[static_cast<size_t>(y * view.size_px().x + x)];
            if (there > outline.farthest01 + outline.depth_slop && contains_pixel(outline, x, y)) {
                ++count;
            }
        }
    }
    return count;
}

} // namespace occlude::detail
