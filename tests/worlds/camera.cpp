#include "worlds/camera.h"

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

namespace occlude::worlds {

namespace {

constexpr double kFar = 60.0; // in units of the world, as everything here

glm::dvec3 random_offset(Rng& rng, float reach)
{
    const float x = rng.range(-reach, reach);
    const float y = rng.range(-reach, reach);
    const float z = rng.range(-reach, reach);
    return {x, y, z};
}

/// The row of depth for a near plane that leans by up to 80 degrees; the far corner of the screen
/// stays at the far end.
glm::dvec4 oblique_row(const glm::dmat4& clip_from_eye, double unit, Rng& rng)
{
    const double turn = rng.range(0.0f, 6.28318f);
    const double lean = rng.range(0.0f, 1.4f);
    const glm::dvec4 plane{std::sin(lean) * std::cos(turn), std::sin(lean) * std::sin(turn),
                           -std::cos(lean), -unit * rng.range(0.1f, 2.0f)};
    const glm::dvec4 far_corner =
        glm::inverse(clip_from_eye) *
        glm::dvec4{plane.x > 0.0 ? 1.0 : -1.0, plane.y > 0.0 ? 1.0 : -1.0, 1.0, 1.0};
    return plane / glm::dot(plane, far_corner);
}

glm::dmat4 projection(const Spec& spec, Rng& rng)
{
    const double unit = spec.unit;
    const double near = unit * spec.near_plane;
    const double far = unit * kFar;
    const double aspect = static_cast<double>(spec.size_px.x) / spec.size_px.y;
    const double fov_y = rng.range(0.4f, 2.2f);
    const double top = near * std::tan(0.5 * fov_y);
    glm::dmat4 clip = glm::perspectiveRH_ZO(fov_y, aspect, near, far);
    if (spec.lens == Lens::orthographic) {
        const double high = 8.0 * unit;
        clip = glm::orthoRH_ZO(-high * aspect, high * aspect, -high, high, near, far);
    } else if (spec.lens == Lens::off_centre) {
        const double right = top * aspect;
        clip = glm::frustumRH_ZO(-0.2 * right, 1.5 * right, -1.3 * top, 0.4 * top, near, far);
    }
    glm::dmat4 rows = glm::transpose(clip); // depth from 0 (near) to w (far)
    if (spec.lens == Lens::infinite) {
        rows[2] = {0.0, 0.0, -1.0, -near};
    } else if (spec.lens == Lens::oblique) {
        rows[2] = oblique_row(clip, unit, rng);
    }
    if (spec.convention.order == DepthOrder::near_is_large) {
        rows[2] = rows[3] - rows[2];
    }
    if (spec.convention.range == DepthRange::minus_one_to_one) {
        rows[2] = 2.0 * rows[2] - rows[3];
    }
    rows[0] *= spec.mirrored ? -1.0 : 1.0;
    return glm::transpose(rows);
}

} // namespace

Camera::Camera(const Spec& spec, const RandomScene& scene, uint32_t index)
    : spec_(spec)
    , rng_(hash64(spec.seed, 0xca3e7a, index))
    , clip_from_eye_(projection(spec, rng_))
{
    choose_place(scene);
}

void Camera::choose_place(const RandomScene& scene)
{
    const double unit = scene.unit();
    const float reach = RandomScene::kReach;
    const glm::dvec3 center{scene.center()};
    eye_ = center + unit * random_offset(rng_, 1.6f * reach);
    target_ = center + unit * random_offset(rng_, 0.5f * reach);
    const auto bounds = scene.bounds();
    const Aabb& box = bounds[rng_.below(static_cast<uint32_t>(bounds.size()))].box;
    if (box.is_empty()) {
        return;
    }
    const uint32_t kind = rng_.below(5);
    if (kind == 0) { // in a box
        eye_ = box.center();
    } else if (kind == 1) { // so close to a face that the near plane may cut it, looking along it
        const int axis = static_cast<int>(rng_.below(3));
        eye_ = box.center();
        eye_[axis] = box.max[axis] + unit * spec_.near_plane * rng_.range(0.0f, 2.0f);
        target_ = eye_ + unit * random_offset(rng_, 3.0f);
        target_[axis] = eye_[axis];
    }
}

View Camera::next(const RandomScene& scene)
{
    const double unit = scene.unit();
    const uint32_t kind = rng_.below(6);
    if (kind == 0) { // a cut
        choose_place(scene);
    } else if (kind == 1) { // a spin
        target_ = eye_ + unit * random_offset(rng_, 5.0f);
    } else if (kind != 2) { // a step, often through a wall; otherwise it stands still
        eye_ += unit * random_offset(rng_, 0.6f);
        target_ += unit * random_offset(rng_, 0.4f);
    }
    glm::dvec3 ahead = target_ - eye_;
    if (!(glm::length(ahead) > 1e-3 * unit)) {
        ahead = unit * glm::dvec3{0.3, 0.2, -1.0};
    }
    const glm::dvec3 up = std::abs(glm::normalize(ahead).y) > 0.95 ? glm::dvec3{1.0, 0.0, 0.0}
                                                                   : glm::dvec3{0.0, 1.0, 0.0};
    const glm::dmat4 clip_from_relative =
        clip_from_eye_ * glm::lookAtRH(glm::dvec3{0.0}, ahead, up);
    const ViewOptions options{.ignores_near_plane = spec_.depth_clamp};
    if (spec_.camera_relative) {
        return View::camera_relative(glm::mat4{clip_from_relative}, eye_, spec_.size_px,
                                     spec_.convention, options);
    }
    glm::dmat4 clip_from_world = clip_from_relative;
    clip_from_world[3] = clip_from_relative * glm::dvec4{-eye_, 1.0};
    return View::from_clip(glm::mat4{clip_from_world}, spec_.size_px, spec_.convention, options);
}

} // namespace occlude::worlds
