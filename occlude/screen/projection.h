// The place of a box on the screen: a rectangle of pixels and a range of depth that bound all of
// it.
//
// For algorithms that compare boxes with depth that they read back, instead of asking the device.
#pragma once

#include <occlude/core/aabb.h>
#include <occlude/core/query_device.h>
#include <occlude/core/view.h>
#include <occlude/screen/kernel.h>

#include <glm/mat4x4.hpp>

#include <cstdint>
#include <optional>
#include <span>

namespace occlude {

/// Where the samples of a pixel are.
enum class SamplePositions : uint8_t {
    anywhere, ///< anywhere in the pixel: multisampled, or unknown
    center,   ///< one sample, in the middle
};

/// Bounds of everything that can be drawn of a box, as QueryDevice::read_depth sees it.
struct ScreenBounds {
    /// How far near_depth and far_depth reach beyond the box, in window depth, apart from the
    /// rounding of the transform: 16 steps of a 24-bit depth buffer. This covers the rounding of
    /// the buffer and of the interpolation across triangles, as GlDevice does for its test boxes.
    static constexpr float kDepthMargin = 0x1p-20f;

    PixelRect rect; ///< inside the target; size 0 (both) if the box touches no pixel of the target
    float near_depth = 0.0f; ///< window depth, 0 near to 1 far in every convention
    float far_depth = 1.0f;  ///< window depth, too
    bool valid = false;      ///< false: the near plane or the eye may touch the box, or it is not
                        ///< bounded, or nothing is known of the view. It counts as visible, all
                        ///< over the target (`rect` is the target), and hides nothing.
};

/// The screen bounds of `box`. It must bound the contents and not be inflated, because this
/// function inflates it (rule R2). Errs outward: every sample that anything in the box covers lies
/// in `rect`, at a depth from near_depth to far_depth. So if near_depth is greater than the
/// farthest depth read back in all of `rect`, nothing in the box is visible. `rect` is tighter if
/// samples are in the middle of pixels: many small boxes have none. Invalid under rule R1, and for
/// boxes that reach behind the near plane anywhere, on the screen or not. An empty box gives a
/// valid, empty rect. About 0.1 us, half of it for the view; project_boxes() is cheaper for many
/// boxes.
ScreenBounds project(const View& view, const Aabb& box,
                     SamplePositions samples = SamplePositions::anywhere);

/// Writes project(view, boxes[i], samples) to bounds[i], equal to the bit with either kernel.
/// Precondition: bounds.size() == boxes.size(). About 5 ns per box with vectors of 16 lanes, 30 ns
/// without vectors.
void project_boxes(const View& view, std::span<const Aabb> boxes, std::span<ScreenBounds> bounds,
                   Kernel kernel = Kernel::simd,
                   SamplePositions samples = SamplePositions::anywhere);

/// The same for boxes in the space of an object, which are inflated there: `inflation` is
/// Inflation::in() of that space. About 0.1 us more.
void project_boxes(const View& view, const glm::mat4& world_from_object, const Inflation& inflation,
                   std::span<const Aabb> boxes, std::span<ScreenBounds> bounds,
                   Kernel kernel = Kernel::simd,
                   SamplePositions samples = SamplePositions::anywhere);

/// The same for the boxes of tests, which are in their own spaces and inflated already.
/// Precondition: bounds.size() == boxes.size().
void project_query_boxes(const View& view, std::span<const QueryBox> boxes,
                         std::span<ScreenBounds> bounds);

/// The affine map from the unit square (0..1, 0..1, 0) to a rectangle in the world that faces the
/// camera. On the screen the rectangle covers every sample of the pixels in `rect` and no centre of
/// another pixel. As a device draws it, it is nowhere farther than the window depth `depth`. Make a
/// QueryBox of this map and the box from (0, 0, 0) to (1, 1, 0): a test that finds no sample proves
/// that all of `rect` is nearer than `depth`. Returns nothing if there is no such rectangle before
/// the near plane, if the test would touch the near plane (C5), or if planes of constant depth do
/// not face the camera (oblique near planes). Precondition: `rect` is in the target and not empty.
std::optional<glm::mat4> world_from_rectangle(const View& view, const PixelRect& rect, float depth);

} // namespace occlude
