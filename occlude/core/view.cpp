#include <occlude/core/detail/view_math.h>
#include <occlude/core/view.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

namespace occlude {

using detail::common_zero;
using detail::kRoundedUp;
using detail::largest;

namespace {

// Boxes grow by this share of a pixel, which is four snaps: rasterisers snap vertices to 1/256 px,
// and they snap the box and its contents separately.
constexpr double kInflatePixels = 1.0 / 64.0;

// A device transforms in float, first to world space and then to clip space: two sums of four
// products, so that at most eight roundings, each of 2^-24 of the sum of the absolute terms, lie
// between its clip coordinates and the exact ones.
constexpr double kDeviceRounding = 8.0 * 0x1p-24;
// The tested box and the drawn item go through two such streams.
constexpr double kStreams = 2.0;
// On the screen, w is at least this many times its rounding error; otherwise rule R1 applies. So
// rounding changes w by at most an eighth of itself.
constexpr double kLeastWOverRounding = 8.0;

bool all_finite(const glm::dmat4& m)
{
    for (int c = 0; c < 4; ++c) {
        for (int r = 0; r < 4; ++r) {
            if (!std::isfinite(m[c][r])) {
                return false;
            }
        }
    }
    return true;
}

// True where w is the same everywhere. Rows are compared with each other, so that neither the unit
// of the world nor the scale of the matrix matters: over a distance that moves a point across the
// screen, w would change by less than 1e-12 of itself.
bool is_orthographic(const glm::dmat4& rows)
{
    const double across =
        std::max(glm::length(glm::dvec3{rows[0]}), glm::length(glm::dvec3{rows[1]}));
    return glm::length(glm::dvec3{rows[3]}) <= 1e-12 * std::max(across, std::abs(rows[3].w));
}

// Displacements at constant w that move a point at w = 1 by one pixel to the right, or up, and not
// along the other axis. Pixels at point p move with the rows x - s * w and y - t * w, where s and t
// depend on p; the parts of the rows perpendicular to w are the same for every s and t.
struct PixelSteps {
    glm::dvec3 right;
    glm::dvec3 up;
    double longest; // the largest displacement that moves a point by one pixel in some direction
};

PixelSteps pixel_steps(const glm::dmat4& rows, glm::ivec2 size_px)
{
    const glm::dvec3 toward_w{rows[3]};
    const double w_squared = glm::dot(toward_w, toward_w);
    const auto perpendicular = [&](const glm::dvec3& row) {
        return w_squared > 0.0 ? row - toward_w * (glm::dot(row, toward_w) / w_squared) : row;
    };
    const glm::dvec3 across = perpendicular(glm::dvec3{rows[0]}) * (0.5 * size_px.x);
    const glm::dvec3 up = perpendicular(glm::dvec3{rows[1]}) * (0.5 * size_px.y);
    const double xx = glm::dot(across, across);
    const double yy = glm::dot(up, up);
    const double xy = glm::dot(across, up);
    const double area = xx * yy - xy * xy;
    const double larger = 0.5 * (xx + yy) + std::sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy);
    // The dual basis, and the reciprocal of the smaller singular value.
    return {(across * yy - up * xy) / area, (up * xx - across * xy) / area,
            std::sqrt(larger / area)};
}

// From the eye to the farthest corner of the near rectangle; infinite if a corner is not before
// the eye, as under a very oblique near plane.
double corner_reach(const glm::dmat4& relative_from_clip, const glm::dvec3& eye, double z_near)
{
    double reach = 0.0;
    for (const double x : {-1.0, 1.0}) {
        for (const double y : {-1.0, 1.0}) {
            const glm::dvec4 corner = relative_from_clip * glm::dvec4{x, y, z_near, 1.0};
            const double distance = glm::length(glm::dvec3{corner} / corner.w - eye);
            const bool before_eye = corner.w > 0.0 && std::isfinite(distance);
            reach = std::max(reach, before_eye ? distance : double{Aabb::kInfinity});
        }
    }
    return reach;
}

// The largest distance from the eye of a point on the screen at w = 1: at one of the corners.
double distance_per_w(const glm::dmat4& rows)
{
    const glm::dmat3 from_xyw = glm::inverse(
        glm::transpose(glm::dmat3{glm::dvec3{rows[0]}, glm::dvec3{rows[1]}, glm::dvec3{rows[3]}}));
    double most = 0.0;
    for (const double x : {-1.0, 1.0}) {
        for (const double y : {-1.0, 1.0}) {
            most = std::max(most, glm::length(from_xyw * glm::dvec3{x, y, 1.0}));
        }
    }
    return most;
}

glm::dmat4 magnitude_of(const glm::dmat4& m)
{
    return {detail::absolute(m[0]), detail::absolute(m[1]), detail::absolute(m[2]),
            detail::absolute(m[3])};
}

// `map` after a translation by `offset`.
glm::dmat4 translated(const glm::dmat4& map, const glm::dvec3& offset)
{
    glm::dmat4 result = map;
    result[3] = map * glm::dvec4{offset, 1.0};
    return result;
}

} // namespace

