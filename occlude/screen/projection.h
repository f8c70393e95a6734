// Where a box lies on the screen: a rectangle of pixels and a range of depth around all of it.
//
// For algorithms that compare boxes with depth they have read back, instead of asking the device.
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
    anywhere, ///< in the pixel: multisampled, or not known
    center,   ///< one, in the middle
};

/// Bounds of everything that can be drawn of a box, as QueryDevice::read_depth sees it.
struct ScreenBounds {
    /// By how much near_depth and far_depth reach beyond the box, in window depth, besides the
    /// rounding of the transform: 16 steps of a 24-bit depth buffer. It pays for the rounding of
    /// the buffer and of the interpolation across triangles, as GlDevice does for its test boxes.
    static constexpr float kDepthMargin = 0x1p-20f;

    PixelRect rect; ///< inside the target; size 0 (both) if no pixel of the target can be touched
    float near_depth = 0.0f; ///< window depth, 0 near to 1 far in every convention
    float far_depth = 1.0f;  ///< the same
    bool valid = false;      ///< false: the near plane or the eye may touch the box, or it is not
                        ///< bounded, or nothing is known of the view. It counts as visible, all
                        ///< over the target (`rect` is the target), and hides nothing.
};

/// The screen bounds of `box` (the box around the things themselves, not inflated: that is done
/// here, rule R2). Errs outward: every sample that anything in the box covers lies in `rect`, at a
/// depth from near_depth to far_depth. Hence: if near_depth is greater than the farthest depth read
/// back in all of `rect`, then nothing in the box is visible. `rect` is tighter where samples are
/// in the middle of pixels: many small boxes have none. Invalid under rule R1, and for boxes that
/// reach behind the near plane anywhere, seen or not. An empty box gives a valid, empty rect. About
/// 0.1 us, half of it for the view: many boxes are cheaper at once.
ScreenBounds project(const View& view, const Aabb& box,
                     SamplePositions samples = SamplePositions::anywhere);

/// Writes project(view, boxes[i], samples) to bounds[i], to the bit, with either kernel.
/// Precondition: bounds.size() == boxes.size(). With vectors of 16 lanes about
/// 5 ns per box, one after the other 30 ns.
void project_boxes(const View& view, std::span<const Aabb> boxes, std::span<ScreenBounds> bounds,
                   Kernel kernel = Kernel::simd,
                   SamplePositions samples = SamplePositions::anywhere);

/// The same of boxes in the space of an object, which are inflated there: `inflation` is
/// Inflation::in() of that space. About 0.1 us more.
void project_boxes(const View& view, const glm::mat4& world_from_object, const Inflation& inflation,
                   std::span<const Aabb> boxes, std::span<ScreenBounds> bounds,
                   Kernel kernel = Kernel::simd,
                   SamplePositions samples = SamplePositions::anywhere);

/// The same of the boxes of tests: in their own spaces, and inflated already. Precondition:
/// bounds.size() == boxes.size().
void project_query_boxes(const View& view, std::span<const QueryBox> boxes,
                         std::span<ScreenBounds> bounds);

/// The affine map from the unit square (0..1, 0..1, 0) to a rectangle in the world that faces the
/// camera: on the screen it covers every sample of the pixels in `rect` (and no centre of another
/// pixel), nowhere farther than the window depth `depth`, as a device would draw it. Together with
/// the box from (0, 0, 0) to (1, 1, 0) this is what QueryBox takes: a test that finds no sample
/// proves all of `rect` to be nearer than `depth`. Nothing if there is no such rectangle before the
/// near plane, if the test would touch the near plane (C5), or if planes of constant depth do not
/// face the camera (oblique near planes). Precondition: `rect` is in the target and not empty.
std::optional<glm::mat4> world_from_rectangle(const View& view, const PixelRect& rect, float depth);

} // namespace occlude
