// Balls around boxes, and the cheap frustum test that begins with them.
//
// Implements  D. Sekulic, "Efficient Occlusion Culling", GPU Gems, 2004, section 29.6.4.
#pragma once

#include <occlude/core/aabb.h>
#include <occlude/core/frustum.h>

namespace occlude {

struct BoundingSphere {
    glm::vec3 center{0.0f};
    float radius = -1.0f; ///< negative: the ball is empty
};

/// The smallest ball around the box (rounded outward); empty for an empty box, of infinite radius
/// for an unbounded or NaN one.
BoundingSphere bounding_sphere(const Aabb& box);

/// True if the largest extent of the box is more than `ratio` times the second largest: a pillar,
/// whose ball is much larger than it is. False for boxes that are not bounded.
bool is_elongated(const Aabb& box, float ratio = 2.0f);

/// Where `box` lies, by its ball first. If the ball is inside or outside, so is the box. Otherwise
/// the box itself is tested if it is elongated, and any other box intersects. `outside` and
/// `inside` are certain, but more boxes are called `intersects` than by Frustum::classify(box).
/// Tests only the planes in `mask`, and clears the bits of planes that the ball (or the tested box)
/// lies wholly inside of. Precondition: `sphere` contains the box; keep it with the object.
Containment classify_sphere_first(const Frustum& frustum, const BoundingSphere& sphere,
                                  const Aabb& box, PlaneMask& mask, float elongation_ratio = 2.0f);

inline Containment classify_sphere_first(const Frustum& frustum, const BoundingSphere& sphere,
                                         const Aabb& box, float elongation_ratio = 2.0f)
{
    PlaneMask mask = Frustum::kAllPlanes;
    return classify_sphere_first(frustum, sphere, box, mask, elongation_ratio);
}

} // namespace occlude
