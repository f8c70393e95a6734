#include "load/scene_origin.h"

#include "model/focus.h"

#include <glm/common.hpp>

#include <algorithm>
#include <cmath>

namespace occlude::tools {
namespace {

float largest_of(const glm::vec3& v)
{
    return std::max({v.x, v.y, v.z});
}

} // namespace

glm::dvec3 way_to_bulk(const SceneModel& model)
{
    constexpr float kFarScene = 16.0f; // times its size
    const Aabb box = find_focus(model).box;
    const float size = largest_of(box.extent());
    const float away = largest_of(glm::abs(box.center()));
    if (!(away > kFarScene * size) || !std::isfinite(away)) {
        return glm::dvec3{0.0};
    }
    // Single precision may have left no size: then the distance to the next number.
    constexpr double kStepOfOne = 0x1p-23;
    const double step = std::max(double{size}, kStepOfOne * double{away});
    const double power = std::exp2(std::ceil(std::log2(step)));
    return glm::round(glm::dvec3{box.center()} / power) * power;
}

bool has_shape(const SceneModel& model)
{
    constexpr float kLeastSteps = 16.0f; // of single precision, along the scene
    constexpr float kStepOfOne = 0x1p-23f;
    const Aabb box = find_focus(model).box;
    const float away = largest_of(glm::abs(box.center()));
    // Written so that NaN answers false.
    return largest_of(box.extent()) >= kLeastSteps * kStepOfOne * away;
}

} // namespace occlude::tools