View View::from_clip(const glm::mat4& clip_from_world, glm::ivec2 size_px,
                     ClipConvention convention, const ViewOptions& options)
{
    View view;
    view.clip_from_world_ = clip_from_world;
    view.size_px_ = size_px;
    view.convention_ = convention;
    view.options_ = options;
    const glm::dmat4 clip{clip_from_world};
    view.clip_from_relative_ = clip;
    if (!all_finite(clip) || glm::determinant(clip) == 0.0) {
        return view;
    }
    const glm::dmat4 rows = glm::transpose(clip);
    const bool reversed = convention.order == DepthOrder::near_is_large;
    const double z_low = convention.range == DepthRange::minus_one_to_one ? -1.0 : 0.0;
    const glm::dvec4 from =
        is_orthographic(rows)
            ? glm::inverse(clip) * glm::dvec4{0.0, 0.0, reversed ? 1.0 : z_low, 1.0}
            : common_zero(rows[0], rows[1], rows[3]);
    const glm::dvec3 origin = glm::dvec3{from} / from.w;
    // Its rounded terms are world positions: (position - origin), and the origin.
    glm::dmat4 magnitude = magnitude_of(clip);
    magnitude[3] += magnitude * glm::dvec4{detail::absolute(origin), 0.0};
    view.set_camera(translated(clip, origin), origin, magnitude);
    return view;
}

View View::camera_relative(const glm::mat4& clip_from_relative, const glm::dvec3& origin,
                           glm::ivec2 size_px, ClipConvention convention,
                           const ViewOptions& options)
{
    View view;
    const glm::dmat4 clip{clip_from_relative};
    view.clip_from_world_ = glm::mat4{translated(clip, -origin)};
    view.clip_from_relative_ = clip;
    view.size_px_ = size_px;
    view.convention_ = convention;
    view.options_ = options;
    view.set_camera(clip, origin, magnitude_of(clip));
    return view;
}

View View::in_object(const glm::mat4& world_from_object) const
{
    View view;
    const glm::dmat4 map{world_from_object};
    const glm::dmat3 linear{map};
    const glm::dvec3 away = origin_ - glm::dvec3{map[3]};
    view.clip_from_relative_ = translated(clip_from_relative_, -away) * glm::dmat4{linear};
    view.clip_from_world_ = glm::mat4{view.clip_from_relative_};
    view.size_px_ = size_px_;
    view.convention_ = convention_;
    view.options_ = options_;
    if (!usable_ || inverse_stretch(world_from_object) == 0.0f) {
        return view;
    }
    const glm::dvec3 origin = glm::inverse(linear) * away;
    const glm::dmat4 rounding = glm::dmat4{rounding_} / kDeviceRounding;
    glm::dmat4 magnitude = rounding * magnitude_of(glm::dmat4{linear});
    magnitude[3] = rounding[3] + rounding * glm::dvec4{detail::absolute(away), 0.0} +
                   magnitude * glm::dvec4{detail::absolute(origin), 0.0};
    view.set_camera(clip_from_relative_ * glm::dmat4{linear}, origin, magnitude);
    return view;
}

