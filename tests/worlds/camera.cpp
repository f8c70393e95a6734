#include "worlds/camera.h"

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>

#include <cmath>
#include <utility>

namespace occlude::worlds {

namespace {

constexpr float kNear = 0.1f; // in units of the world, as everything here
constexpr float kFar = 60.0f;

glm::vec3 random_offset(Rng& rng, float reach)
{
    const float x = rng.range(-reach, reach);
    const float y = rng.range(-reach, reach);
    const float z = rng.range(-reach, reach);
    return {x, y, z};
}

glm::mat4 projection(const Spec& spec, float fov_y, float near, float far)
{
    const bool zero_to_one = spec.convention.range == DepthRange::zero_to_one;
    if (spec.convention.order == DepthOrder::near_is_large) {
        std::swap(near, far);
    }
    const float aspect = static_cast<float>(spec.size_px.x) / static_cast<float>(spec.size_px.y);
    if (spec.orthographic) {
        const float high = 8.0f * spec.unit;
        const float wide = high * aspect;
        return zero_to_one ? glm::orthoRH_ZO(-wide, wide, -high, high, near, far)
                           : glm::orthoRH_NO(-wide, wide, -high, high, near, far);
    }
    return zero_to_one ? glm::perspectiveRH_ZO(fov_y, aspect, near, far)
                       : glm::perspectiveRH_NO(fov_y, aspect, near, far);
}

} // namespace

Camera::Camera(const Spec& spec, const RandomScene& scene, uint32_t index)
    : spec_(spec)
    , rng_(hash64(spec.seed, 0xca3e7a, index))
    , fov_y_(rng_.range(0.4f, 2.2f))
{
    choose_place(scene);
}

void Camera::choose_place(const RandomScene& scene)
{
    const float unit = scene.unit();
    const float reach = RandomScene::kReach;
    eye_ = scene.center() + unit * random_offset(rng_, 1.6f * reach);
    target_ = scene.center() + unit * random_offset(rng_, 0.5f * reach);
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
        eye_[axis] = box.max[axis] + unit * kNear * rng_.range(0.0f, 2.0f);
        target_ = eye_ + unit * random_offset(rng_, 3.0f);
        target_[axis] = eye_[axis];
    }
}

View Camera::next(const RandomScene& scene)
{
    const float unit = scene.unit();
    const uint32_t kind = rng_.below(6);
    if (kind == 0) { // a cut
        choose_place(scene);
    } else if (kind == 1) { // a spin
        target_ = eye_ + unit * random_offset(rng_, 5.0f);
    } else if (kind != 2) { // a step, often through something; else it stands still
        eye_ += unit * random_offset(rng_, 0.6f);
        target_ += unit * random_offset(rng_, 0.4f);
    }
    glm::vec3 ahead = target_ - eye_;
    if (!(glm::length(ahead) > 1e-3f * unit)) {
        ahead = unit * glm::vec3{0.3f, 0.2f, -1.0f};
    }
    const glm::vec3 up = std::abs(glm::normalize(ahead).y) > 0.95f ? glm::vec3{1.0f, 0.0f, 0.0f}
                                                                   : glm::vec3{0.0f, 1.0f, 0.0f};
    const glm::mat4 clip_from_world = projection(spec_, fov_y_, kNear * unit, kFar * unit) *
                                      glm::lookAtRH(eye_, eye_ + ahead, up);
    return View::from_clip(clip_from_world, spec_.size_px, spec_.convention);
}

} // namespace occlude::worlds
