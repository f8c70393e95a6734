// A camera that flies: an eye, a heading about the scene's up vector, and a tilt.
#pragma once

#include <occlude/scene/camera_path.h>

#include <glm/vec3.hpp>

namespace occlude::tools::viewer {

class FlyCamera {
public:
    FlyCamera() = default;
    /// Stands and looks as `camera` does; rolls are lost. `up` is the scene's.
    FlyCamera(const Camera& camera, const glm::vec3& up);

    /// Turns, in radians: to the right, and up. The tilt ends short of straight up and down.
    void look(float right, float up);

    /// Moves, in world units, along what the camera calls right, up and forward.
    void fly(const glm::vec3& right_up_forward);

    /// Turns around `pivot` and goes on looking at it as before, in radians.
    void orbit(const glm::vec3& pivot, float right, float up);

    /// As a camera of a path, near and far left open.
    Camera camera() const;

    const glm::vec3& eye() const { return eye_; }
    glm::vec3 forward() const;
    glm::vec3 right() const;

private:
    glm::vec3 eye_{0.0f};
    glm::vec3 up_{0.0f, 1.0f, 0.0f};
    glm::vec3 north_{0.0f, 0.0f, -1.0f}; ///< heading 0, at right angles to up_
    float heading_ = 0.0f;               ///< radians, to the right of north_
    float tilt_ = 0.0f;                  ///< radians, above the horizon
    float fov_y_ = 60.0f;                ///< degrees
};

} // namespace occlude::tools::viewer