// `magnitude`: like clip_from_relative, with the sums of the absolute terms that a device may
// round.
void View::set_camera(const glm::dmat4& clip_from_relative, const glm::dvec3& origin,
                      const glm::dmat4& magnitude)
{
    const bool finite = all_finite(clip_from_relative) && all_finite(magnitude) &&
                        std::isfinite(glm::dot(origin, origin));
    if (!finite || glm::determinant(clip_from_relative) == 0.0 || size_px_.x <= 0 ||
        size_px_.y <= 0) {
        return; // the frustum culls nothing, and every box touches the near plane
    }
    clip_from_relative_ = clip_from_relative;
    origin_ = origin;
    const glm::dmat4 rows = glm::transpose(clip_from_relative);
    orthographic_ = is_orthographic(rows);
    glm::dvec3 eye{0.0};
    if (!orthographic_) {
        const glm::dvec4 zero = common_zero(rows[0], rows[1], rows[3]);
        eye = glm::dvec3{zero} / zero.w;
        eye_ = glm::vec3{eye + origin};
    }
    if (!set_inflation(rows, magnitude) || !std::isfinite(glm::dot(eye_, eye_))) {
        eye_ = glm::vec3{0.0f};
        return; // nearly singular, or the eye is nowhere
    }
    rounding_ = glm::mat4{magnitude * (kDeviceRounding * kRoundedUp)};
    frustum_ = Frustum::from_relative(clip_from_relative, origin, convention_, rounding_[3],
                                      options_.ignores_near_plane);
    set_near_rules(rows, magnitude, eye);
    usable_ = true;
}

// The terms of rule R2 that docs/conventions.md derives. False if the matrix is nearly singular.
bool View::set_inflation(const glm::dmat4& rows, const glm::dmat4& magnitude)
{
    const PixelSteps steps = pixel_steps(rows, size_px_);
    const double per_w = kInflatePixels * steps.longest;
    if (!std::isfinite(static_cast<float>(per_w))) {
        return false;
    }
    inflation_.origin = glm::vec3{origin_};
    inflation_.per_w = static_cast<float>(per_w);
    inflation_.row_w = glm::vec4{glm::dvec4{
        glm::dvec3{rows[3]},
        rows[3].w + glm::dot(glm::dvec3{rows[3]}, glm::dvec3{inflation_.origin} - origin_)}};

    // Rounding of x, y and w moves a point by this much across the screen, in world units: for each
    // unit of its distance from the origin, and for the constant terms.
    const glm::dvec2 unit =
        0.5 * glm::dvec2{size_px_} * glm::dvec2{glm::length(steps.right), glm::length(steps.up)};
    const auto moved_by = [&](const glm::dvec4& clip_error) {
        return kStreams * kDeviceRounding *
               (unit.x * (clip_error.x + clip_error.w) + unit.y * (clip_error.y + clip_error.w));
    };
    const double per_coordinate = moved_by(magnitude[0] + magnitude[1] + magnitude[2]);
    inflation_.per_coordinate = static_cast<float>(per_coordinate * kRoundedUp);
    const double beside = largest(glm::dvec3{inflation_.origin} - origin_);
    inflation_.reach =
        static_cast<float>((moved_by(magnitude[3]) / per_coordinate + beside) * kRoundedUp);

    // Across the screen at constant w, window depth is a linear function of the position: its
    // slope is 0 unless the near plane is oblique.
    const double to_window = convention_.range == DepthRange::minus_one_to_one ? 0.5 : 1.0;
    const glm::dvec3 depth_row = to_window * glm::dvec3{rows[2]};
    inflation_.depth_bias = static_cast<float>(
        kInflatePixels * kRoundedUp *
        (std::abs(glm::dot(depth_row, steps.right)) + std::abs(glm::dot(depth_row, steps.up))));
    return std::isfinite(inflation_.per_coordinate) && std::isfinite(inflation_.reach) &&
           std::isfinite(inflation_.depth_bias);
}

