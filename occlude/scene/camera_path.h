// Camera paths: a list of frames, made from keyframes, files or generators.
#pragma once

#include <occlude/core/view.h>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <span>
#include <vector>

namespace occlude {

/// One camera: world units, degrees.
struct Camera {
    glm::vec3 eye{0.0f};
    glm::vec3 target{0.0f, 0.0f, -1.0f};
    glm::vec3 up{0.0f, 1.0f, 0.0f};
    float fov_y = 60.0f;
    float near = 0.0f; ///< 0: chosen from the scene
    float far = 0.0f;  ///< 0: chosen from the scene
};

struct Keyframe {
    float time = 0.0f; ///< seconds, ascending
    Camera camera;
    bool cut = false; ///< jump here instead of moving: frames before this key keep the camera of
                      ///< the key before
};

/// `frame_count` cameras at even times over the keys. Eyes and targets move on Catmull-Rom curves,
/// so that the path is smooth; cuts stay cuts. Precondition: `keys` is not empty.
std::vector<Camera> interpolate(std::span<const Keyframe> keys, size_t frame_count);

/// The view of a camera with a right-handed perspective projection, relative to its eye:
/// renderers subtract View::origin() from positions before they round. Precondition: near > 0 and
/// far > near. An up vector along the view direction is replaced by another one.
View make_view(const Camera& camera, glm::ivec2 size_px, ClipConvention convention = {},
               const ViewOptions& options = {});

} // namespace occlude
