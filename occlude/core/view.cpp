#include <occlude/core/view.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

namespace occlude {

namespace {

// Boxes grow by this share of a pixel: rasterisers snap vertices to 1/256 px, and the box and what
// is in it are snapped apart. Four snaps wide.
constexpr float kInflatePixels = 1.0f / 64.0f;
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

// The point that rows x, y and w all map to 0: the eye, or a direction (w = 0) when orthographic.
glm::dvec4 common_zero(const glm::dvec4& x, const glm::dvec4& y, const glm::dvec4& w)
{
    const auto minor = [&](int a, int b, int c) {
        return glm::determinant(glm::dmat3{glm::dvec3{x[a], x[b], x[c]},
                                           glm::dvec3{y[a], y[b], y[c]},
                                           glm::dvec3{w[a], w[b], w[c]}});
    };
    return {minor(1, 2, 3), -minor(0, 2, 3), minor(0, 1, 3), -minor(0, 1, 2)};
}

// The largest world size, over the directions on the screen, of one pixel at clip w = 1. Pixels at
// point p move with the rows x - s * w and y - t * w, where s and t depend on p; what is
// perpendicular to w is left of them for every s and t. The least stretch of those two rows is
// their smaller singular value.
double largest_pixel_per_w(const glm::dvec4& x, const glm::dvec4& y, const glm::dvec4& w,
                           glm::ivec2 size_px)
{
    const glm::dvec3 toward_w{w};
    const double w_squared = glm::dot(toward_w, toward_w);
    const auto perpendicular = [&](const glm::dvec3& row) {
        return w_squared > 0.0 ? row - toward_w * (glm::dot(row, toward_w) / w_squared) : row;
    };
    const glm::dvec3 across = perpendicular(glm::dvec3{x}) * (0.5 * size_px.x);
    const glm::dvec3 up = perpendicular(glm::dvec3{y}) * (0.5 * size_px.y);
    const double xx = glm::dot(across, across);
    const double yy = glm::dot(up, up);
    const double xy = glm::dot(across, up);
    const double larger = 0.5 * (xx + yy) + std::sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy);
    return std::sqrt(larger / (xx * yy - xy * xy));
}

// From the eye to the farthest corner of the near rectangle; infinite if a corner is not before
// the eye, as under a very oblique near plane.
double corner_reach(const glm::dmat4& world_from_clip, const glm::dvec3& eye, double z_near)
{
    double reach = 0.0;
    for (const double x : {-1.0, 1.0}) {
        for (const double y : {-1.0, 1.0}) {
            const glm::dvec4 corner = world_from_clip * glm::dvec4{x, y, z_near, 1.0};
            const double distance = glm::length(glm::dvec3{corner} / corner.w - eye);
            const bool before_eye = corner.w > 0.0 && std::isfinite(distance);
            reach = std::max(reach, before_eye ? distance : double{Aabb::kInfinity});
        }
    }
    return reach;
}

constexpr double kRoundedUp = 1.0 + 1e-6; // what is taken to be a bound in float

double frobenius_norm(const glm::dmat3& map)
{
    return std::sqrt(glm::dot(map[0], map[0]) + glm::dot(map[1], map[1]) +
                     glm::dot(map[2], map[2]));
}

} // namespace

float stretch(const glm::mat4& map)
{
    return static_cast<float>(frobenius_norm(glm::dmat3{map}) * kRoundedUp);
}

float inverse_stretch(const glm::mat4& map)
{
    const glm::dmat3 linear{map};
    const double determinant = glm::determinant(linear);
    if (!std::isfinite(determinant) || determinant == 0.0) {
        return 0.0f;
    }
    const glm::dmat3 inverse = glm::inverse(linear);
    const auto most = static_cast<float>(frobenius_norm(inverse) * kRoundedUp);
    return std::isfinite(most) ? most : 0.0f;
}