void View::set_near_rules(const glm::dmat4& rows, const glm::dmat4& magnitude,
                          const glm::dvec3& eye)
{
    const bool reversed = convention_.order == DepthOrder::near_is_large;
    const double z_low = convention_.range == DepthRange::minus_one_to_one ? -1.0 : 0.0;
    eye_offset_ = glm::vec3{eye + (origin_ - glm::dvec3{inflation_.origin})};
    // The distance to the plane is a sum of four terms, and each of them rounds.
    constexpr double kSumRounding = 16.0 * 0x1p-24;
    double per_distance = kSumRounding * 2.0;
    const double beside = largest(glm::dvec3{inflation_.origin} - origin_);
    double constant = kSumRounding * std::abs(double{frustum_.plane_from_origin(Frustum::near).w});
    near_reach_ = 0.0f;
    if (!orthographic_) {
        // What is on the screen at a distance d from the eye has a w of at least d / this.
        const double per_w = distance_per_w(rows);
        const glm::dvec4 sums = magnitude[0] + magnitude[1] + magnitude[2];
        const double least = kLeastWOverRounding * kDeviceRounding * per_w;
        per_distance += least * sums.w;
        constant += least * (magnitude[3].w + sums.w * beside);
        const double reach =
            corner_reach(glm::inverse(clip_from_relative_), eye, reversed ? 1.0 : z_low);
        near_reach_ = options_.ignores_near_plane ? 0.0f : static_cast<float>(reach * (1.0 + 1e-5));
    }
    near_slop_ = glm::vec2{glm::dvec2{per_distance, constant} * kRoundedUp};
}

float View::distance_key(const Aabb& box) const
{
    if (!box.is_bounded()) {
        return box.is_empty() ? Aabb::kInfinity : -Aabb::kInfinity;
    }
    if (!orthographic_) {
        return distance_squared(box, eye_);
    }
    const glm::vec4& plane = frustum_.plane_from_origin(Frustum::near);
    const glm::vec3 normal{plane};
    return glm::dot(normal, box.center() - inflation_.origin) + plane.w -
           0.5f * glm::dot(glm::abs(normal), box.extent());
}

// Corners instead of centre and extent, because then every step is monotone in the box, rounding
// included: a box inside another touches only if the outer one does.
bool View::touches_near(const Aabb& box) const
{
    if (!usable_ || !box.is_bounded()) {
        return true;
    }
    const glm::vec3 low = box.min - inflation_.origin;
    const glm::vec3 high = box.max - inflation_.origin;
    const glm::vec3 magnitude = glm::max(detail::absolute(low), detail::absolute(high));
    const float distance = std::max({magnitude.x, magnitude.y, magnitude.z});
    const float slop = near_slop_.x * distance + near_slop_.y;
    if (!options_.ignores_near_plane) {
        const glm::vec4& plane = frustum_.plane_from_origin(Frustum::near);
        const glm::vec3 normal{plane};
        const glm::vec3 least = glm::min(normal * low, normal * high);
        if (least.x + least.y + least.z + plane.w > slop) {
            return false; // wholly beyond the near plane
        }
    }
    if (orthographic_) {
        return !options_.ignores_near_plane;
    }
    const glm::vec3 outside =
        glm::max(glm::max(low - eye_offset_, eye_offset_ - high), glm::vec3{0.0f});
    const float reach = near_reach_ + slop;
    // Negated, so that a NaN from overflow counts as touching.
    return !(glm::dot(outside, outside) > reach * reach);
}

Aabb View::inflated_for_test(const Aabb& box) const
{
    if (!box.is_bounded()) {
        return box;
    }
    // Corners are rounded to float, too, by at most half of this.
    const glm::vec3 magnitude = glm::max(detail::absolute(box.min), detail::absolute(box.max));
    const float ulp = 0x1p-23f * std::max({magnitude.x, magnitude.y, magnitude.z});
    return inflated(box, inflation_.margin(box) + ulp);
}

} // namespace occlude
