// The scalar rasteriser of the CPU device: clip, snap, fill. Written so that reading can verify it.
//
//   mesh ──double──► clip ──clip──► clip ──divide, snap to 1/256 px──► screen ──fill──► samples
//
// Clip space here is the same for every ClipConvention: inside where |x| <= w, |y| <= w and
// 0 <= z <= w; z / w is the window depth, 0 at the near plane and 1 at the far plane. Screen space
// has its origin at the lower left corner of the target, y up, in units of 1/256 px; the sample of
// pixel (i, j) is its centre (256 i + 128, 256 j + 128).
//
// Snapped positions are integers and edge functions are evaluated exactly, so that a sample on an
// edge shared by two triangles is covered by exactly one of them (top-left rule), and a closed mesh
// has no holes. Depth is a linear function of the edge functions, in double.
#pragma once

#include <occlude/core/view.h>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace occlude::cpu {

/// Snaps per pixel.
constexpr int kSubpixelBits = 8;
constexpr int64_t kSubpixels = int64_t{1} << kSubpixelBits;
/// The largest side of a target, in pixels. Larger views draw nothing and answer no test.
constexpr int kMaxSide = 16384;

/// A vertex on the screen. |x|, |y| < 2^30, so that edge functions stay below 2^62.
struct ScreenVertex {
    int64_t x = 0;      ///< 1/256 px
    int64_t y = 0;      ///< 1/256 px, up
    double depth = 0.0; ///< below 0 only in views that ignore the near plane
};

/// The sides of the view volume that a clip position is beyond.
enum ClipCode : uint8_t {
    beyond_left = 1,
    beyond_right = 2,
    beyond_bottom = 4,
    beyond_top = 8,
    beyond_near = 16,
    beyond_far = 32,
    beyond_guard = 64, ///< too far outside of the screen for the integers of ScreenVertex
    not_finite = 128,  ///< nothing with such a corner is drawn
};
/// If all corners of a convex shape share one of these bits, it is not visible.
constexpr uint8_t kBeyondView =
    beyond_left | beyond_right | beyond_bottom | beyond_top | beyond_near | beyond_far;
/// A triangle with one of these bits is clipped. Without them its snapped corners are used
/// directly.
constexpr uint8_t kNeedsClipping = beyond_near | beyond_far | beyond_guard;

struct Vertex {
    glm::dvec4 clip{0.0};
    ScreenVertex screen; ///< only if !(code & kNeedsClipping)
    uint8_t code = not_finite;
};

/// A convex polygon in clip space: a triangle plus one more corner for each plane that clips it.
struct ClipPolygon {
    static constexpr size_t kMaxCorners = 3 + 6;

    std::array<glm::dvec4, kMaxCorners> corners;
    size_t count = 0;
};

/// Maps the spaces of meshes and boxes to the screen, for one view.
class ScreenTransform {
public:
    ScreenTransform() = default;
    explicit ScreenTransform(const View& view);

    /// False if the view's matrix is not finite or its size is not in [1, kMaxSide].
    bool usable() const { return usable_; }
    glm::ivec2 size_px() const { return size_px_; }

    /// The clip matrix of a local space, composed in double: the position of the local space is
    /// first taken relative to the view's origin, so that nothing cancels far from the world's.
    glm::dmat4 clip_from_local(const glm::mat4& world_from_local) const;
    /// The clip matrix of world space.
    const glm::dmat4& clip_from_world() const { return clip_from_world_; }

    uint8_t code(const glm::dvec4& clip) const;

    /// The position divided and snapped. Precondition: no bit of kNeedsClipping in its code.
    ScreenVertex to_screen(const glm::dvec4& clip) const;

    Vertex process(const glm::dvec4& clip) const;

    /// Clips the polygon to the space between near and far plane and to the guard band. The same
    /// edge is cut at the same point, whichever triangle it belongs to. A polygon that reaches the
    /// eye itself (w = 0, which for any sensible matrix lies behind the near plane) becomes empty.
    void clip(ClipPolygon& polygon) const;

private:
    glm::dmat4 clip_from_relative_{1.0}; ///< from (position - origin_)
    glm::dmat4 clip_from_world_{1.0};
    glm::dvec3 origin_{0.0};
    glm::ivec2 size_px_{0};
    glm::dvec2 guard_{1.0};    ///< |x| <= guard.x * w, |y| <= guard.y * w
    double least_depth_ = 0.0; ///< clipped before this window depth; drawn at depth >= 0
    bool usable_ = false;
};

