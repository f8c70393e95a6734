#include <occlude/conformance/detail/ray_world.h>

#include <glm/common.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

namespace occlude::conformance {

namespace {

// How much nearer than the drawn surface a box must be, as a share of the ray between near and far
// plane, so that rounding in a device's depth does not matter.
constexpr double kClearlyNearer = 1e-3;

glm::dvec3 divided(const glm::dvec4& clip)
{
    return glm::dvec3{clip} / clip.w;
}

} // namespace

double entry(const Ray& ray, const Aabb& box)
{
    double enter = 0.0;
    double leave = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = static_cast<double>(box.min[axis]) - ray.origin[axis];
        const double high = static_cast<double>(box.max[axis]) - ray.origin[axis];
        const double along = ray.direction[axis];
        if (along == 0.0) {
            if (low > 0.0 || high < 0.0) {
                return std::numeric_limits<double>::infinity();
            }
            continue;
        }
        enter = std::max(enter, std::min(low / along, high / along));
        leave = std::min(leave, std::max(low / along, high / along));
    }
    return enter <= leave ? enter : std::numeric_limits<double>::infinity();
}

RayCamera::RayCamera(const View& view)
    : clip_from_world_(view.clip_from_world())
    , world_from_clip_(glm::inverse(glm::dmat4{view.clip_from_world()}))
    , convention_(view.convention())
    , size_px_(view.size_px())
{
}

Ray RayCamera::through(const glm::dvec2& point_px) const
{
    const glm::dvec2 ndc = point_px / glm::dvec2{size_px_} * 2.0 - 1.0;
    const double low = convention_.range == DepthRange::zero_to_one ? 0.0 : -1.0;
    const bool reversed = convention_.order == DepthOrder::near_is_large;
    const glm::dvec3 near = divided(world_from_clip_ * glm::dvec4{ndc, reversed ? 1.0 : low, 1.0});
    const glm::dvec3 far = divided(world_from_clip_ * glm::dvec4{ndc, reversed ? low : 1.0, 1.0});
    return {near, far - near};
}

double RayCamera::depth01(const glm::dvec3& point) const
{
    const double z = divided(clip_from_world_ * glm::dvec4{point, 1.0}).z;
    const double stored = convention_.range == DepthRange::zero_to_one ? z : 0.5 * z + 0.5;
    return convention_.order == DepthOrder::near_is_large ? 1.0 - stored : stored;
}

std::array<glm::dvec2, 5> probes(int x, int y)
{
    const glm::dvec2 corner{x, y};
    // Slightly beyond the pixel's own corners, so that snapping a vertex cannot uncover a sample.
    constexpr double kLow = -0.05;
    constexpr double kHigh = 1.05;
    return {corner + 0.5, corner + kLow, corner + glm::dvec2{kHigh, kLow},
            corner + glm::dvec2{kLow, kHigh}, corner + kHigh};
}

Hit first_hit(const Ray& ray, std::span<const Aabb> boxes, std::span<const size_t> drawn)
{
    Hit first;
    for (const size_t item : drawn) {
        const double at = entry(ray, boxes[item]);
        if (at < first.at) {
            first = {item, at};
        }
    }
    return first;
}

bool surely_visible(const RayCamera& camera, const Aabb& box, std::span<const Aabb> boxes,
                    std::span<const size_t> drawn)
{
    for (int y = 0; y < camera.size_px().y; ++y) {
        for (int x = 0; x < camera.size_px().x; ++x) {
            const auto points = probes(x, y);
            const bool visible = std::all_of(points.begin(), points.end(), [&](glm::dvec2 point) {
                const Ray ray = camera.through(point);
                const double at = entry(ray, box);
                return at < 1.0 && at + kClearlyNearer < first_hit(ray, boxes, drawn).at;
            });
            if (visible) {
                return true;
            }
        }
    }
    return false;
}

} // namespace occlude::conformance
