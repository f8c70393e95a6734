// Axis-aligned boxes. Boxes with special values have a defined meaning; the first line that fits
// decides:
//
//   NaN in any corner           unknown       as everything(): unbounded, always visible
//   min > max on some axis      empty         bounds nothing, outside of every frustum
//   infinite on some side       unbounded     never tested, never outside, always visible
//   min == max on some axis     flat          ordinary: a face, a line or a point
//   else                        ordinary      a closed box: its faces belong to it
//
// The safe direction is "larger": an unknown box is visible, never hidden.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include <limits>

namespace occlude {

struct Aabb {
    static constexpr float kInfinity = std::numeric_limits<float>::infinity();

    glm::vec3 min{kInfinity};
    glm::vec3 max{-kInfinity};

    /// The box that bounds nothing; merging it into another changes nothing.
    static Aabb empty() { return {}; }
    /// The box that bounds all of space: what an unknown (NaN) box stands for.
    static Aabb everything() { return {glm::vec3{-kInfinity}, glm::vec3{kInfinity}}; }

    /// True if the box bounds nothing. False for NaN boxes: the unknown is not nothing.
    bool is_empty() const
    {
        return (min.x > max.x || min.y > max.y || min.z > max.z) && !has_nan();
    }

    /// True if the box has finite corners and is not empty: the only kind that can be tested.
    bool is_bounded() const
    {
        // Written so that NaN answers false.
        return min.x <= max.x && min.y <= max.y && min.z <= max.z && min.x > -kInfinity &&
               min.y > -kInfinity && min.z > -kInfinity && max.x < kInfinity && max.y < kInfinity &&
               max.z < kInfinity;
    }

    bool has_nan() const
    {
        return !(min.x == min.x && min.y == min.y && min.z == min.z && max.x == max.x &&
                 max.y == max.y && max.z == max.z);
    }

    /// The middle; finite for every bounded box.
    glm::vec3 center() const { return 0.5f * min + 0.5f * max; }
    /// The size along each axis; infinite where it is too large for float.
    glm::vec3 extent() const { return max - min; }

    bool operator==(const Aabb&) const = default;
};

/// The box as every part of the library takes it: a NaN box becomes everything(), others stay.
inline Aabb sanitized(const Aabb& box)
{
    return box.has_nan() ? Aabb::everything() : box;
}

/// The smallest box around both. Empty boxes add nothing; a NaN box makes the result everything().
inline Aabb merge(const Aabb& a, const Aabb& b)
{
    if (a.has_nan() || b.has_nan()) {
        return Aabb::everything();
    }
    if (a.is_empty()) {
        return b;
    }
    if (b.is_empty()) {
        return a;
    }
    return {glm::min(a.min, b.min), glm::max(a.max, b.max)};
}

/// True if `inner` lies in `outer`, faces included. An empty box lies in every box; of NaN boxes
/// nothing is known, so they neither contain anything else nor lie in anything.
inline bool contains(const Aabb& outer, const Aabb& inner)
{
    if (inner.is_empty()) {
        return true;
    }
    return inner.min.x >= outer.min.x && inner.min.y >= outer.min.y && inner.min.z >= outer.min.z &&
           inner.max.x <= outer.max.x && inner.max.y <= outer.max.y && inner.max.z <= outer.max.z;
}

/// Surface area, in square world units; 0 for an empty box, infinite for an unbounded or NaN one.
float surface_area(const Aabb& box);

/// The box grown by `margin` >= 0 on all six sides; empty boxes stay empty.
Aabb inflated(const Aabb& box, float margin);

/// A box around `box` after the affine map `to_from`: never smaller than the exact image of the
/// box (rounding goes outward). Unbounded or NaN boxes, and boxes under a matrix that is not
/// finite, become everything(); empty ones stay empty.
Aabb transformed(const glm::mat4& to_from, const Aabb& box);

/// Squared distance from `point` to the nearest point of the box: 0 inside and for NaN boxes,
/// infinite for empty ones.
float distance_squared(const Aabb& box, const glm::vec3& point);

} // namespace occlude
