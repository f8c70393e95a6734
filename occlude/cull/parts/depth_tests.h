// Tests boxes on the CPU against the depth of this frame, which is read back once or a few times.
//
//   rectangle   the box's rectangle of pixels and its nearest depth, against at most 4x4 texels
//   refined     if that does not hide it: the box itself, by its faces, texel by texel down to
//               pixels, while that pays; or its rectangle, down to pixels
//   a shape     the boxes of a shape (item_shapes.h), each by its rectangle and by its faces, in
//               the space of the object, until one of them is not hidden
//
// Guarantees  errs toward "not hidden", as DepthPyramid and ScreenBox do.
#pragma once

#include <occlude/hierarchy/item_shapes.h>
#include <occlude/screen/depth_pyramid.h>
#include <occlude/screen/projection.h>
#include <occlude/screen/screen_box.h>

#include <cstdint>
#include <span>

namespace occlude {

class CullFrame;

class DepthTests {
public:
    /// Without `refine`, only rectangles are compared, with at most 4x4 texels, as on a GPU.
    explicit DepthTests(bool refine = true)
        : refine_(refine)
    {
    }

    /// From now on, reads the farthest depth of tiles of this many pixels along a side, if the
    /// device offers such tiles (caps.depth_reads), and single pixels otherwise. 1: pixels.
    void set_tile_px(int tile_px) { tile_px_ = tile_px; }

    /// Starts a frame, of whose depth nothing is known.
    void start_frame(SamplePositions samples)
    {
        known_ = false;
        samples_ = samples;
    }

    /// Projects boxes for the samples of this device. Precondition: bounds.size() == boxes.size().
    void project(const View& view, std::span<const Aabb> boxes,
                 std::span<ScreenBounds> bounds) const
    {
        project_boxes(view, boxes, bounds, Kernel::simd, samples_);
    }

    /// Allocates the memory of read(), unless it has been allocated.
    void make_room(const View& view) { pyramid_.resize(view.size_px()); }

    /// Draws everything that is queued, and reads the depth of it. Returns false and keeps the last
    /// depth if nothing was drawn or the device cannot read.
    bool read(CullFrame& frame);
    bool known() const { return known_; }

    /// True if everything in `box` is farther than what was drawn. Its faces are tested with at
    /// most `max_texels`; 0 tests its rectangle instead. Invalid bounds (rule R1) are visible.
    bool hides(const View& view, const Aabb& box, uint32_t max_texels) const;

    /// Tests the rectangles of many boxes at once: sets `hidden` to 1 if a rectangle suffices.
    void rectangles_hide(std::span<const ScreenBounds> bounds, std::span<uint8_t> hidden) const;
    /// Looks closer at a box whose rectangle did not hide it: by its faces, or down to pixels.
    bool refined_hides(const Aabb& box, const ScreenBounds& bounds, uint32_t max_texels) const;

    /// True if every box of the shape is farther than what was drawn, or outside the target. The
    /// faces of all boxes are tested with at most `max_texels` together.
    /// False if the map to the world is hard to invert.
    bool hides(const View& view, const ItemShapes::Placed& placed, uint32_t max_texels) const;

private:
    bool read_pixels_or_tiles(CullFrame& frame);

    bool refine_;
    int tile_px_ = 1;
    DepthPyramid pyramid_;
    ScreenSpace screen_;
    SamplePositions samples_ = SamplePositions::anywhere;
    bool known_ = false;
};

} // namespace occlude
