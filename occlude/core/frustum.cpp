#include <occlude/core/frustum.h>

#include <occlude/core/absolute.h>
#include <occlude/core/detail/float4.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <cmath>

namespace occlude {

// Rounding of centre, extent and dot product: a few ulps of the largest term.
static constexpr float kSlop = 1e-6f;

// A plane bounds nothing if its normal vanishes beside `scale`, the length of the normal of the row
// of w: it is the far plane of an infinite projection after rounding.
void Frustum::set_plane(Plane which, const glm::dvec4& relative_plane, const glm::dvec3& origin,
                        double scale, double rounding)
{
    const double length = glm::length(glm::dvec3{relative_plane});
    const bool bounds = std::isfinite(length) && std::isfinite(relative_plane.w) && length > 0.0 &&
                        length > 1e-6 * scale;
    if (!bounds) {
        return;
    }
    const glm::dvec4 plane = relative_plane / length;
    const glm::dvec3 normal{plane};
    planes_[which] = glm::vec4{glm::dvec4{normal, plane.w - glm::dot(normal, origin)}};
    const glm::dvec3 beside = glm::dvec3{origin_} - origin;
    const double offset = plane.w + glm::dot(normal, beside);
    from_origin_[which] = glm::vec4{glm::dvec4{normal, offset}};
    lanes_.x[which] = from_origin_[which].x;
    lanes_.y[which] = from_origin_[which].y;
    lanes_.z[which] = from_origin_[which].z;
    lanes_.w[which] = from_origin_[which].w;
    lanes_.slop[which] =
        std::abs(from_origin_[which].w) +
        static_cast<float>(glm::dot(detail::absolute(normal), detail::absolute(beside)) +
                           rounding / length / double{kSlop});
}

Frustum Frustum::from_relative(const glm::dmat4& clip_from_relative, const glm::dvec3& origin,
                               ClipConvention convention, const glm::vec4& rounding,
                               bool ignores_near_plane)
{
    const glm::dmat4 rows = glm::transpose(clip_from_relative);
    const glm::dvec4 x = rows[0];
    const glm::dvec4 y = rows[1];
    const glm::dvec4 z = rows[2];
    const glm::dvec4 w = rows[3];

    const glm::dvec4 low_z = convention.range == DepthRange::minus_one_to_one ? w + z : z;
    const glm::dvec4 high_z = w - z;
    const bool reversed = convention.order == DepthOrder::near_is_large;

    // Rows (Gribb and Hartmann 2001): a point is inside where w + x >= 0, and so on.
    const double scale = glm::length(glm::dvec3{w});
    const glm::dvec4 slop = glm::dvec4{rounding} + double{rounding.w};
    Frustum frustum;
    frustum.origin_ = glm::vec3{origin};
    frustum.set_plane(left, w + x, origin, scale, slop.x);
    frustum.set_plane(right, w - x, origin, scale, slop.x);
    frustum.set_plane(bottom, w + y, origin, scale, slop.y);
    frustum.set_plane(top, w - y, origin, scale, slop.y);
    frustum.set_plane(near, reversed ? high_z : low_z, origin, scale, slop.z);
    frustum.set_plane(far, reversed ? low_z : high_z, origin, scale, slop.z);
    if (ignores_near_plane) {
        frustum.lanes_.x[near] = frustum.lanes_.y[near] = frustum.lanes_.z[near] = 0.0f;
        frustum.lanes_.w[near] = frustum.lanes_.slop[near] = 0.0f;
    }
    return frustum;
}

Frustum Frustum::from_clip(const glm::mat4& clip_from_world, ClipConvention convention)
{
    return from_relative(glm::dmat4{clip_from_world}, glm::dvec3{0.0}, convention, glm::vec4{0.0f},
                         false);
}

// Four planes at once. Sums have the order of glm::dot, so that the results equal a loop over the
// planes (Frustum.FourPlanesAtOnceAnswerAsOneByOne).
Containment Frustum::classify(const Aabb& box, PlaneMask& mask) const
{
    using namespace detail;
    if (!box.is_bounded()) {
        return box.is_empty() ? Containment::outside : Containment::intersects;
    }
    if (mask == 0) {
        return Containment::inside;
    }
    // Corners first: far from the world's origin, a centre would round more than the corners do.
    const Aabb relative{box.min - origin_, box.max - origin_};
    const glm::vec3 center = relative.center();
    const glm::vec3 half = 0.5f * relative.extent();
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
                                     abs4(z) * far_from_origin.z + load4(&lanes_.slop[i]) + reach);
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
    const glm::vec3 offset = center - origin_;
    for (size_t i = 0; i < plane_count; ++i) {
        const auto bit = static_cast<PlaneMask>(1u << i);
        if ((mask & bit) == 0) {
            continue;
        }
        const glm::vec3 normal{lanes_.x[i], lanes_.y[i], lanes_.z[i]};
        const float distance = glm::dot(normal, offset) + lanes_.w[i];
        const float slop = kSlop * (glm::dot(detail::absolute(normal), detail::absolute(offset)) +
                                    lanes_.slop[i] + radius);
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
