#include "viewer/fly_camera.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include <cmath>

namespace occlude::tools::viewer {

static constexpr float kSteepestTilt = 1.55f; // radians: short of a right angle

FlyCamera::FlyCamera(const Camera& camera, const glm::vec3& up)
    : eye_(camera.eye)
    , up_(glm::normalize(up))
    , fov_y_(camera.fov_y)
{
    const glm::vec3 side =
        std::abs(up_.x) < 0.5f ? glm::vec3{1.0f, 0.0f, 0.0f} : glm::vec3{0.0f, 0.0f, 1.0f};
    north_ = glm::normalize(glm::cross(up_, side));
    glm::vec3 toward = camera.target - camera.eye;
    if (glm::length(toward) < 1e-20f) {
        toward = north_;
    }
    toward = glm::normalize(toward);
    tilt_ = glm::clamp(std::asin(glm::clamp(glm::dot(toward, up_), -1.0f, 1.0f)), -kSteepestTilt,
                       kSteepestTilt);
    glm::vec3 level = toward - up_ * glm::dot(toward, up_);
    if (glm::length(level) <
        1e-6f) { // looking straight up or down: its own up vector says where to
        level = camera.up - up_ * glm::dot(camera.up, up_);
    }
    const glm::vec3 east = glm::cross(north_, up_);
    heading_ = std::atan2(glm::dot(level, east), glm::dot(level, north_));
}

glm::vec3 FlyCamera::forward() const
{
    const glm::vec3 east = glm::cross(north_, up_);
    const glm::vec3 level = std::cos(heading_) * north_ + std::sin(heading_) * east;
    return std::cos(tilt_) * level + std::sin(tilt_) * up_;
}

glm::vec3 FlyCamera::right() const
{
    const glm::vec3 east = glm::cross(north_, up_);
    return std::cos(heading_) * east - std::sin(heading_) * north_;
}

void FlyCamera::look(float right, float up)
{
    heading_ += right;
    tilt_ = glm::clamp(tilt_ + up, -kSteepestTilt, kSteepestTilt);
}

void FlyCamera::fly(const glm::vec3& right_up_forward)
{
    eye_ +=
        right() * right_up_forward.x + up_ * right_up_forward.y + forward() * right_up_forward.z;
}

void FlyCamera::orbit(const glm::vec3& pivot, float right_angle, float up_angle)
{
    // The pivot keeps its place in the picture: its offset turns with the camera's own axes.
    const glm::vec3 offset = pivot - eye_;
    const auto own_up = [&] { return glm::cross(right(), forward()); };
    const glm::vec3 local{glm::dot(offset, right()), glm::dot(offset, own_up()),
                          glm::dot(offset, forward())};
    look(right_angle, up_angle);
    eye_ = pivot - (right() * local.x + own_up() * local.y + forward() * local.z);
}

Camera FlyCamera::camera() const
{
    return {.eye = eye_, .target = eye_ + forward(), .up = up_, .fov_y = fov_y_};
}

} // namespace occlude::tools::viewer
