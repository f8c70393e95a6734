#include <occlude/backends/cpu/rasterizer.h>

#include <glm/matrix.hpp>

#include <cmath>
#include <limits>

namespace occlude::cpu {

namespace {

// How far from the middle of the screen a vertex may be before it is clipped, in pixels. 2^21 px
// are 2^29 snaps: see ScreenVertex.
constexpr double kGuardPixels = 0x1p21;
// In views that ignore the near plane, triangles are clipped at this window depth: a million times
// nearer to the eye than the near plane, while double still resolves depth to 2^-32.
constexpr double kLeastClampedDepth = -0x1p20;
// The least w that can be divided by.
constexpr double kLeastW = std::numeric_limits<double>::min();

// Every ClipConvention becomes "0 <= z <= w, 0 is near": the row of z is rewritten, in double.
glm::dmat4 canonical_clip(const glm::dmat4& clip_from_space, ClipConvention convention)
{
    glm::dmat4 rows = glm::transpose(clip_from_space);
    if (convention.range == DepthRange::minus_one_to_one) {
        rows[2] = 0.5 * (rows[2] + rows[3]);
    }
    if (convention.order == DepthOrder::near_is_large) {
        rows[2] = rows[3] - rows[2];
    }
    return glm::transpose(rows);
}

bool all_finite(const glm::dmat4& m)
{
    double sum = 0.0; // 0 * x is NaN for infinite and NaN x, and stays so
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 4; ++row) {
            sum += 0.0 * m[column][row];
        }
    }
    return sum == 0.0;
}

int64_t snap(double pixels)
{
    // Round half up: the cast truncates, so the value is made positive first.
    constexpr double kOffset = 0x1p31;
    return static_cast<int64_t>(pixels * static_cast<double>(kSubpixels) + (kOffset + 0.5)) -
           static_cast<int64_t>(kOffset);
}

// The planes that triangles are clipped by, as "inside where dot(plane, clip) >= 0".
constexpr size_t kClipPlanes = 6;

// Sutherland and Hodgman's step for one plane.
void clip_by_plane(ClipPolygon& polygon, const glm::dvec4& plane)
{
    ClipPolygon kept;
    for (size_t i = 0; i < polygon.count; ++i) {
        const glm::dvec4& from = polygon.corners[i];
        const glm::dvec4& to = polygon.corners[(i + 1) % polygon.count];
        const double from_distance = glm::dot(plane, from);
        const double to_distance = glm::dot(plane, to);
        const bool from_inside = from_distance >= 0.0;
        const bool to_inside = to_distance >= 0.0;
        if (from_inside) {
            kept.corners[kept.count++] = from;
        }
        if (from_inside != to_inside) {
            // Always from the inside out, so that both triangles at an edge compute the same point.
            const glm::dvec4& in = from_inside ? from : to;
            const glm::dvec4& out = from_inside ? to : from;
            const double in_distance = from_inside ? from_distance : to_distance;
            const double out_distance = from_inside ? to_distance : from_distance;
            const double t = in_distance / (in_distance - out_distance);
            kept.corners[kept.count++] = in + t * (out - in);
        }
    }
    polygon = kept;
}

} // namespace

ScreenTransform::ScreenTransform(const View& view)
    : clip_from_relative_(canonical_clip(view.clip_from_relative(), view.convention()))
    , clip_from_world_(clip_from_relative_)
    , origin_(view.origin())
    , size_px_(view.size_px())
    , least_depth_(view.ignores_near_plane() ? kLeastClampedDepth : 0.0)
{
    clip_from_world_[3] = clip_from_relative_ * glm::dvec4{-origin_, 1.0};
    usable_ = all_finite(clip_from_world_) && size_px_.x > 0 && size_px_.y > 0 &&
              size_px_.x <= kMaxSide && size_px_.y <= kMaxSide;
    if (usable_) {
        guard_ = 2.0 * kGuardPixels / glm::dvec2{size_px_};
    }
}

