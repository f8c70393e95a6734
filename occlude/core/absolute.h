// Absolute values without a branch: glm::abs compares and branches, which is slowest if signs are
// random.
#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <cmath>

namespace occlude::detail {

template <class T>
glm::vec<3, T> absolute(const glm::vec<3, T>& v)
{
    return {std::abs(v.x), std::abs(v.y), std::abs(v.z)};
}

template <class T>
glm::vec<4, T> absolute(const glm::vec<4, T>& v)
{
    return {std::abs(v.x), std::abs(v.y), std::abs(v.z), std::abs(v.w)};
}

} // namespace occlude::detail
