// The lazy occlusion grid: boxes against the farthest depth of screen cells. A cell is updated only
// when a test needs it.
//
// Implements  H. Hey, R. F. Tobler, W. Purgathofer, "Real-Time Occlusion Culling with a Lazy
//             Occlusion Grid", Eurographics Workshop on Rendering 2001.
// Map         cell states, sec. 3.1 and 3.2         -> OcclusionGrid::Cell (occlusion_grid.h)
//             Fig. 2 and 3 isOccluded               -> LazyGrid::is_occluded
//               internalCellIsFreeWithoutPixelquery -> internal_cell_is_free_without_pixel_query
//               borderCellIsFreeWithoutPixelquery   -> border_cell_is_free_without_pixel_query
//               internalCellIsFreeWithPixelquery    -> internal_cell_is_free_with_pixel_query
//               borderCellIsFreeWithPixelquery      -> border_cell_is_free_with_pixel_query
//             Fig. 4 (one list), Fig. 6 (two lists) -> LazyGrid::cull_frame
//             sec. 5 hardware support               -> ReadBackPixels, TiledPixels,
//                                                      QueriedPixels (cell_pixels.h)
//             sec. 6 extensions                     -> is_improbable, asks_whole_cell,
//                                                      internal_cells
//             sec. 7 busy update                    -> update_busily
// Deviations  One isOccluded serves both variants: the occlusion buffer is the z-buffer asked about
//             depth zmax = 1. Fig. 3 calls a border cell free if its zfar is zmax. That is wrong
//             for a cell that was drawn into since, and needlessly visible for a cell that is
//             partly sky. Here, as in Fig. 2, a cell is free without a pixel query only if nothing
//             was drawn into it. A cell that a query found free remembers at which depth. Boxes
//             that the near plane may touch are visible (rule R1). Both traversals test the frustum
//             when a box enters the list (Fig. 6), not when it leaves it (Fig. 4). Several tests
//             that need pixels are made together (tests_at_once; 1 is the paper). With bounds=faces
//             the box of a node with items is compared as a box, not as its rectangle at its
//             nearest depth. Sec. 6 adds up the areas of primitives, this class the rectangles of
//             drawn boxes. If items are drawn out of turn (never_cull), the occlusion buffer
//             compares boxes with depth, because a covered pixel then proves nothing.
// Guarantees  exact, with every option: a box is hidden only if, in this frame, all pixels of its
//             screen rectangle were seen to be nearer than its nearest depth, or than the box at
//             the same pixel. Nothing is kept between frames: camera cuts and moving objects cost
//             nothing extra.
// Cost        Each change from drawing to reading waits for the device to finish. A pixel query of
//             a cell reads at most cell_size^2 pixels. Needs depth in the same frame.
#pragma once

#include <occlude/core/option_range.h>
#include <occlude/cull/culler.h>
#include <occlude/cull/parts/cell_pixels.h>
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
        busy, ///< all cells of a drawn box are looked at after its draw (sec. 7, for comparison)
    };
    enum class Traversal : uint8_t {
        one_list,  ///< one list of boxes by nearest depth; visible boxes are drawn at once (Fig. 4)
        two_lists, ///< tests by nearest and draws by farthest depth; the nearer of the two comes
                   ///< next (Fig. 6)
    };
    enum class Source : uint8_t {
        depth,   ///< pixels are read back by QueryDevice::read_depth, from a hardware or software
                 ///< buffer
        queries, ///< occlusion queries of rectangles in a cell; z_buffer is then always updated
                 ///< lazily
    };
    using Join = CellPixels::Join; ///< what one look at pixels reads
    enum class Bounds : uint8_t {
        rectangle, ///< a box is its rectangle of pixels at its nearest depth, as in the paper
        faces,     ///< the box of a node with items is the space between its faces
    };

    Variant variant = Variant::z_buffer;
    Update update = Update::lazy;
    Traversal traversal = Traversal::one_list;
    Source source = Source::depth;
    Join join = Join::cell;
    Bounds bounds = Bounds::rectangle;
    /// Side of a cell in pixels.
    uint32_t cell_size = 32;
    /// A test that needs pixels waits until there are this many. They all look at the same depth,
    /// which saves changes from drawing to reading, but boxes that lie close behind one another are
    /// not hidden by one another. 1: no test waits, as in the paper.
    uint32_t tests_at_once = 32;
    /// Section 6: a cell counts as free without a pixel query while the rectangles of the boxes
    /// drawn into it add up to less than this share of its area. 0: off.
    double free_below_covered = 0.0;
    /// Section 6: if the box covers at least this share of a border cell, the whole cell is
    /// queried, so that the answer can be kept. 0: off.
    double whole_cell_share = 0.0;
    /// Section 6: a box whose rectangle has at least this many pixels has only internal cells. 0:
    /// off.
    uint64_t internal_above_pixels = 0;
    /// With Source::depth: reads the farthest depth of tiles of this many pixels along a side,
    /// which the device reduces, if it offers such tiles. `join` is then `target`. 1: reads single
    /// pixels.
    uint32_t tile = 1;
};

