#include <occlude/core/frustum.h>

#include <occlude/core/absolute.h>
#include <occlude/core/detail/float4.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <cmath>

namespace occlude {

// A plane at unit normal. Planes whose normal vanishes beside `scale`, the length of the w row's
// normal, bound nothing: they are the far planes of infinite projections after rounding.
static glm::vec4 normalized_plane(const glm::dvec4& plane, double scale)
{
    const double length = glm::length(glm::dvec3{plane});
    const bool bounds =
        std::isfinite(length) && std::isfinite(plane.w) && length > 0.0 && length > 1e-6 * scale;
    return bounds ? glm::vec4{plane / length} : glm::vec4{0.0f};
}

Frustum Frustum::from_clip(const glm::mat4& clip_from_world, ClipConvention convention)
{
    const glm::dmat4 rows = glm::transpose(glm::dmat4{clip_from_world});
    const glm::dvec4 x = rows[0];
    const glm::dvec4 y = rows[1];
    const glm::dvec4 z = rows[2];
    const glm::dvec4 w = rows[3];

    const glm::dvec4 low_z = convention.range == DepthRange::minus_one_to_one ? w + z : z;
    const glm::dvec4 high_z = w - z;
    const bool reversed = convention.order == DepthOrder::near_is_large;

    // Rows (Gribb and Hartmann 2001): a point is inside where w + x >= 0, and so on.
    const double scale = glm::length(glm::dvec3{w});
    Frustum frustum;
    frustum.planes_[left] = normalized_plane(w + x, scale);
    frustum.planes_[right] = normalized_plane(w - x, scale);
    frustum.planes_[bottom] = normalized_plane(w + y, scale);
    frustum.planes_[top] = normalized_plane(w - y, scale);
    frustum.planes_[near] = normalized_plane(reversed ? high_z : low_z, scale);
    frustum.planes_[far] = normalized_plane(reversed ? low_z : high_z, scale);
    for (size_t i = 0; i < plane_count; ++i) {
        frustum.lanes_.x[i] = frustum.planes_[i].x;
        frustum.lanes_.y[i] = frustum.planes_[i].y;
        frustum.lanes_.z[i] = frustum.planes_[i].z;
        frustum.lanes_.w[i] = frustum.planes_[i].w;
    }
    return frustum;
}

// Four planes at once. Sums are in the order of glm::dot, so that answers are those of a loop over
// the planes (Frustum.FourPlanesAtOnceAnswerAsOneByOne).
Containment Frustum::classify(const Aabb& box, PlaneMask& mask) const
{
    using namespace detail;
    if (!box.is_bounded()) {
        return box.is_empty() ? Containment::outside : Containment::intersects;
    }
    if (mask == 0) {
        return Containment::inside;
    }
    // Rounding of centre, extent and dot product: a few ulps of the largest term.
    constexpr float kSlop = 1e-6f;
    const glm::vec3 center = box.center();
    const glm::vec3 half = 0.5f * box.extent();
    const glm::vec3 far_from_origin = detail::absolute(center);
    uint32_t outside = 0;
    uint32_t inside = 0;
    for (size_t i = 0; i < 8; i += 4) {
        const Float4 x = load4(&lanes_.x[i]);
        const Float4 y = load4(&lanes_.y[i]);
        const Float4 z = load4(&lanes_.z[i]);
        const Float4 w = load4(&lanes_.w[i]);
        const Float4 distance = x * center.x + y * center.y + z * center.z + w;
        const Float4 reach = abs4(x) * half.x + abs4(y) * half.y + abs4(z) * half.z;
        const Float4 slop = kSlop * (abs4(x) * far_from_origin.x + abs4(y) * far_from_origin.y +
                                     abs4(z) * far_from_origin.z + abs4(w) + reach);
        outside |= bits_of(distance + reach < -slop) << i;
        inside |= bits_of(distance - reach >= slop) << i;
    }
    if ((outside & mask) != 0) {
        return Containment::outside;
    }
    mask = static_cast<PlaneMask>(mask & ~inside);
    return mask == 0 ? Containment::inside : Containment::intersects;
}

Containment Frustum::classify_sphere(const glm::vec3& center, float radius, PlaneMask& mask) const
{
    if (radius < 0.0f) {
        return Containment::outside;
    }
    if (!std::isfinite(glm::dot(center, center) + radius)) {
        return Containment::intersects;
    }
    constexpr float kSlop = 1e-6f; // as for boxes
    for (size_t i = 0; i < planes_.size(); ++i) {
        const auto bit = static_cast<PlaneMask>(1u << i);
        if ((mask & bit) == 0) {
            continue;
        }
        const glm::vec3 normal{planes_[i]};
        const float offset = planes_[i].w;
        const float distance = glm::dot(normal, center) + offset;
        const float slop = kSlop * (glm::dot(detail::absolute(normal), detail::absolute(center)) +
                                    std::abs(offset) + radius);
        const bool bounds_nothing = normal == glm::vec3{0.0f};
        if (!bounds_nothing && distance + radius < -slop) {
            return Containment::outside;
        }
        if (bounds_nothing || distance - radius >= slop) {
            mask = static_cast<PlaneMask>(mask & ~bit);
        }
    }
    return mask == 0 ? Containment::inside : Containment::intersects;
}

} // namespace occlude
