// One camera in one frame: what the culler and the device both need to know of it.
#pragma once

#include <occlude/core/aabb.h>
#include <occlude/core/absolute.h>
#include <occlude/core/frustum.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include <algorithm>

namespace occlude {

/// The most by which an affine map stretches a length, or somewhat more (a Frobenius norm, rounded
/// up).
float stretch(const glm::mat4& map);
/// The most by which the inverse of an affine map stretches a length, or somewhat more (a Frobenius
/// norm, rounded up); 0 if it has no usable inverse.
float inverse_stretch(const glm::mat4& map);

/// How much a box must grow before it is tested (rule R2), by its size and place. Part of a View.
struct Inflation {
    float per_w = 0.0f;              ///< 1/64 pixel at clip w = 1, in world units
    float per_diagonal = 1e-5f;      ///< for boxes whose own size dwarfs a pixel's
    float per_coordinate = 0x1p-20f; ///< eight ulps of the largest coordinate, or of ...
    float reach = 0.0f;              ///< ... the distance of the eye from the origin
    glm::vec4 row_w{0.0f};           ///< clip w of a point is dot(row_w, (point, 1))

    /// The same for boxes in the space of an affine `world_from_object`: their margin() there is at
    /// least what things in them need in the world, in every direction. The second argument is
    /// inverse_stretch(world_from_object).
    Inflation in(const glm::mat4& world_from_object, float inverse_stretch) const;

    /// In world units, for every direction. Precondition: `box` is bounded.
    float margin(const Aabb& box) const
    {
        const glm::vec3 toward_w{row_w};
        const glm::vec3 half = 0.5f * box.extent();
        const float largest_w =
            glm::dot(toward_w, box.center()) + row_w.w + glm::dot(detail::absolute(toward_w), half);
        const glm::vec3 magnitude = glm::max(detail::absolute(box.min), detail::absolute(box.max));
        const float coordinate = std::max({magnitude.x, magnitude.y, magnitude.z, reach});
        return per_w * std::max(largest_w, 0.0f) + per_diagonal * glm::length(box.extent()) +
               per_coordinate * coordinate;
    }
};

class View {
public:
    View() = default;

    /// A view from the matrix that the engine draws with (jitter of temporal antialiasing included:
    /// boxes must be tested with the matrix that draws) and the size of the target in pixels.
    /// Any projection: perspective, orthographic, off-centre, oblique, infinite, reversed. A matrix
    /// that is singular or not finite gives a view in which nothing can be culled.
    static View from_clip(const glm::mat4& clip_from_world, glm::ivec2 size_px,
                          ClipConvention convention = {});

    const glm::mat4& clip_from_world() const { return clip_from_world_; }
    glm::ivec2 size_px() const { return size_px_; }
    ClipConvention convention() const { return convention_; }
    const Frustum& frustum() const { return frustum_; }

    /// Perspective: the world position of the eye. Orthographic: meaningless.
    const glm::vec3& eye() const { return eye_; }
    bool orthographic() const { return orthographic_; }

    /// A key that orders boxes near to far: for perspective the squared distance from the eye to
    /// the nearest point of the box, for orthographic the distance of its nearest corner along the
    /// view direction. Unbounded boxes come first, empty ones last.
    float distance_key(const Aabb& box) const;

    /// True if the near rectangle can touch the box, or the box is not bounded, or nothing is known
    /// of the view: then it must not be tested, because its front faces may be clipped away, and
    /// counts as visible (rule R1). `box` is the box as it is handed to the test: ask this of what
    /// inflated_for_test returns. Errs toward true: a box that reaches before the near plane and
    /// within the distance of the near rectangle's corners from the eye counts as touching.
    ///
    /// False does not mean that the whole box is before the eye: a wide floor under the eye may
    /// reach behind it without touching the near rectangle. Rasterisers clip it.
    bool touches_near(const Aabb& box) const;

    /// The box as it must be handed to a test: grown by at least 1/256 pixel in every direction on
    /// the screen, so that its rasterisation covers a superset of the samples of anything in it,
    /// although the two come through different vertex streams (rule R2), and a flat box has some
    /// thickness. Always contains `box`; boxes that are not bounded stay what they are.
    Aabb inflated_for_test(const Aabb& box) const;
    const Inflation& inflation() const { return inflation_; }

private:
    glm::mat4 clip_from_world_{1.0f};
    glm::ivec2 size_px_{0};
    ClipConvention convention_;
    Frustum frustum_;
    glm::vec3 eye_{0.0f};
    float near_reach_ =
        Aabb::kInfinity; ///< from the eye to the farthest corner of the near rectangle
    Inflation inflation_;
    bool orthographic_ = false;
    bool degenerate_ = true;
};

} // namespace occlude
