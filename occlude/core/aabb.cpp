#include <occlude/core/aabb.h>

#include <occlude/core/assert.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <cmath>

namespace occlude {

float surface_area(const Aabb& box)
{
    if (box.is_empty()) {
        return 0.0f;
    }
    if (!box.is_bounded()) {
        return Aabb::kInfinity; // not the formula: infinite times flat is NaN
    }
    const glm::vec3 e = box.extent();
    return 2.0f * (e.x * e.y + e.y * e.z + e.z * e.x);
}

Aabb inflated(const Aabb& box, float margin)
{
    OCCLUDE_ASSERT(!(margin < 0.0f), "inflated() cannot shrink a box: the margin is negative");
    return box.is_empty() || margin < 0.0f ? box : Aabb{box.min - margin, box.max + margin};
}

Aabb transformed(const glm::mat4& to_from, const Aabb& box)
{
    if (box.is_empty()) {
        return box;
    }
    if (!box.is_bounded()) {
        return Aabb::everything();
    }
    // Interval arithmetic, column by column (Arvo, Graphics Gems 1990), in double. Products of
    // floats are exact there; the three sums round, which `slop` covers; and the rounding to float
    // goes outward by one step.
    glm::dvec3 low{to_from[3]};
    glm::dvec3 high = low;
    glm::dvec3 magnitude = glm::abs(low);
    for (int column = 0; column < 3; ++column) {
        const glm::dvec3 axis{to_from[column]};
        const glm::dvec3 a = axis * static_cast<double>(box.min[column]);
        const glm::dvec3 b = axis * static_cast<double>(box.max[column]);
        low += glm::min(a, b);
        high += glm::max(a, b);
        magnitude += glm::max(glm::abs(a), glm::abs(b));
    }
    const glm::dvec3 slop = 4.0 * 0x1p-53 * magnitude;
    low -= slop;
    high += slop;
    Aabb result;
    for (int axis = 0; axis < 3; ++axis) {
        result.min[axis] = std::nextafter(static_cast<float>(low[axis]), -Aabb::kInfinity);
        result.max[axis] = std::nextafter(static_cast<float>(high[axis]), Aabb::kInfinity);
    }
    return sanitized(result);
}

float distance_squared(const Aabb& box, const glm::vec3& point)
{
    if (box.is_empty()) {
        return Aabb::kInfinity;
    }
    if (box.has_nan()) {
        return 0.0f;
    }
    const glm::vec3 outside = glm::max(glm::max(box.min - point, point - box.max), glm::vec3{0.0f});
    return glm::dot(outside, outside);
}

} // namespace occlude
