// One camera in one frame: everything that the culler and the device need to know of it.
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
#include <cstdint>

namespace occlude {

/// An upper bound of the factor by which an affine map stretches a length (a Frobenius norm,
/// rounded up).
float stretch(const glm::mat4& map);
/// The same for the inverse of an affine map; 0 if the map has no usable inverse.
float inverse_stretch(const glm::mat4& map);

/// How far a box must grow before it is tested (rule R2), by its size and place. Part of a View;
/// docs/conventions.md derives the terms.
struct Inflation {
    float per_w = 0.0f;              ///< 1/64 pixel at clip w = 1, in world units
    float per_diagonal = 1e-5f;      ///< share of the box's own diagonal
    float per_coordinate = 0x1p-20f; ///< rounding of positions, per unit of distance from origin
    float reach = 0.0f;              ///< added to the distance from the origin
    float depth_bias = 0.0f; ///< how much window depth 1/64 pixel along a plane of constant w can
                             ///< change
    glm::vec3 origin{0.0f};  ///< the point that distances are measured from
    glm::vec4 row_w{0.0f};   ///< clip w of a point p is dot(row_w, (p - origin, 1))

    /// The inflation of boxes in the space of an affine `world_from_object`. Their margin() there
    /// is at least the margin that their contents need in the world, in every direction.
    /// `inverse_stretch` is inverse_stretch(world_from_object).
    Inflation in(const glm::mat4& world_from_object, float inverse_stretch) const;

    /// The margin in units of the box's space, for every direction. A box inside another never has
    /// the larger margin, to the last bit. Precondition: `box` is bounded.
    float margin(const Aabb& box) const
    {
        const glm::vec3 low = box.min - origin;
        const glm::vec3 high = box.max - origin;
        const glm::vec3 toward_w{row_w};
        const glm::vec3 most = glm::max(toward_w * low, toward_w * high);
        const float largest_w = most.x + most.y + most.z + row_w.w;
        const glm::vec3 magnitude = glm::max(detail::absolute(low), detail::absolute(high));
        const float distance = std::max({magnitude.x, magnitude.y, magnitude.z}) + reach;
        return per_w * std::max(largest_w, 0.0f) + per_diagonal * glm::length(box.extent()) +
               per_coordinate * distance;
    }
};

/// Properties of a view besides its camera and size.
struct ViewOptions {
    /// The lower left pixel of the view's viewport in the target, for split screens and atlases.
    /// The viewport is `size_px` large. The frustum, pixel rectangles and read_depth are relative
    /// to the viewport; the device places it in the target.
    glm::ivec2 viewport_origin_px{0};

    /// Any number that tells the host's views apart. The library only hands it to the device.
    uint64_t tag = 0;

    /// Geometry between the eye and the near plane is drawn with the depth of the near plane
    /// (GL_DEPTH_CLAMP, shadow pancaking). Then the near plane culls nothing, and rule R1 concerns
    /// only boxes around the eye: none in an orthographic view.
    bool ignores_near_plane = false;

    bool operator==(const ViewOptions&) const = default;
};

class View {
public:
    View() = default;

    /// A view from the matrix that the engine draws with and the size of its viewport in pixels.
    /// The matrix includes the jitter of temporal antialiasing, because boxes must be tested with
    /// the matrix that draws. Any projection works: perspective, orthographic, off-centre, oblique,
    /// infinite, reversed. A matrix that is singular or not finite gives a view in which nothing
    /// can be culled.
    ///
    /// The engine is assumed to apply this matrix to world positions in float. The error of that
    /// grows with the distance from the world's origin, and so do the boxes of tests: culling is
    /// exact at any distance, but finds less hidden. Far worlds need camera_relative().
    static View from_clip(const glm::mat4& clip_from_world, glm::ivec2 size_px,
                          ClipConvention convention = {}, const ViewOptions& options = {});

    /// A view for engines that draw relative to the camera: `clip_from_relative` maps (position -
    /// origin) to clip space, and the engine subtracts before it rounds to float. The origin is the
    /// eye, or a point near it. Boxes stay in world space, in float; the library subtracts the
    /// origin from them. Only the precision of the boxes themselves depends on the distance from
    /// the world's origin.
    static View camera_relative(const glm::mat4& clip_from_relative, const glm::dvec3& origin,
                                glm::ivec2 size_px, ClipConvention convention = {},
                                const ViewOptions& options = {});

    /// The same camera seen from the space of an object; boxes are then in that space.
    /// Precondition: `world_from_object` is affine. A singular one gives a view in which nothing
    /// can be culled. About 0.5 us.
    View in_object(const glm::mat4& world_from_object) const;

