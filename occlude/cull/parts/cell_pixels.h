// Three ways to look at the pixels of a cell of an occlusion grid, behind one interface: depth read
// back pixel by pixel, the farthest depth of tiles, and occlusion queries of rectangles.
//
// Implements  Hey, Tobler, Purgathofer 2001, section 5. LazyGrid (lazy_grid.h) says which cells are
//             asked; the answers change the grid's cells here.
// Deviations  Section 5 queries the bounding volume itself in a cell and then stores its nearest
//             depth, which can be too near. QueriedPixels tests the part of the volume's rectangle
//             that lies in the cell, at that depth (world_from_rectangle()).
#pragma once

#include <occlude/cull/parts/cull_frame.h>
#include <occlude/cull/parts/occlusion_grid.h>
#include <occlude/screen/screen_box.h>

#include <cstdint>
#include <span>
#include <vector>

namespace occlude {

/// A cell whose pixels must be looked at, and the part of it that the tested volume covers.
struct AskedCell {
    glm::ivec2 cell{0};
    PixelRect part;
};

/// The question: is some pixel in one of the asked parts at `depth` or farther?
struct PixelQuestion {
    NodeId subject; ///< the node that is tested
    float depth = 0.0f;
    /// The faces of the volume: a pixel then counts only if the volume could be seen there. Null:
    /// the volume is its rectangle. Only depth that is read back takes faces into account.
    const ScreenBox* faces = nullptr;
};

class CellPixels {
public:
    /// How much one look at the device covers.
    enum class Join : uint8_t {
        cell,   ///< one cell, as in the paper
        rows,   ///< all cells of a question: whole rows of cells, or one batch of queries
        target, ///< like rows, but a read-back covers the whole target
    };

    /// Section 6: if at least `whole_cell_share` of a cell is asked about, the whole cell is looked
    /// at, so that the grid can keep the answer. 0: never.
    CellPixels(Join join, double whole_cell_share)
        : join_(join)
        , whole_cell_share_(whole_cell_share)
    {
    }
    virtual ~CellPixels() = default;

    /// Answers the question after all draws so far, and updates the cells of `grid`. Errs toward
    /// true, also if the device cannot answer.
    bool any_pixel_is_free(CullFrame& frame, OcclusionGrid& grid, const PixelQuestion& question,
                           std::span<const AskedCell> cells);

    /// The depth for the question whether a pixel was never drawn into.
    virtual float uncovered_depth() const = 0;
    /// The depth for the question about the state of all cells: no pixel can end it early.
    virtual float state_depth() const = 0;

protected:
    Join join() const { return join_; }
    bool asks_whole_cell(const OcclusionGrid& grid, const AskedCell& asked) const;

private:
    virtual bool look(CullFrame& frame, OcclusionGrid& grid, const PixelQuestion& question,
                      std::span<const AskedCell> cells) = 0;

    Join join_;
    double whole_cell_share_;
};

/// Depth that is read back by QueryDevice::read_depth, from a hardware or a software buffer.
class ReadBackPixels final : public CellPixels {
public:
    using CellPixels::CellPixels;

    float uncovered_depth() const override { return OcclusionGrid::kFarthest; }
    float state_depth() const override { return 2.0f; } // farther than any pixel

private:
    bool look(CullFrame& frame, OcclusionGrid& grid, const PixelQuestion& question,
              std::span<const AskedCell> cells) override;
    bool copy_rows(CullFrame& frame, OcclusionGrid& grid, std::span<const AskedCell> cells);
    const float* pixels_of(CullFrame& frame, const PixelRect& rect, size_t& stride);

    std::vector<float> pixels_; ///< a copy of the target's depth, or of one cell
};

/// Depth that the device reduced to the farthest of each tile (QueryDevice::read_depth_tiles). One
/// look covers the whole target. All pixels of a tile count as far as its farthest one. So more
/// pixels are free than with ReadBackPixels, and no additional box is hidden.
class TiledPixels final : public CellPixels {
public:
    /// Precondition of any_pixel_is_free(): caps.depth_reads lists tiles of `tile_px`.
    TiledPixels(double whole_cell_share, int tile_px)
        : CellPixels(Join::target, whole_cell_share)
        , tile_px_(tile_px)
    {
    }

    float uncovered_depth() const override { return OcclusionGrid::kFarthest; }
    float state_depth() const override { return 2.0f; } // farther than any pixel

private:
    bool look(CullFrame& frame, OcclusionGrid& grid, const PixelQuestion& question,
              std::span<const AskedCell> cells) override;
    bool read(CullFrame& frame, OcclusionGrid& grid);
    float farthest(const PixelRect& rect) const;
    bool any_tile_is_free(const PixelQuestion& question, const PixelRect& part) const;

    int tile_px_;
    glm::ivec2 size_in_tiles_{0};
    std::vector<float> tiles_;
};

/// Occlusion queries of rectangles that face the camera. They need no depth from the device.
class QueriedPixels final : public CellPixels {
public:
    using CellPixels::CellPixels;

    float uncovered_depth() const override;
    float state_depth() const override { return uncovered_depth(); }

private:
    /// A test in `batch_`.
    struct RectangleTest {
        glm::ivec2 cell;
        bool whole; ///< it covers all pixels of the cell
        bool part;  ///< it covers exactly the asked part
    };

    bool look(CullFrame& frame, OcclusionGrid& grid, const PixelQuestion& question,
              std::span<const AskedCell> cells) override;
    bool add_rectangle(const View& view, const PixelQuestion& question, const PixelRect& rect,
                       RectangleTest test);
    bool read_answers(CullFrame& frame, OcclusionGrid& grid, float depth);

    TestBatch batch_;
    std::vector<RectangleTest> rectangles_; ///< one per test in `batch_`
    std::vector<glm::mat4> maps_; ///< of each rectangle: from the unit square to the world
    std::vector<Ticket> tickets_;
};

} // namespace occlude
