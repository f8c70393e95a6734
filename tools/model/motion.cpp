#include "model/motion.h"

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include <cmath>

namespace occlude::tools {
namespace {

/// The position of a ball between two walls that starts at `start` and flies `way`.
double bounced(double start, double way, double low, double high)
{
    const double width = high - low;
    if (!(width > 0.0)) {
        return start;
    }
    // The position has a period of once there and back.
    double along = std::fmod(start - low + way, 2.0 * width);
    along += along < 0.0 ? 2.0 * width : 0.0;
    return low + (along <= width ? along : 2.0 * width - along);
}

/// The rotation of `times` frames, from the rotation of one, by repeated squaring.
glm::dquat repeated_turn(const glm::vec3& spin, size_t times)
{
    glm::dquat turn = glm::normalize(glm::dquat{1.0, spin.x, spin.y, spin.z});
    glm::dquat result{1.0, 0.0, 0.0, 0.0};
    for (; times > 0; times >>= 1) {
        if ((times & 1) != 0) {
            result = glm::normalize(result * turn);
        }
        turn = glm::normalize(turn * turn);
    }
    return result;
}

glm::mat4 on_keys(const std::vector<MotionKey>& keys, const glm::mat4& world_from_mesh,
                  size_t frame)
{
    MotionKey at = frame <= keys.front().frame ? keys.front() : keys.back();
    for (size_t i = 1; i < keys.size(); ++i) {
        const MotionKey& from = keys[i - 1];
        const MotionKey& to = keys[i];
        if (frame >= from.frame && frame < to.frame) {
            const float share =
                static_cast<float>(frame - from.frame) / static_cast<float>(to.frame - from.frame);
            at.position = glm::mix(from.position, to.position, share);
            at.rotation = glm::slerp(from.rotation, to.rotation, share);
        }
    }
    glm::mat4 result{glm::mat3_cast(at.rotation) * glm::mat3{world_from_mesh}};
    result[3] = glm::vec4{at.position, 1.0f};
    return result;
}

} // namespace

glm::mat4 moved(const InstanceMotion& motion, const Aabb& box, const glm::mat4& world_from_mesh,
                size_t frame)
{
    if (!motion.keys.empty()) {
        return on_keys(motion.keys, world_from_mesh, frame);
    }
    if (frame == 0 || !motion.moves()) {
        return world_from_mesh;
    }
    const glm::dmat3 turn = glm::mat3_cast(repeated_turn(motion.spin, frame));
    glm::mat4 result{glm::mat3{turn * glm::dmat3{world_from_mesh}}};
    for (int axis = 0; axis < 3; ++axis) {
        const double way = static_cast<double>(frame) * double{motion.velocity[axis]};
        result[3][axis] = static_cast<float>(
            bounced(world_from_mesh[3][axis], way, box.min[axis], box.max[axis]));
    }
    return result;
}

bool exists(const InstanceMotion& motion, size_t frame)
{
    if (frame < motion.first_frame || frame > motion.last_frame) {
        return false;
    }
    return motion.period == 0 || (motion.phase + frame) % motion.period < motion.present;
}

} // namespace occlude::tools
