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
// ... and by this share of their diagonal, for boxes whose own size dwarfs a pixel's.
constexpr float kInflateDiagonal = 1e-5f;
// ... and by this many ulps of their largest coordinate, for scenes far from the origin.
constexpr float kInflateUlps = 8.0f * 0x1p-23f;

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

} // namespace

View View::from_clip(const glm::mat4& clip_from_world, glm::ivec2 size_px,
                     ClipConvention convention)
{
    View view;
    view.clip_from_world_ = clip_from_world;
    view.size_px_ = size_px;
    view.convention_ = convention;

    const glm::dmat4 clip{clip_from_world};
    if (!all_finite(clip) || glm::determinant(clip) == 0.0 || size_px.x <= 0 || size_px.y <= 0) {
        return view; // degenerate: a default frustum culls nothing, and every box touches the near
                     // plane
    }
    view.degenerate_ = false;
    view.frustum_ = Frustum::from_clip(clip_from_world, convention);

    const glm::dmat4 rows = glm::transpose(clip);
    view.orthographic_ = glm::length(glm::dvec3{rows[3]}) <= 1e-12 * std::abs(rows[3].w);
    const double scale_x = glm::length(glm::dvec3{rows[0]}) * size_px.x;
    const double scale_y = glm::length(glm::dvec3{rows[1]}) * size_px.y;
    view.pixel_per_w_ = static_cast<float>(2.0 / std::min(scale_x, scale_y));
    if (view.orthographic_) {
        return view;
    }

    const glm::dvec4 zero = common_zero(rows[0], rows[1], rows[3]);
    const glm::dvec3 eye = glm::dvec3{zero} / zero.w;
    view.eye_ = glm::vec3{eye};

    const bool reversed = convention.order == DepthOrder::near_is_large;
    const double z_low = convention.range == DepthRange::minus_one_to_one ? -1.0 : 0.0;
    const double z_near = reversed ? 1.0 : z_low;
    const glm::dmat4 world_from_clip = glm::inverse(clip);
    double reach = 0.0;
    for (const double x : {-1.0, 1.0}) {
        for (const double y : {-1.0, 1.0}) {
            const glm::dvec4 corner = world_from_clip * glm::dvec4{x, y, z_near, 1.0};
            reach = std::max(reach, glm::length(glm::dvec3{corner} / corner.w - eye));
        }
    }
    if (std::isfinite(reach)) {
        // Rounded up: the eye was rounded to float, and so are box corners.
        const double slop = 4.0 * 0x1p-23 * glm::length(eye);
        view.near_reach_ = static_cast<float>(reach * (1.0 + 1e-5) + slop);
    }
    return view;
}

float View::distance_key(const Aabb& box) const
{
    if (!box.is_bounded()) {
        return -Aabb::kInfinity;
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
    const float nearest =
        glm::dot(normal, center) + plane.w - 0.5f * glm::dot(glm::abs(normal), box.extent());
    const float slop =
        4.0f * 0x1p-23f * (glm::dot(glm::abs(normal), glm::abs(center)) + std::abs(plane.w));
    if (nearest > slop && normal != glm::vec3{0.0f}) {
        return false; // wholly beyond the near plane
    }
    return orthographic_ || distance_squared(box, eye_) <= near_reach_ * near_reach_;
}

Aabb View::inflated_for_test(const Aabb& box) const
{
    if (!box.is_bounded()) {
        return box;
    }
    const glm::vec4 row_w{clip_from_world_[0][3], clip_from_world_[1][3], clip_from_world_[2][3],
                          clip_from_world_[3][3]};
    const glm::vec3 half = 0.5f * box.extent();
    const glm::vec3 toward_w{row_w};
    const float largest_w =
        glm::dot(toward_w, box.center()) + row_w.w + glm::dot(glm::abs(toward_w), half);
    const glm::vec3 magnitude = glm::max(glm::abs(box.min), glm::abs(box.max));
    const float coordinate = std::max({magnitude.x, magnitude.y, magnitude.z, glm::length(eye_)});
    const float margin = kInflatePixels * pixel_per_w_ * std::max(largest_w, 0.0f) +
                         kInflateDiagonal * glm::length(box.extent()) + kInflateUlps * coordinate;
    return inflated(box, margin);
}

} // namespace occlude