class LazyGrid final : public Culler {
public:
    using Options = LazyGridOptions;
    static constexpr AlgorithmTraits kTraits{
        .name = "lazy_grid",
        .paper = "Hey, Tobler, Purgathofer 2001",
        .summary =
            "compares boxes with the farthest depth of screen cells, which it updates on demand",
        .needs = {.depth_read = true},
        .remembers = false,
    };

    explicit LazyGrid(HierarchyRef hierarchy, LazyGridOptions options = {});

    /// The cells as the last frame left them, for the viewer.
    const OcclusionGrid& grid() const { return grid_; }

private:
    friend class CullerProbe; // of the tests
    /// A bounding volume in a list.
    struct Volume {
        ScreenBounds bounds;
        NodeId node;
        PlaneMask mask;
    };
    enum class Verdict : uint8_t { occluded, visible, needs_pixels };

    void cull_frame(CullFrame& frame) override;
    void reset_state() override {} // each frame starts with empty lists

    // --- Figures 2 and 3 ---
    bool is_occluded(CullFrame& frame, const Volume& volume);
    Verdict verdict_of_states(const Volume& volume);
    bool internal_cell_is_free_without_pixel_query(const Volume& volume);
    bool border_cell_is_free_without_pixel_query(const Volume& volume);
    bool internal_cell_is_free_with_pixel_query(CullFrame& frame, const Volume& volume);
    bool border_cell_is_free_with_pixel_query(CullFrame& frame, const Volume& volume);
    PixelQuestion question(const Volume& volume);
    float depth_to_beat(const Volume& volume);
    CellRange internal_cells(const Volume& volume) const;
    bool is_improbable(const OcclusionGrid::Cell& cell) const;
    void choose_faces(const Volume& volume);
    const ScreenBox& faces();
    bool faces_are_behind(const OcclusionGrid::Cell& cell, const PixelRect& part);
    CellPixels& pixels(const CullFrame& frame);

    // --- Figures 4 and 6 ---
    void initialize(CullFrame& frame);
    void insert_if_in_frustum(CullFrame& frame, NodeId node, PlaneMask mask);
    static std::span<const Volume> frontmost(std::span<const Volume> heap);
    bool draw_comes_before(std::span<const Volume> tests) const;
    void test(CullFrame& frame, const Volume& volume);
    void test_waiting(CullFrame& frame);
    void handle(CullFrame& frame, const Volume& volume, Verdict verdict);
    void draw(CullFrame& frame, const Volume& volume);
    bool has_objects(NodeId node) const ///< its items are direct children, which are drawn if it is
                                        ///< visible
    {
        return hierarchy().is_leaf(node) || hierarchy().node(node).own_items > 0;
    }

    // --- section 7 ---
    void update_busily(CullFrame& frame, const Volume& drawn);
    void update_states(CullFrame& frame, NodeId subject);

    struct Sources {
        ReadBackPixels read_back;
        TiledPixels tiles;
        QueriedPixels queries;
    };

    LazyGridOptions options_;
    Sources sources_;
    CellPixels* pixels_ = nullptr; ///< the source of this frame
    OcclusionGrid grid_;
    bool covered_hides_ = false;     ///< in this frame, covered pixels hide (the occlusion-buffer
                                     ///< variant)
    ScreenSpace screen_;             ///< with Bounds::faces
    const Aabb* tested_ = nullptr;   ///< with Bounds::faces: the tested box ...
    std::optional<ScreenBox> faces_; ///< ... and its faces, after the first call of faces()
    std::vector<Volume> test_list_;  ///< a heap by znear
    std::vector<Volume> draw_list_;  ///< a heap by zfar
    std::vector<Volume> waiting_;    ///< tests that need pixels
    std::vector<Verdict> verdicts_;
    std::vector<AskedCell> internal_; ///< internalPixelqueryList
    std::vector<AskedCell> border_;   ///< borderPixelqueryList
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
constexpr std::array<std::string_view, 3> option_names(CellPixels::Join)
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
    visit("variant", o.variant,
          "what hides a box: pixels that are nearer, or pixels that are covered");
    visit("update", o.update, "when a cell is looked at: if a test needs it, or after each draw");
    visit("traversal", o.traversal,
          "one list by nearest depth, or a list of tests and a list of draws");
    visit("source", o.source, "how pixels are looked at: by read-back, or by occlusion queries");
    visit("join", o.join,
          "what one read-back or query batch covers: a cell, rows of cells, or the target");
    visit("bounds", o.bounds, "what is compared with depth: the rectangle of a box, or its faces");
    visit("cell_size", o.cell_size, {1, 32768}, "side of a cell in pixels");
    visit("tests_at_once", o.tests_at_once, {1, 1'000'000},
          "tests that need pixels wait until there are this many; 1: none waits, as in the paper");
    visit("free_below_covered", o.free_below_covered, {},
          "a cell counts as free, unread, while drawn boxes cover less than this share of it; 0: "
          "off");
    visit("whole_cell_share", o.whole_cell_share, {0.0, 1.0},
          "a border cell is read as a whole if the box covers this share of it; 0: off");
    visit("internal_above_pixels", o.internal_above_pixels, {},
          "a box of at least this many pixels has only internal cells; 0: off");
    visit("tile", o.tile, {1, 1024},
          "read the farthest depth of tiles of this many pixels along a side; 1: pixels");
}

} // namespace occlude
