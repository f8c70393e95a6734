// Boxes against the depth of this frame: read back once or a few times, asked on the CPU.
//
//   rectangle   the box's rectangle of pixels and its nearest depth, against at most 4x4 texels
//   refined     where that does not hide it: the box itself, by its faces, texel by texel down to
//               pixels, as long as that pays; or its rectangle, down to pixels
//   a shape     the boxes of a shape (item_shapes.h), each by its rectangle and by its faces, in
//               the space of the object: until one of them is not hidden
//
// Guarantees  Errs toward "not hidden", as DepthPyramid and ScreenBox do.
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
    /// Without `refine` only rectangles are compared, with 4x4 texels, as on a GPU.
    explicit DepthTests(bool refine = true)
        : refine_(refine)
    {
    }

    /// Reads the farthest depth of tiles of this many pixels along a side from now on, where the
    /// device has such tiles (caps.depth_reads), and single pixels elsewhere. 1: pixels.
    void set_tile_px(int tile_px) { tile_px_ = tile_px; }

    /// Nothing is known of the frame that starts.
    void start_frame(SamplePositions samples)
    {
        known_ = false;
        samples_ = samples;
    }

    /// Where boxes are on the screen of this device. Precondition: bounds.size() == boxes.size().
    void project(const View& view, std::span<const Aabb> boxes,
                 std::span<ScreenBounds> bounds) const
    {
        project_boxes(view, boxes, bounds, Kernel::simd, samples_);
    }

    /// Allocates what read() needs, if it has not yet.
    void make_room(const View& view) { pyramid_.resize(view.size_px()); }

    /// Has everything drawn that is queued, and reads its depth back. False, and nothing else is
    /// known than before, if nothing was drawn or the device cannot read.
    bool read(CullFrame& frame);
    bool known() const { return known_; }

    /// True if everything in `box` is farther than what was drawn. The faces are tested with at
    /// most `max_texels`; 0: the rectangle instead. Invalid bounds are those of rule R1: visible.
    bool hides(const View& view, const Aabb& box, uint32_t max_texels) const;

    /// The rectangles of many boxes at once: 1 in `hidden` where one is enough.
    void rectangles_hide(std::span<const ScreenBounds> bounds, std::span<uint8_t> hidden) const;
    /// ... and a closer look at one of the others: its faces, or its rectangle down to pixels.
    bool refined_hides(const Aabb& box, const ScreenBounds& bounds, uint32_t max_texels) const;

    /// True if every box of the shape is farther than what was drawn, or misses the target. Their
    /// faces are tested with at most `max_texels` together.
    /// False under a map that is hard to invert.
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
