// Computes how far a box grows before it is tested, in the space of an object.
#include <occlude/core/detail/view_math.h>
#include <occlude/core/view.h>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

namespace occlude {

using detail::kRoundedUp;
using detail::largest;

namespace {

double frobenius_norm(const glm::dmat3& map)
{
    return std::sqrt(glm::dot(map[0], map[0]) + glm::dot(map[1], map[1]) +
                     glm::dot(map[2], map[2]));
}

} // namespace

float stretch(const glm::mat4& map)
{
    return static_cast<float>(frobenius_norm(glm::dmat3{map}) * kRoundedUp);
}

float inverse_stretch(const glm::mat4& map)
{
    const glm::dmat3 linear{map};
    const double determinant = glm::determinant(linear);
    if (!std::isfinite(determinant) || determinant == 0.0) {
        return 0.0f;
    }
    const glm::dmat3 inverse = glm::inverse(linear);
    const auto most = static_cast<float>(frobenius_norm(inverse) * kRoundedUp);
    return std::isfinite(most) ? most : 0.0f;
}

// The Frobenius norm of the map bounds how much a length of the object grows. inverse_stretch
// bounds how much a distance between two faces of a box shrinks. A point at distance c from the
// origin is at most 2 R c from it in the world. A device rounds two more kinds of terms on the way:
// the object's own coordinates, and the translation.
Inflation Inflation::in(const glm::mat4& world_from_object, float inverse_stretch) const
{
    constexpr double kMargin = 1.0 + 1e-5;
    const glm::dmat4 map{world_from_object};
    const glm::dmat3 linear{map};
    const double stretch = frobenius_norm(linear);
    const glm::dvec3 away = glm::dvec3{origin} - glm::dvec3{map[3]};
    const double rows = 2.0 * stretch; // the sum of a row of three is at most sqrt(3) of the norm
    Inflation own;
    own.origin = inverse_stretch > 0.0f ? glm::vec3{glm::inverse(linear) * away} : glm::vec3{0.0f};
    own.per_w = static_cast<float>(kMargin * double{per_w} * inverse_stretch);
    own.per_diagonal =
        static_cast<float>(kMargin * double{per_diagonal} * stretch * inverse_stretch);
    own.per_coordinate =
        static_cast<float>(kMargin * double{per_coordinate} * rows * inverse_stretch);
    own.reach = static_cast<float>(
        kMargin * ((double{reach} + largest(away)) / rows + largest(glm::dvec3{own.origin})));
    own.depth_bias = depth_bias;
    const glm::dvec4 row{row_w};
    own.row_w = glm::vec4{
        glm::dvec4{glm::dvec3{row} * linear,
                   row.w + glm::dot(glm::dvec3{row}, linear * glm::dvec3{own.origin} - away)}};
    return own;
}

} // namespace occlude
