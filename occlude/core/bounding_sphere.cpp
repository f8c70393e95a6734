#include <occlude/core/bounding_sphere.h>

#include <occlude/core/assert.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>

namespace occlude {

BoundingSphere bounding_sphere(const Aabb& box)
{
    if (box.is_empty()) {
        return {};
    }
    if (!box.is_bounded()) {
        return {glm::vec3{0.0f}, Aabb::kInfinity};
    }
    const glm::vec3 center = box.center();
    // The corner farther from the rounded centre, and the rounding of the length itself.
    const glm::vec3 reach = glm::max(box.max - center, center - box.min);
    return {center, glm::length(reach) * (1.0f + 0x1p-21f)};
}

bool is_elongated(const Aabb& box, float ratio)
{
    OCCLUDE_ASSERT(ratio >= 1.0f, "is_elongated() needs a ratio of at least 1");
    if (!box.is_bounded()) {
        return false;
    }
    const glm::vec3 size = box.extent();
    std::array<float, 3> sides{size.x, size.y, size.z};
    std::sort(sides.begin(), sides.end());
    return sides[2] > ratio * sides[1];
}

Containment classify_sphere_first(const Frustum& frustum, const BoundingSphere& sphere,
                                  const Aabb& box, PlaneMask& mask, float elongation_ratio)
{
    const Containment ball = frustum.classify_sphere(sphere.center, sphere.radius, mask);
    const bool ask_box = ball == Containment::intersects && is_elongated(box, elongation_ratio);
    return ask_box ? frustum.classify(box, mask) : ball;
}

} // namespace occlude
