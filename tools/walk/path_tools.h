// Turning polylines into walks.
#pragma once

#include <occlude/scene/camera_path.h>

#include <glm/vec3.hpp>

#include <span>
#include <vector>

namespace occlude::tools {

struct WalkStyle {
    float speed = 1.4f;        ///< world units per second
    float look_ahead = 4.0f;   ///< how far along the path the camera looks
    float key_distance = 1.0f; ///< between keys, along the path
    glm::vec3 up{0.0f, 1.0f, 0.0f};
    float fov_y = 60.0f;
};

/// The polyline with every inner corner replaced by a parabola that leaves it `cut` before the
/// corner (or half the way to the next corner, if that is nearer).
std::vector<glm::vec3> rounded(std::span<const glm::vec3> corners, float cut);

/// Points at even distances of about `spacing` along the polyline, both ends among them.
std::vector<glm::vec3> resampled(std::span<const glm::vec3> points, float spacing);

/// Keys along a polyline of eye positions, looking ahead along it; near the end and where the path
/// turns back the heading stays as it was. Precondition: at least two different points.
std::vector<Keyframe> walk_along(std::span<const glm::vec3> points, const WalkStyle& style);

/// The same walk cut into eight pieces that are played in another order; in the second half of each
/// piece the camera looks 90 degrees to the side. Fewer than 16 keys stay as they are.
std::vector<Keyframe> with_cuts(std::span<const Keyframe> keys, const glm::vec3& up);

} // namespace occlude::tools
