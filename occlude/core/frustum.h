// The view frustum as planes taken from any projection matrix, and the conservative box test.
//
// Errs toward "inside": a box that touches the frustum is never called outside, while a box near an
// edge or corner of the frustum may be called intersecting although it lies wholly outside.
#pragma once

#include <occlude/core/aabb.h>

#include <glm/vec4.hpp>

#include <array>
#include <cstdint>

namespace occlude {

/// How the device's clip space measures depth. Left- or right-handedness does not matter here: it
/// is in the matrix.
enum class DepthRange : uint8_t {
    minus_one_to_one, ///< OpenGL's default: visible where -w <= z <= w
    zero_to_one,      ///< D3D, Vulkan, glClipControl: visible where 0 <= z <= w
};
enum class DepthOrder : uint8_t {
    near_is_small, ///< nearer means smaller depth; cleared to 1, tested with LESS
    near_is_large, ///< reverse Z: nearer means larger depth; cleared to 0, tested with GREATER
};
struct ClipConvention {
    DepthRange range = DepthRange::minus_one_to_one;
    DepthOrder order = DepthOrder::near_is_small;

    bool operator==(const ClipConvention&) const = default;
};

enum class Containment : uint8_t { outside, intersects, inside };

/// Bit i set: plane i must still be tested. A node wholly inside a plane clears the bit for all its
/// descendants (plane masking).
using PlaneMask = uint8_t;

class Frustum {
public:
    enum Plane { left, right, bottom, top, near, far, plane_count };
    static constexpr PlaneMask kAllPlanes = 0x3f;

    Frustum() = default;

    /// The frustum of a clip-from-world matrix: perspective, orthographic, off-centre, oblique,
    /// infinite far, reversed depth. A plane that does not bound anything (the far plane of an
    /// infinite projection) and a plane that is not finite never cull.
    static Frustum from_clip(const glm::mat4& clip_from_world, ClipConvention convention);

    /// The frustum of a matrix that maps (position - origin) to clip space. classify() takes boxes
    /// in world space and measures from the origin. `rounding`: the largest error of a device in
    /// clip space, apart from the rounding of the distance from the origin; a box that is outside
    /// by less is not called outside. With `ignores_near_plane` the near plane culls nothing.
    static Frustum from_relative(const glm::dmat4& clip_from_relative, const glm::dvec3& origin,
                                 ClipConvention convention, const glm::vec4& rounding,
                                 bool ignores_near_plane);

    /// A plane as (normal, offset): points inside have dot(normal, p) + offset >= 0. Normals have
    /// length 1, so that the value is the distance in world units; (0, 0, 0, 0) bounds nothing.
    const glm::vec4& plane(Plane which) const { return planes_[which]; }
    /// The same plane with the offset for (position - origin), where the origin is rounded to
    /// float.
    const glm::vec4& plane_from_origin(Plane which) const { return from_origin_[which]; }

    /// Where `box` lies, by the planes in `mask` only; clears the bits of planes that the whole box
    /// is inside of. `inside` and `outside` are certain; `intersects` is every other case. Empty
    /// boxes are outside; unbounded and NaN boxes intersect, and clear no bit.
    Containment classify(const Aabb& box, PlaneMask& mask) const;

    Containment classify(const Aabb& box) const
    {
        PlaneMask mask = kAllPlanes;
        return classify(box, mask);
    }

    /// Where the ball around `center` lies. `outside` and `inside` are certain; near an edge of the
    /// frustum the answer may be `intersects` although the ball is wholly outside. A ball that is
    /// not finite intersects. A ball of negative radius is empty and so outside.
    Containment classify_sphere(const glm::vec3& center, float radius) const
    {
        PlaneMask mask = kAllPlanes;
        return classify_sphere(center, radius, mask);
    }

    /// The same for the planes in `mask` only; clears the bits of planes that the whole ball is
    /// inside of.
    Containment classify_sphere(const glm::vec3& center, float radius, PlaneMask& mask) const;

private:
    // A copy of the planes, coordinate by coordinate, for tests of four at once; two of the eight
    // bound nothing.
    struct Lanes {
        std::array<float, 8> x{}, y{}, z{}, w{};
        std::array<float, 8> slop{}; ///< the rounding that does not depend on x, y and z
    };

    void set_plane(Plane which, const glm::dvec4& relative_plane, const glm::dvec3& origin,
                   double scale, double rounding);

    glm::vec3 origin_{0.0f};
    std::array<glm::vec4, plane_count> planes_{};
    std::array<glm::vec4, plane_count> from_origin_{};
    Lanes lanes_;
};

} // namespace occlude
