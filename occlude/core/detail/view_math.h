// Arithmetic on the rows of a camera's matrix. Internal: sources include it, users do not.
#pragma once

#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <cmath>

namespace occlude::detail {

/// A bound in double times this is a bound in float.
inline constexpr double kRoundedUp = 1.0 + 1e-6;

/// The largest absolute value of a coordinate.
inline double largest(const glm::dvec3& v)
{
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// The point that rows x, y and w all map to 0: the eye, or a direction (w = 0) when orthographic.
inline glm::dvec4 common_zero(const glm::dvec4& x, const glm::dvec4& y, const glm::dvec4& w)
{
    const auto minor = [&](int a, int b, int c) {
        return glm::determinant(glm::dmat3{glm::dvec3{x[a], x[b], x[c]},
                                           glm::dvec3{y[a], y[b], y[c]},
                                           glm::dvec3{w[a], w[b], w[c]}});
    };
    return {minor(1, 2, 3), -minor(0, 2, 3), minor(0, 1, 3), -minor(0, 1, 2)};
}

} // namespace occlude::detail