// A length of the object grows by at most the Frobenius norm of the map, and a distance between two
// faces of a box shrinks by at most inverse_stretch. In the margin of a coordinate c the world's is
// at most R c + T, hence no more than 2 R max(c, T / R).
Inflation Inflation::in(const glm::mat4& world_from_object, float inverse_stretch) const
{
    constexpr double kMargin = 1.0 + 1e-5;
    const glm::dmat4 map{world_from_object};
    const double stretch = frobenius_norm(glm::dmat3{map});
    const glm::dvec3 origin{detail::absolute(glm::dvec3{map[3]})};
    const double farthest = std::max({origin.x, origin.y, origin.z, double{reach}});
    const double rows = 2.0 * stretch; // the sum of a row of three is at most sqrt(3) of the norm
    Inflation own;
    own.per_w = static_cast<float>(kMargin * double{per_w} * inverse_stretch);
    own.per_diagonal =
        static_cast<float>(kMargin * double{per_diagonal} * stretch * inverse_stretch);
    own.per_coordinate =
        static_cast<float>(kMargin * double{per_coordinate} * 2.0 * rows * inverse_stretch);
    own.reach = static_cast<float>(kMargin * farthest / rows);
    own.row_w = glm::vec4{glm::dvec4{row_w} * map};
    return own;
}

View View::from_clip(const glm::mat4& clip_from_world, glm::ivec2 size_px,
                     ClipConvention convention)
{
    View view;
    view.clip_from_world_ = clip_from_world;
    view.size_px_ = size_px;
    view.convention_ = convention;

    const glm::dmat4 clip{clip_from_world};
    if (!all_finite(clip) || glm::determinant(clip) == 0.0 || size_px.x <= 0 || size_px.y <= 0) {
        return view; // degenerate: the frustum culls nothing, and every box touches the near plane
    }
    const glm::dmat4 rows = glm::transpose(clip);
    const auto pixel_per_w =
        static_cast<float>(largest_pixel_per_w(rows[0], rows[1], rows[3], size_px));
    if (!std::isfinite(pixel_per_w)) {
        return view; // nearly singular
    }
    view.orthographic_ = glm::length(glm::dvec3{rows[3]}) <= 1e-12 * std::abs(rows[3].w);
    if (!view.orthographic_) {
        const glm::dvec4 zero = common_zero(rows[0], rows[1], rows[3]);
        const glm::dvec3 eye = glm::dvec3{zero} / zero.w;
        view.eye_ = glm::vec3{eye};
        const bool reversed = convention.order == DepthOrder::near_is_large;
        const double z_low = convention.range == DepthRange::minus_one_to_one ? -1.0 : 0.0;
        const double reach = corner_reach(glm::inverse(clip), eye, reversed ? 1.0 : z_low);
        // Rounded up: the eye was rounded to float, and so are box corners.
        const double slop = 4.0 * 0x1p-23 * glm::length(eye);
        view.near_reach_ = static_cast<float>(reach * (1.0 + 1e-5) + slop);
        if (!std::isfinite(glm::dot(view.eye_, view.eye_))) {
            view.eye_ = glm::vec3{0.0f};
            return view; // the eye is nowhere
        }
    }
    view.frustum_ = Frustum::from_clip(clip_from_world, convention);
    view.inflation_.per_w = kInflatePixels * pixel_per_w;
    view.inflation_.row_w = glm::vec4{rows[3]};
    view.inflation_.reach = glm::length(view.eye_);
    view.degenerate_ = false;
    return view;
}

float View::distance_key(const Aabb& box) const
{
    if (!box.is_bounded()) {
        return box.is_empty() ? Aabb::kInfinity : -Aabb::kInfinity;
    }
    if (!orthographic_) {
        return distance_squared(box, eye_);
    }
    const glm::vec4& plane = frustum_.plane(Frustum::near);
    const glm::vec3 normal{plane};
    return glm::dot(normal, box.center()) + plane.w -
           0.5f * glm::dot(glm::abs(normal), box.extent());
}

bool View::touches_near(const Aabb& box) const
{
    if (degenerate_ || !box.is_bounded()) {
        return true;
    }
    const glm::vec4& plane = frustum_.plane(Frustum::near);
    const glm::vec3 normal{plane};
    const glm::vec3 center = box.center();
    const float reach = 0.5f * glm::dot(glm::abs(normal), box.extent());
    const float nearest = glm::dot(normal, center) + plane.w - reach;
    const float slop = 4.0f * 0x1p-23f *
                       (glm::dot(glm::abs(normal), glm::abs(center)) + std::abs(plane.w) + reach);
    if (nearest > slop && normal != glm::vec3{0.0f}) {
        return false; // wholly beyond the near plane
    }
    // Negated, so that a NaN from overflow counts as touching.
    return orthographic_ || !(distance_squared(box, eye_) > near_reach_ * near_reach_);
}

Aabb View::inflated_for_test(const Aabb& box) const
{
    return box.is_bounded() ? inflated(box, inflation_.margin(box)) : box;
}

} // namespace occlude
