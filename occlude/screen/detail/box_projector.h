// A view as the projection of boxes to the screen needs it, and the projection itself, as scalar
// and as vector code.
#pragma once

#include <occlude/core/view.h>
#include <occlude/screen/projection.h>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace occlude::detail {

/// A view as columns that map (point - inflation.origin) to (x, y, depth, 1) * w, with x and y in
/// pixels and depth from 0 (near) to 1 (far), and the possible errors of the device and of our own
/// arithmetic. See box_projector.cpp.
struct BoxProjector {
    /// For boxes in the world that project() must inflate.
    BoxProjector(const View& view, SamplePositions samples);
    /// For boxes of tests in the space of `world_from_box`, which are inflated already.
    BoxProjector(const View& view, const glm::mat4& world_from_box);
    /// For boxes of tests in world space, which are inflated already.
    static BoxProjector of_tests(const View& view);
    /// For boxes in the space of `world_from_box` that project() must inflate in that space.
    BoxProjector(const View& view, const glm::mat4& world_from_box, const Inflation& inflation,
                 SamplePositions samples);

    /// The specification of project() and project_boxes().
    void project(const Aabb& box, ScreenBounds& bounds) const;

    /// With more rounding than this (NaN included) nothing is certain, and with a smaller w no
    /// quotient is. Between these bounds no result overflows.
    static constexpr float kLargestSlop = 0x1p40f;
    static constexpr float kSmallestW = 0x1p-60f;

    void set_columns(const View& view, const glm::dmat4& clip, const glm::dmat4& rounding);
    void set_object_columns(const View& view, const glm::mat4& world_from_box);

    std::array<glm::vec4, 4> column{}; ///< the contributions of one unit of x, y and z, and the
                                       ///< origin
    std::array<glm::vec4, 4> slop{};   ///< the possible errors of these, for coordinates >= 0
    Inflation inflation;
    glm::vec2 size{0.0f};
    float sample_inset_px = 0.0f; ///< every sample is at least this far from a border of its pixel
    float least_depth = 0.0f;     ///< of a corner, times w; -infinity if depth is clamped
    ScreenBounds everywhere;      ///< the result for a box of which nothing is known
    bool usable = false;          ///< there is a near plane, and the view is known
};

/// ScreenBounds of some boxes, field by field, as vectors write and read them. Small enough for the
/// nearest cache.
struct BoundsBlock {
    static constexpr size_t kBoxes = 128;
    template <class T>
    using Field = std::array<T, kBoxes>;

    void set(size_t i, const ScreenBounds& b)
    {
        x[i] = b.rect.x;
        y[i] = b.rect.y;
        width[i] = b.rect.width;
        height[i] = b.rect.height;
        near_depth[i] = b.near_depth;
        far_depth[i] = b.far_depth;
        valid[i] = b.valid ? 1 : 0;
    }
    PixelRect rect(size_t i) const { return {x[i], y[i], width[i], height[i]}; }
    ScreenBounds operator[](size_t i) const
    {
        return {rect(i), near_depth[i], far_depth[i], valid[i] != 0};
    }

    alignas(64) Field<int32_t> x;
    alignas(64) Field<int32_t> y;
    alignas(64) Field<int32_t> width;
    alignas(64) Field<int32_t> height;
    alignas(64) Field<float> near_depth;
    alignas(64) Field<float> far_depth;
    alignas(64) Field<int32_t> valid;
};

/// Calls p.project() for at most BoundsBlock::kBoxes boxes, several at once.
void project_boxes_simd(const BoxProjector& p, std::span<const Aabb> boxes, BoundsBlock& bounds);

} // namespace occlude::detail