/// One side of a triangle as its edge function: positive inside, 0 on the line, exact.
struct Edge {
    /// The edge from `a` to `b`, with the inside at the left; `row` is its value at sample (x, y).
    Edge(const ScreenVertex& a, const ScreenVertex& b, int64_t x, int64_t y)
        : step_x(-(b.y - a.y) * kSubpixels)
        , step_y((b.x - a.x) * kSubpixels)
        , row((b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x))
        , threshold(b.y < a.y || (b.y == a.y && b.x < a.x) ? 0 : 1)
    {
    }

    int64_t step_x;
    int64_t step_y;
    int64_t row;
    int64_t threshold; ///< the least value inside: 0 on left and top edges, otherwise 1
};

/// Calls fragment(pixel, depth) for every sample that the triangle covers, at most once each, row
/// by row; pixel = y * size.x + x. Both sides are drawn. Depth lies within the depths of the
/// corners, and is at least 0.
template <class Fragment>
void rasterize(const ScreenVertex& a, ScreenVertex b, ScreenVertex c, glm::ivec2 size,
               Fragment&& fragment)
{
    constexpr int64_t kCentre = kSubpixels / 2;
    const auto first_sample = [](int64_t low) { // the first pixel whose centre is not below `low`
        return std::max<int64_t>((low - kCentre + kSubpixels - 1) >> kSubpixelBits, 0);
    };
    const auto last_sample = [](int64_t high, int side) {
        return std::min<int64_t>((high - kCentre) >> kSubpixelBits, side - 1);
    };
    const int64_t x_begin = first_sample(std::min({a.x, b.x, c.x}));
    const int64_t x_last = last_sample(std::max({a.x, b.x, c.x}), size.x);
    const int64_t y_begin = first_sample(std::min({a.y, b.y, c.y}));
    const int64_t y_last = last_sample(std::max({a.y, b.y, c.y}), size.y);
    if (x_begin > x_last || y_begin > y_last) {
        return;
    }
    int64_t area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (area == 0) {
        return;
    }
    if (area < 0) {
        std::swap(b, c);
        area = -area;
    }

    // The edge opposite of a corner, divided by the area, is the corner's barycentric weight.
    const int64_t x = x_begin * kSubpixels + kCentre;
    const int64_t y = y_begin * kSubpixels + kCentre;
    Edge edge_a(b, c, x, y);
    Edge edge_b(c, a, x, y);
    Edge edge_c(a, b, x, y);
    const double depth_b = (b.depth - a.depth) / static_cast<double>(area);
    const double depth_c = (c.depth - a.depth) / static_cast<double>(area);
    const double depth_min = std::max(std::min({a.depth, b.depth, c.depth}), 0.0);
    const double depth_max = std::max({a.depth, b.depth, c.depth, 0.0});

    for (int64_t j = y_begin; j <= y_last; ++j) {
        int64_t weight_a = edge_a.row;
        int64_t weight_b = edge_b.row;
        int64_t weight_c = edge_c.row;
        bool entered = false;
        for (int64_t i = x_begin; i <= x_last; ++i) {
            if (weight_a >= edge_a.threshold && weight_b >= edge_b.threshold &&
                weight_c >= edge_c.threshold) {
                entered = true;
                const double depth = a.depth + (static_cast<double>(weight_b) * depth_b +
                                                static_cast<double>(weight_c) * depth_c);
                fragment(static_cast<size_t>(j * size.x + i),
                         std::clamp(depth, depth_min, depth_max));
            } else if (entered) {
                break; // convex: the rest of the row is outside
            }
            weight_a += edge_a.step_x;
            weight_b += edge_b.step_x;
            weight_c += edge_c.step_x;
        }
        edge_a.row += edge_a.step_y;
        edge_b.row += edge_b.step_y;
        edge_c.row += edge_c.step_y;
    }
}

/// As rasterize(), from vertices anywhere in space: rejects, clips and fills.
template <class Fragment>
void draw_triangle(const ScreenTransform& transform, const Vertex& a, const Vertex& b,
                   const Vertex& c, Fragment&& fragment)
{
    const uint8_t any = a.code | b.code | c.code;
    if ((a.code & b.code & c.code & kBeyondView) != 0 || (any & not_finite) != 0) {
        return;
    }
    if ((any & kNeedsClipping) == 0) {
        rasterize(a.screen, b.screen, c.screen, transform.size_px(), fragment);
        return;
    }
    ClipPolygon polygon{{a.clip, b.clip, c.clip}, 3};
    transform.clip(polygon);
    for (size_t corner = 2; corner < polygon.count; ++corner) {
        rasterize(transform.to_screen(polygon.corners[0]),
                  transform.to_screen(polygon.corners[corner - 1]),
                  transform.to_screen(polygon.corners[corner]), transform.size_px(), fragment);
    }
}

/// Clips the segment from `a` to `b` to the view volume, |x|, |y| <= w included. False if nothing
/// is left.
bool clip_segment(glm::dvec4& a, glm::dvec4& b);

} // namespace occlude::cpu
