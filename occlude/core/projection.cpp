#include <occlude/core/projection.h>

#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace occlude {

namespace {

// A device transforms in float, perhaps to world space first: so many roundings of the largest term
// lie between its clip coordinates and ours.
constexpr double kTransformSlop = 8.0 * 0x1p-24;

// The x, y and window depth of all corners, smallest and largest, with the rounding of a device.
struct CornerRange {
    glm::dvec3 low{std::numeric_limits<double>::infinity()};
    glm::dvec3 high{-std::numeric_limits<double>::infinity()};
    bool before_eye = true; // all corners are beyond the near plane, with w > 0
};

CornerRange project_corners(const View& view, const Aabb& box)
{
    const glm::dmat4 clip{view.clip_from_world()};
    const ClipConvention convention = view.convention();
    const glm::dvec4 low_corner = clip * glm::dvec4{glm::dvec3{box.min}, 1.0};
    const glm::dvec3 extent = glm::dvec3{box.max} - glm::dvec3{box.min};
    const glm::dvec3 reach = glm::max(glm::abs(glm::dvec3{box.min}), glm::abs(glm::dvec3{box.max}));
    const glm::dvec4 slop =
        kTransformSlop * (glm::abs(clip[0]) * reach.x + glm::abs(clip[1]) * reach.y +
                          glm::abs(clip[2]) * reach.z + glm::abs(clip[3]));

    CornerRange range;
    for (int k = 0; k < 8; ++k) {
        glm::dvec4 c = low_corner;
        for (int axis = 0; axis < 3; ++axis) {
            if ((k >> axis & 1) != 0) {
                c += clip[axis] * extent[axis];
            }
        }
        // From here on z runs from 0 (near) to w (far) in every convention.
        double slop_z = slop.z;
        if (convention.range == DepthRange::minus_one_to_one) {
            c.z = 0.5 * (c.z + c.w);
            slop_z = 0.5 * (slop_z + slop.w);
        }
        if (convention.order == DepthOrder::near_is_large) {
            c.z = c.w - c.z;
            slop_z += slop.w;
        }
        // Negated, so that a NaN from overflow counts as behind the eye.
        if (!(c.z > slop_z && c.w > 2.0 * slop.w)) {
            range.before_eye = false;
            return range;
        }
        const glm::dvec3 p = glm::dvec3{c} / c.w;
        // (v + dv) / (w + dw) differs from v / w by at most (dv + |v / w| dw) / (w - dw).
        const glm::dvec3 error =
            (glm::dvec3{slop.x, slop.y, slop_z} + glm::abs(p) * slop.w) / (c.w - slop.w);
        range.low = glm::min(range.low, p - error);
        range.high = glm::max(range.high, p + error);
    }
    return range;
}

// First and one past last pixel along one axis, from normalised device coordinates.
glm::ivec2 pixel_range(double low, double high, int size)
{
    const double first = std::floor((0.5 * low + 0.5) * size);
    const double end = std::ceil((0.5 * high + 0.5) * size);
    const double limit = size;
    return {static_cast<int>(std::clamp(first, 0.0, limit)),
            static_cast<int>(std::clamp(end, 0.0, limit))};
}

ScreenBounds everywhere(const View& view)
{
    const glm::ivec2 size = glm::max(view.size_px(), glm::ivec2{0});
    ScreenBounds bounds;
    bounds.rect = {0, 0, size.x, size.y};
    return bounds;
}

} // namespace

ScreenBounds project(const View& view, const Aabb& box)
{
    if (box.is_empty()) {
        return {PixelRect{}, 1.0f, 1.0f, true};
    }
    const Aabb grown = view.inflated_for_test(box);
    if (view.touches_near(grown)) {
        return everywhere(view);
    }
    const CornerRange range = project_corners(view, grown);
    if (!range.before_eye) {
        return everywhere(view);
    }
    // Depth is a linear fraction of position with a positive denominator, so its extremes over the
    // box are at corners, and so are those of x and y.
    constexpr double kMargin = ScreenBounds::kDepthMargin;
    ScreenBounds bounds;
    bounds.valid = true;
    bounds.near_depth = static_cast<float>(std::clamp(range.low.z - kMargin, 0.0, 1.0));
    bounds.far_depth = static_cast<float>(std::clamp(range.high.z + kMargin, 0.0, 1.0));
    const glm::ivec2 x = pixel_range(range.low.x, range.high.x, view.size_px().x);
    const glm::ivec2 y = pixel_range(range.low.y, range.high.y, view.size_px().y);
    if (x[0] < x[1] && y[0] < y[1]) {
        bounds.rect = {x[0], y[0], x[1] - x[0], y[1] - y[0]};
    }
    return bounds;
}

} // namespace occlude
