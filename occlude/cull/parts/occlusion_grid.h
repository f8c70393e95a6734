// The grid of the lazy occlusion grid: what is known of the pixels in each cell of the screen.
//
// It neither draws nor reads. LazyGrid (lazy_grid.h) queries it; if it does not know, CellPixels
// (cell_pixels.h) looks at pixels and stores the result here.
//
// A cell stores zfar, an upper bound of the depth of its pixels. Drawing only lowers depths, so a
// box that is farther than zfar stays hidden in this cell for the rest of the frame. A cell also
// stores known_free, a depth that some pixel is known to reach. Drawing makes it unknown. The
// states of the paper are:
//
//   completely free   untouched: nothing was drawn into it
//   outdated          drawn into since its pixels were looked at: known_free is kUnknown
//   partially free    looked at, with a pixel of depth 1 (zmax) left: zfar is 1
//   full              looked at, with none: zfar < 1; it stays so
//
// So the occlusion-buffer variant is the z-buffer variant with depth 1 instead of the box's own
// nearest depth.
#pragma once

#include <occlude/core/assert.h>
#include <occlude/core/query_device.h>
#include <occlude/screen/screen_box.h>

#include <glm/vec2.hpp>

#include <span>
#include <vector>

namespace occlude {

/// Cells [begin, end) in both directions.
struct CellRange {
    glm::ivec2 begin{0};
    glm::ivec2 end{0};

    bool contains(glm::ivec2 cell) const
    {
        return cell.x >= begin.x && cell.y >= begin.y && cell.x < end.x && cell.y < end.y;
    }
};

/// The pixels that two rectangles share; size 0 (both) if none.
PixelRect intersection(const PixelRect& a, const PixelRect& b);

class OcclusionGrid {
public:
    static constexpr float kFarthest = 1.0f; ///< zmax: the depth of a pixel never drawn into
    static constexpr float kUnknown = -1.0f;

    struct Cell {
        float zfar = kFarthest;
        float known_free = kFarthest; ///< some pixel is at least this far; kUnknown: outdated
        float covered = 0.0f;         ///< the summed area of rectangles drawn into it, relative to
                                      ///< its own area
        bool untouched = true;
        bool copied = false; ///< its pixels were read back since the last draw into it
    };

    /// Starts a frame: all cells are free. `cell_size` >= 1, in pixels. The right and upper edge of
    /// the target cut cells off. Allocates only when the grid grows.
    void reset(glm::ivec2 size_px, int cell_size);

    glm::ivec2 size_in_cells() const { return cells_in_; }
    Cell& cell(glm::ivec2 at) { return cells_[index(at)]; }
    const Cell& cell(glm::ivec2 at) const { return cells_[index(at)]; }

    /// The pixels of a cell.
    PixelRect pixels(glm::ivec2 cell) const;
    /// The cells that share a pixel with `rect`, which lies in the target.
    CellRange touched(const PixelRect& rect) const;
    /// The internal cells: all their pixels lie in `rect`. The other touched cells are border
    /// cells.
    CellRange internal(const PixelRect& rect) const;

    /// Records a draw with these screen bounds: the touched cells become outdated. Precondition:
    /// the rectangle lies in the target.
    void mark_drawn(const PixelRect& rect);

    /// Records that the farthest of all pixels of the cell is at `zfar`.
    void update(glm::ivec2 cell, float zfar);
    /// Records that all pixels of the cell are nearer than `depth`.
    void learn_hidden(glm::ivec2 cell, float depth);
    /// Records that some pixel of the cell is at `depth` or farther.
    void learn_free(glm::ivec2 cell, float depth);

private:
    size_t index(glm::ivec2 at) const
    {
        OCCLUDE_ASSERT(at.x >= 0 && at.y >= 0 && at.x < cells_in_.x && at.y < cells_in_.y,
                       "the cell must lie in the grid");
        return static_cast<size_t>(at.y) * static_cast<size_t>(cells_in_.x) +
               static_cast<size_t>(at.x);
    }

    glm::ivec2 size_px_{0};
    glm::ivec2 cells_in_{0};
    int cell_size_ = 1;
    std::vector<Cell> cells_;
};

/// The largest of depths >= 0, or 0 if there are none; `stride` floats lie between rows. Several
/// times faster than std::max_element.
float farthest_depth(const float* depths, size_t width, size_t height, size_t stride);

/// True only if every sample of anything in `box` that lies in `part` is farther than its pixel.
/// `depths` begins with the first pixel of `part`; `stride` floats lie between rows.
bool hides(const float* depths, size_t stride, const PixelRect& part, const ScreenBox& box);

} // namespace occlude