    /// The matrix that from_clip() was given, or the same map rounded to float: for devices that
    /// draw in world coordinates.
    const glm::mat4& clip_from_world() const { return clip_from_world_; }
    /// The map from (position - origin()) to clip space: exactly the one that the view was made
    /// from.
    const glm::dmat4& clip_from_relative() const { return clip_from_relative_; }
    /// The point that positions are taken relative to: the origin given to camera_relative(), else
    /// the eye, or the middle of the near rectangle of an orthographic view.
    const glm::dvec3& origin() const { return origin_; }

    glm::ivec2 size_px() const { return size_px_; }
    ClipConvention convention() const { return convention_; }
    const Frustum& frustum() const { return frustum_; }
    const ViewOptions& options() const { return options_; }
    glm::ivec2 viewport_origin_px() const { return options_.viewport_origin_px; }
    uint64_t tag() const { return options_.tag; }
    bool ignores_near_plane() const { return options_.ignores_near_plane; }

    /// False if nothing is known of the camera (a matrix that is singular or not finite, no pixel):
    /// nothing can be culled.
    bool usable() const { return usable_; }

    /// Perspective: the world position of the eye. Orthographic: meaningless.
    const glm::vec3& eye() const { return eye_; }
    bool orthographic() const { return orthographic_; }

    /// A key that orders boxes near to far: for perspective the squared distance from the eye to
    /// the nearest point of the box, for orthographic the distance of its nearest corner along the
    /// view direction. Unbounded boxes come first, empty ones last.
    float distance_key(const Aabb& box) const;

    /// Rule R1: true if the near rectangle can touch the box, if the box is not bounded, or if
    /// nothing is known of the view. Then the box must not be tested, because its front faces may
    /// be clipped away, and counts as visible. `box` must be the box that is handed to the test:
    /// the result of inflated_for_test(). Errs toward true: a box counts as touching if it reaches
    /// in front of the near plane and is no farther from the eye than the near rectangle's corners,
    /// or if it is so near to the eye that rounding decides where it is drawn. If a box does not
    /// touch, no box inside it does, to the last bit.
    ///
    /// False does not mean that the whole box is before the eye: a wide floor under the eye may
    /// reach behind it without touching the near rectangle. Rasterisers clip it.
    bool touches_near(const Aabb& box) const;

    /// The box that must be handed to a test (rule R2). It is grown by at least 1/256 pixel in
    /// every direction on the screen, and a flat box gets some thickness. So its rasterisation
    /// covers a superset of the samples of anything in it, although the two come through different
    /// vertex streams. Always contains `box`; boxes that are not bounded stay unchanged. Devices
    /// also move the faces toward the viewer, by at least inflation().depth_bias.
    Aabb inflated_for_test(const Aabb& box) const;
    const Inflation& inflation() const { return inflation_; }

    /// An upper bound, in clip units, of the error of a position that the engine transforms in
    /// float, if no coordinate of (position - origin()) is larger than the same coordinate of
    /// `reach`.
    glm::vec4 clip_rounding(const glm::vec3& reach) const
    {
        return rounding_[0] * reach.x + rounding_[1] * reach.y + rounding_[2] * reach.z +
               rounding_[3];
    }

private:
    void set_camera(const glm::dmat4& clip_from_relative, const glm::dvec3& origin,
                    const glm::dmat4& magnitude);
    bool set_inflation(const glm::dmat4& rows, const glm::dmat4& magnitude);
    void set_near_rules(const glm::dmat4& rows, const glm::dmat4& magnitude, const glm::dvec3& eye);

    glm::mat4 clip_from_world_{1.0f};
    glm::dmat4 clip_from_relative_{1.0};
    glm::dvec3 origin_{0.0};
    glm::ivec2 size_px_{0};
    ClipConvention convention_;
    ViewOptions options_;
    Frustum frustum_;
    glm::vec3 eye_{0.0f};
    glm::vec3 eye_offset_{0.0f}; ///< from the origin in float
    float near_reach_ =
        Aabb::kInfinity;        ///< from the eye to the farthest corner of the near rectangle
    glm::vec2 near_slop_{0.0f}; ///< rounding near the eye: the part per unit of distance, and the
                                ///< constant part
    glm::mat4 rounding_{0.0f};  ///< clip_rounding(), column by column
    Inflation inflation_;
    bool orthographic_ = false;
    bool usable_ = false;
};

} // namespace occlude
