// Boxes seen through a camera by rays, in double precision: the truth that a device must agree
// with.
#pragma once

#include <occlude/core/aabb.h>
#include <occlude/core/view.h>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <array>
#include <limits>
#include <span>
#include <vector>

namespace occlude::conformance {

/// An item index that means "nothing is hit".
inline constexpr size_t kNothing = std::numeric_limits<size_t>::max();

/// A ray through a point of the target; parameter 0 lies on the near plane, 1 on the far plane.
struct Ray {
    glm::dvec3 origin;
    glm::dvec3 direction;
};

/// The point at which a ray enters a box between the near and the far plane; infinite if it misses.
double entry(const Ray& ray, const Aabb& box);

/// The first hit of a ray.
struct Hit {
    size_t item = kNothing;
    double at = std::numeric_limits<double>::infinity();
};

class RayCamera {
public:
    /// Precondition: the view has a near and a far plane and an invertible matrix.
    explicit RayCamera(const View& view);

    glm::ivec2 size_px() const { return size_px_; }
    Ray through(const glm::dvec2& point_px) const;
    /// Window depth of a point, 0 near to 1 far in every convention.
    double depth01(const glm::dvec3& point) const;

private:
    glm::dmat4 clip_from_world_;
    glm::dmat4 world_from_clip_;
    ClipConvention convention_;
    glm::ivec2 size_px_;
};

/// The five points of a pixel whose rays must agree: its centre and four near its corners.
std::array<glm::dvec2, 5> probes(int x, int y);

/// The first of the boxes listed in `drawn` that the ray hits.
Hit first_hit(const Ray& ray, std::span<const Aabb> boxes, std::span<const size_t> drawn);

/// True if some pixel certainly shows `box`: at all its probes, the box's surface is nearer than
/// everything drawn. Errs toward false.
bool surely_visible(const RayCamera& camera, const Aabb& box, std::span<const Aabb> boxes,
                    std::span<const size_t> drawn);

} // namespace occlude::conformance
