// The lazy occlusion grid: boxes against the farthest depth of screen cells, updated only if asked.
//
// Implements  H. Hey, R. F. Tobler, W. Purgathofer, "Real-Time Occlusion Culling with a Lazy
//             Occlusion Grid", Eurographics Workshop on Rendering 2001.
// Map         cell states, sec. 3.1 and 3.2         -> OcclusionGrid::Cell (occlusion_grid.h)
//             Fig. 2 and 3 isOccluded               -> LazyGrid::is_occluded
//               internalCellIsFreeWithoutPixelquery -> internal_cell_is_free_without_pixel_query
//               borderCellIsFreeWithoutPixelquery   -> border_cell_is_free_without_pixel_query
//               internalCellIsFreeWithPixelquery,
//               borderCellIsFreeWithPixelquery      -> any_cell_is_free_with_pixel_query
//             Fig. 4 (one list), Fig. 6 (two lists) -> cull_frame
//             sec. 5 hardware queries               -> any_query_passes
//             sec. 6 extensions                     -> free_below_covered, whole_cell_share,
//                                                      internal_above_pixels
//             sec. 7 busy update                    -> update_busily
// Deviations  One isOccluded serves both variants: the occlusion buffer is the z-buffer asked about
//             depth zmax = 1. Fig. 3 calls a border cell free if its zfar is zmax: wrong for cells
//             that were drawn into since (corrected in kind), and needlessly visible for cells that
//             are partly sky; here only a cell that nothing was drawn into is free unasked, as in
//             Fig. 2. Sec. 5 tests the bounding volume in a cell and then stores its znear, which
//             can be too near; here the part of the box's rectangle in the cell is tested at depth
//             znear itself. A cell that a query found free remembers at which depth. Boxes that the
//             near plane may touch are visible (rule R1). Both traversals test the frustum when a
//             box enters the list (Fig. 6), not when it leaves it (Fig. 4). Tests that need pixels
//             are made several at a time (tests_at_once; 1 is the paper). With bounds=faces the box
//             of what would be drawn is compared as what it is, not as its rectangle at its nearest
//             depth. Sec. 6 adds the areas of primitives up; here the rectangles of drawn boxes.
// Guarantees  exact, with every option: a box is hidden only if, in this frame, all pixels of its
//             screen rectangle were seen to be nearer than its nearest depth, or than the box at
//             that pixel. Needs no history, so camera cuts and moving objects cost nothing extra.
// Cost        needs depth in the same frame: each change from drawing to looking waits for the
//             device to finish. A cell asked costs the reading of at most cell_size^2 pixels.
#pragma once

#include <occlude/cull/culler.h>
#include <occlude/cull/parts/cull_frame.h>
#include <occlude/cull/parts/occlusion_grid.h>
#include <occlude/screen/projection.h>
#include <occlude/screen/screen_box.h>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace occlude {

struct LazyGridOptions {
    enum class Variant : uint8_t {
        z_buffer,         ///< a box is hidden behind nearer pixels (Fig. 3)
        occlusion_buffer, ///< a box is hidden behind covered pixels (Fig. 2); always two_lists
    };
    enum class Update : uint8_t {
        lazy, ///< a cell is looked at when a test needs it
        busy, ///< all cells of a drawn box are looked at after its draw, for comparison
    };
    enum class Traversal : uint8_t {
        one_list,  ///< boxes by nearest depth; visible ones are drawn at once (Fig. 4)
        two_lists, ///< tests by nearest, draws by farthest depth, whichever is less (Fig. 6)
    };
    enum class Source : uint8_t {
        depth,   ///< pixels are read back: QueryDevice::read_depth, hardware or software buffer
        queries, ///< occlusion queries of cell-clipped rectangles; z_buffer is then always lazy
    };
    enum class Join : uint8_t {
        cell,   ///< one read-back or query batch for each cell asked, as in the paper
        rows,   ///< all cells that a test may ask at once: rows of cells, or one batch of queries
        target, ///< as rows, but a read-back takes the whole target
    };
    enum class Bounds : uint8_t {
        rectangle, ///< a box is its rectangle of pixels at its nearest depth, as in the paper
        faces,     ///< so is that of an inner node; one of items is what is between its faces
    };

    Variant variant = Variant::z_buffer;
    Update update = Update::lazy;
    Traversal traversal = Traversal::one_list;
    Source source = Source::depth;
    Join join = Join::cell;
    Bounds bounds = Bounds::rectangle;
    /// Side of a cell in pixels; 0 counts as 1.
    uint32_t cell_size = 32;
    /// Tests that need pixels wait until this many do, and are then made against the same depth:
    /// fewer changes from drawing to looking, and hidden boxes just behind each other are found
    /// less often. 1: each test at once, as in the paper.
    uint32_t tests_at_once = 32;
    /// A cell that must be asked counts as free, unasked, while the rectangles of the boxes drawn
    /// into it add up to less than this share of its area. 0: off.
    double free_below_covered = 0.0;
    /// A border cell of which the box covers at least this share is asked as a whole first, so that
    /// the answer can be kept. 0: off.
    double whole_cell_share = 0.0;
    /// A box whose rectangle has at least this many pixels has only internal cells. 0: off.
    uint64_t internal_above_pixels = 0;
};

class LazyGrid final : public Culler {
public:
    explicit LazyGrid(const Hierarchy& hierarchy, LazyGridOptions options = {});

