// The motion of a scene's instances, as a description that gives the state of any frame.
#pragma once

#include <occlude/core/aabb.h>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace occlude::tools {

/// The place of an instance in one frame of a script.
struct MotionKey {
    uint32_t frame = 0;
    glm::vec3 position{0.0f}; ///< of its origin, world space
    glm::quat rotation{1.0f, 0.0f, 0.0f,
                       0.0f}; ///< rotation about its origin, relative to its placement in the scene
};

/// The motion of one instance, counted in frames from its placement in the scene at frame 0.
struct InstanceMotion {
    glm::vec3 velocity{0.0f}; ///< of its origin: world units per frame
    /// Turns about its origin: the axis, as long as the tangent of half the angle per frame.
    glm::vec3 spin{0.0f};
    /// It exists in the first `present` frames of every `period`; period 0: always.
    uint32_t period = 0;
    uint32_t present = 0;
    uint32_t phase = 0; ///< how much of a period has passed at frame 0
    /// Instead of flying, it moves from key to key, at constant speed and the shortest way, and
    /// stands still before the first and after the last. Frames ascend.
    std::vector<MotionKey> keys;
    /// It exists from the first to the last of these frames only.
    uint32_t first_frame = 0;
    uint32_t last_frame = 0xffffffffu;

    bool moves() const
    {
        return !keys.empty() || velocity != glm::vec3{0.0f} || spin != glm::vec3{0.0f};
    }
};

struct Motion {
    /// Origins move within this box, in straight lines, and bounce off its faces; along an axis on
    /// which it has no extent they do not move. It holds the origins at frame 0.
    Aabb box;
    std::vector<InstanceMotion> instances; ///< one per instance; empty: nothing moves

    bool empty() const { return instances.empty(); }
};

/// The placement of an instance in a frame, whether it exists or not: at frame 0 exactly
/// `world_from_mesh` unless it has keys.
/// Computed from sums, products, square roots and exact remainders only, and so the same on every
/// machine (except for rotations between keys, which need sines).
glm::mat4 moved(const InstanceMotion& motion, const Aabb& box, const glm::mat4& world_from_mesh,
                size_t frame);

/// True if an instance exists in a frame.
bool exists(const InstanceMotion& motion, size_t frame);

} // namespace occlude::tools
