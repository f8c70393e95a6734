#include <occlude/screen/projection.h>

#include <occlude/core/assert.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace occlude {

namespace {

// How far a device may be off in clip coordinates, for points whose coordinates relative to the
// view's origin are at most `reach`.
glm::dvec4 clip_slop(const View& view, const glm::dvec3& reach)
{
    return glm::dvec4{view.clip_rounding(glm::vec3{reach})};
}

// Maps z to 0 (near) to w (far) in every convention; `slop` is clip_slop() of z and of w.
void to_window_z(glm::dvec4& c, glm::dvec4& slop, ClipConvention convention)
{
    if (convention.range == DepthRange::minus_one_to_one) {
        c.z = 0.5 * (c.z + c.w);
        slop.z = 0.5 * (slop.z + slop.w);
    }
    if (convention.order == DepthOrder::near_is_large) {
        c.z = c.w - c.z;
        slop.z += slop.w;
    }
}

// A clip position on the screen: x, y and window depth, and how far a device may be off.
struct ScreenPoint {
    glm::dvec3 at{0.0};
    glm::dvec3 error{0.0};
    bool before_eye = false; // beyond the near plane, with w > 0
};

ScreenPoint to_screen(glm::dvec4 c, glm::dvec4 slop, ClipConvention convention)
{
    to_window_z(c, slop, convention);
    // Negated, so that a NaN from overflow counts as behind the eye.
    if (!(c.z > slop.z && c.w > 2.0 * slop.w)) {
        return {};
    }
    const glm::dvec3 p = glm::dvec3{c} / c.w;
    // (v + dv) / (w + dw) differs from v / w by at most (dv + |v / w| dw) / (w - dw).
    return {p, (glm::dvec3{slop} + glm::abs(p) * slop.w) / (c.w - slop.w), true};
}

// The world position of normalised x, y at window depth `depth`; NaN if it is not before the eye.
glm::dvec3 unproject(const glm::dmat4& relative_from_clip, const View& view, double x, double y,
                     double depth)
{
    const ClipConvention convention = view.convention();
    double z = convention.order == DepthOrder::near_is_large ? 1.0 - depth : depth;
    z = convention.range == DepthRange::minus_one_to_one ? 2.0 * z - 1.0 : z;
    const glm::dvec4 p = relative_from_clip * glm::dvec4{x, y, z, 1.0};
    return p.w > 0.0 ? glm::dvec3{p} / p.w + view.origin()
                     : glm::dvec3{std::numeric_limits<double>::quiet_NaN()};
}

// The farthest depth at which a device may draw the unit square under `world_from_unit`. Infinity
// if the square does not cover the rectangle from `low` to `high` (normalised), or if its corners
// lie beyond the rectangle by more than `slack`, or if it is no rectangle on the screen.
double farthest_if_covering(const View& view, const glm::mat4& world_from_unit,
                            const glm::dvec2& low, const glm::dvec2& high, double slack)
{
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const glm::dmat4& clip = view.clip_from_relative();
    const glm::dvec4 origin{view.origin(), 0.0};
    double farthest = 0.0;
    for (int k = 0; k < 4; ++k) {
        const glm::dvec4 unit{k & 1, k >> 1, 0.0, 1.0};
        const glm::dvec4 relative = glm::dmat4{world_from_unit} * unit - origin;
        // The map itself is applied in float as well.
        const glm::dvec3 reach = glm::abs(glm::dvec3{world_from_unit[0]}) +
                                 glm::abs(glm::dvec3{world_from_unit[1]}) +
                                 glm::abs(glm::dvec3{world_from_unit[3]} - view.origin());
        const ScreenPoint p = to_screen(clip * relative, clip_slop(view, reach), view.convention());
        const glm::dvec2 sign{(k & 1) != 0 ? 1.0 : -1.0, (k & 2) != 0 ? 1.0 : -1.0};
        const glm::dvec2 inner{(k & 1) != 0 ? high.x : low.x, (k & 2) != 0 ? high.y : low.y};
        const glm::dvec2 beyond = sign * (glm::dvec2{p.at} - inner) - glm::dvec2{p.error};
        if (!p.before_eye || std::min(beyond.x, beyond.y) < 0.0 ||
            std::max(beyond.x, beyond.y) > slack) {
            return kInfinity;
        }
        farthest = std::max(farthest, p.at.z + p.error.z);
    }
    return farthest;
}

} // namespace

std::optional<glm::mat4> world_from_rectangle(const View& view, const PixelRect& rect, float depth)
{
    const glm::ivec2 size_px = view.size_px();
    const bool inside = rect.width > 0 && rect.height > 0 && is_inside(rect, size_px);
    OCCLUDE_ASSERT(inside, "world_from_rectangle needs a rectangle with pixels, in the target");
    if (!inside) {
        return std::nullopt;
    }
    // The square is larger than the pixels by this much, for vertex snapping and the rounding here.
    constexpr double kOutsetPixels = 1.0 / 8.0;
    const glm::dvec2 size{size_px};
    const glm::dvec2 low = 2.0 * glm::dvec2{rect.x, rect.y} / size - 1.0;
    const glm::dvec2 high =
        2.0 * glm::dvec2{rect.x + rect.width, rect.y + rect.height} / size - 1.0;
    const glm::dvec2 outset = 2.0 * kOutsetPixels / size;
    const glm::dvec2 snap = 0.25 * outset; // 1/32 px of it must be left on the device
    const glm::dmat4 relative_from_clip = glm::inverse(view.clip_from_relative());

    // First at the given depth, then nearer by the amount that a device may draw it too far.
    double at = depth;
    for (int attempt = 0; attempt < 2; ++attempt) {
        const auto corner = [&](double x, double y) {
            return unproject(relative_from_clip, view, x, y, at);
        };
        const glm::dvec3 origin = corner(low.x - outset.x, low.y - outset.y);
        const glm::dvec3 right = corner(high.x + outset.x, low.y - outset.y) - origin;
        const glm::dvec3 up = corner(low.x - outset.x, high.y + outset.y) - origin;
        const glm::dvec3 toward = glm::cross(right, up); // keeps the map invertible
        const glm::dvec3 normal = toward * (glm::length(right) / glm::length(toward));
        const glm::mat4 map{glm::dmat4{glm::dvec4{right, 0.0}, glm::dvec4{up, 0.0},
                                       glm::dvec4{normal, 0.0}, glm::dvec4{origin, 1.0}}};
        const double farthest = farthest_if_covering(view, map, low - snap, high + snap,
                                                     2.0 * std::max(outset.x, outset.y));
        if (!(farthest < 2.0)) {
            return std::nullopt;
        }
        const Aabb unit_square{glm::vec3{0.0f}, {1.0f, 1.0f, 0.0f}};
        if (farthest <= depth) {
            return view.touches_near(transformed(map, unit_square)) ? std::nullopt
                                                                    : std::optional{map};
        }
        at -= 1.5 * (farthest - at);
    }
    return std::nullopt;
}

} // namespace occlude