glm::dmat4 ScreenTransform::clip_from_local(const glm::mat4& world_from_local) const
{
    glm::dmat4 relative_from_local{world_from_local};
    relative_from_local[3] -= glm::dvec4{origin_, 0.0};
    return clip_from_relative_ * relative_from_local;
}

uint8_t ScreenTransform::code(const glm::dvec4& clip) const
{
    const auto bit = [](bool beyond, ClipCode which) {
        return beyond ? static_cast<unsigned>(which) : 0u;
    };
    const double x = clip.x;
    const double y = clip.y;
    const double w = clip.w;
    const bool finite = 0.0 * (x + y + clip.z + w) == 0.0;
    const bool in_guard =
        std::abs(x) <= guard_.x * w && std::abs(y) <= guard_.y * w && w >= kLeastW;
    const unsigned bits =
        bit(x < -w, beyond_left) | bit(x > w, beyond_right) | bit(y < -w, beyond_bottom) |
        bit(y > w, beyond_top) | bit(clip.z < least_depth_ * w, beyond_near) |
        bit(clip.z > w, beyond_far) | bit(!in_guard, beyond_guard) | bit(!finite, not_finite);
    return static_cast<uint8_t>(bits);
}

ScreenVertex ScreenTransform::to_screen(const glm::dvec4& clip) const
{
    const double inverse_w = 1.0 / clip.w;
    const double half_width = 0.5 * size_px_.x;
    const double half_height = 0.5 * size_px_.y;
    return {snap(clip.x * inverse_w * half_width + half_width),
            snap(clip.y * inverse_w * half_height + half_height),
            // Corners made by clipping can miss the limits by a rounding error.
            std::clamp(clip.z * inverse_w, least_depth_, 1.0)};
}

Vertex ScreenTransform::process(const glm::dvec4& clip) const
{
    Vertex vertex;
    vertex.clip = clip;
    vertex.code = code(clip);
    if ((vertex.code & (kNeedsClipping | not_finite)) == 0) {
        vertex.screen = to_screen(clip);
    }
    return vertex;
}

void ScreenTransform::clip(ClipPolygon& polygon) const
{
    const std::array<glm::dvec4, kClipPlanes> planes{{
        {0.0, 0.0, 1.0, -least_depth_},
        {0.0, 0.0, -1.0, 1.0},
        {1.0, 0.0, 0.0, guard_.x},
        {-1.0, 0.0, 0.0, guard_.x},
        {0.0, 1.0, 0.0, guard_.y},
        {0.0, -1.0, 0.0, guard_.y},
    }};
    for (const glm::dvec4& plane : planes) {
        clip_by_plane(polygon, plane);
    }
    for (size_t i = 0; i < polygon.count; ++i) {
        // The guard planes leave w >= max(|x|, |y|) / guard, so only the eye itself must be
        // refused.
        if (!(polygon.corners[i].w >= kLeastW)) {
            polygon.count = 0;
        }
    }
}

bool clip_segment(glm::dvec4& a, glm::dvec4& b)
{
    constexpr std::array<glm::dvec4, 6> kVolume{{
        {0.0, 0.0, 1.0, 0.0},
        {0.0, 0.0, -1.0, 1.0},
        {1.0, 0.0, 0.0, 1.0},
        {-1.0, 0.0, 0.0, 1.0},
        {0.0, 1.0, 0.0, 1.0},
        {0.0, -1.0, 0.0, 1.0},
    }};
    for (const glm::dvec4& plane : kVolume) {
        const double a_distance = glm::dot(plane, a);
        const double b_distance = glm::dot(plane, b);
        if (!(a_distance >= 0.0) && !(b_distance >= 0.0)) {
            return false;
        }
        const double t = a_distance / (a_distance - b_distance);
        if (!(a_distance >= 0.0)) {
            a += t * (b - a);
        } else if (!(b_distance >= 0.0)) {
            b = a + t * (b - a);
        }
    }
    return a.w >= kLeastW && b.w >= kLeastW;
}

} // namespace occlude::cpu