    /// What the grid knew at the end of the last frame.
    const OcclusionGrid& grid() const { return grid_; }

private:
    struct Entry {
        ScreenBounds bounds;
        NodeId node;
        PlaneMask mask;
    };
    enum class Verdict : uint8_t { occluded, visible, needs_pixels };
    /// A cell that must be asked, and the part of it that the box covers.
    struct AskedCell {
        glm::ivec2 cell;
        PixelRect part;
    };
    /// A test in `batch_`.
    struct RectangleTest {
        glm::ivec2 cell;
        bool whole; ///< it covers all pixels of the cell
        bool part;  ///< it covers the asked part and no more
    };

    void cull_frame(CullFrame& frame) override;
    void reset_state() override {}

    // --- the traversal ---
    bool has_items(NodeId node) const ///< that are drawn where its box is seen
    {
        return hierarchy().is_leaf(node) || hierarchy().node(node).own_items > 0;
    }
    void insert(CullFrame& frame, NodeId node, PlaneMask mask);
    bool draw_comes_before(std::span<const Entry> tests) const;
    void test(CullFrame& frame, const Entry& entry);
    void test_waiting(CullFrame& frame);
    void handle(CullFrame& frame, const Entry& entry, Verdict verdict);
    void draw(CullFrame& frame, const Entry& entry);

    // --- the occlusion test ---
    float depth_to_beat(const ScreenBounds& bounds) const;
    bool faces_are_behind(const OcclusionGrid::Cell& cell, const PixelRect& part);
    const ScreenBox& faces();
    bool is_improbable(const OcclusionGrid::Cell& cell) const;
    Verdict verdict_without_pixels(const Entry& entry);
    bool is_occluded(CullFrame& frame, const Entry& entry);
    bool internal_cell_is_free_without_pixel_query(const CellRange& internal, float depth);
    bool border_cell_is_free_without_pixel_query(const CellRange& touched,
                                                 const CellRange& internal, const PixelRect& rect,
                                                 float depth);
    bool any_cell_is_free_with_pixel_query(CullFrame& frame, NodeId subject,
                                           std::span<const AskedCell> asked, float depth);
    bool asks_whole_cell(const AskedCell& asked) const;

    // --- looking at pixels: true if a pixel of any part is at `depth` or farther ---
    bool any_pixel_passes(CullFrame& frame, NodeId subject, std::span<const AskedCell> asked,
                          float depth);
    bool any_pixel_is_as_far(CullFrame& frame, std::span<const AskedCell> asked, float depth);
    bool any_query_passes(CullFrame& frame, NodeId subject, std::span<const AskedCell> asked,
                          float depth);
    bool add_rectangle(CullFrame& frame, NodeId subject, const PixelRect& rect, float depth,
                       RectangleTest test);
    bool copy_rows(CullFrame& frame, std::span<const AskedCell> asked);
    const float* pixels_of(CullFrame& frame, const PixelRect& rect, size_t& stride);
    void update_busily(CullFrame& frame, const Entry& entry);

    LazyGridOptions options_;
    OcclusionGrid grid_;
    ScreenSpace screen_;             ///< with Bounds::faces
    const Aabb* tested_ = nullptr;   ///< the same: the box that is tested, ...
    std::optional<ScreenBox> faces_; ///< ... and its faces, once they were needed
    std::vector<Entry> test_list_;   ///< a heap by nearest depth
    std::vector<Entry> draw_list_;   ///< a heap by farthest depth
    std::vector<Entry> waiting_;     ///< tests that need pixels
    std::vector<Verdict> verdicts_;
    std::vector<AskedCell> internal_; ///< internalPixelqueryList
    std::vector<AskedCell> border_;   ///< borderPixelqueryList
    std::vector<float> pixels_;       ///< copy of the target's depth, or of one cell
    TestBatch batch_;
    std::vector<RectangleTest> rectangles_; ///< of the tests in `batch_`
    std::vector<glm::mat4> maps_;           ///< ... from the unit square to the world
    std::vector<Ticket> tickets_;
};

constexpr std::array<std::string_view, 2> option_names(LazyGridOptions::Variant)
{
    return {"z_buffer", "occlusion_buffer"};
}
constexpr std::array<std::string_view, 2> option_names(LazyGridOptions::Update)
{
    return {"lazy", "busy"};
}
constexpr std::array<std::string_view, 2> option_names(LazyGridOptions::Traversal)
{
    return {"one_list", "two_lists"};
}
constexpr std::array<std::string_view, 2> option_names(LazyGridOptions::Source)
{
    return {"depth", "queries"};
}
constexpr std::array<std::string_view, 3> option_names(LazyGridOptions::Join)
{
    return {"cell", "rows", "target"};
}
constexpr std::array<std::string_view, 2> option_names(LazyGridOptions::Bounds)
{
    return {"rectangle", "faces"};
}
template <class Visit>
void visit_options(LazyGridOptions& o, Visit&& visit)
{
    visit("variant", o.variant, "what hides a box: nearer pixels, or pixels that are covered");
    visit("update", o.update, "when cells are looked at: if a test needs them, or after each draw");
    visit("traversal", o.traversal, "one list by nearest depth, or tests and draws apart");
    visit("source", o.source, "how pixels are looked at: read back, or by occlusion queries");
    visit("join", o.join, "what one read-back or query batch takes");
    visit("bounds", o.bounds, "what is compared with depth: the rectangle of a box, or its faces");
    visit("cell_size", o.cell_size, "side of a cell in pixels");
    visit("tests_at_once", o.tests_at_once,
          "tests that need pixels are made this many at a time; 1: as in the paper");
    visit("free_below_covered", o.free_below_covered,
          "cells covered less than this share by drawn boxes are free unasked; 0: off");
    visit("whole_cell_share", o.whole_cell_share,
          "border cells covered at least this share by the box are asked as a whole; 0: off");
    visit("internal_above_pixels", o.internal_above_pixels,
          "boxes of at least this many pixels have only internal cells; 0: off");
}

} // namespace occlude
