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
//             partly sky; here, as in Fig. 2, only a cell that nothing was drawn into is free
//             unasked. A cell that a query found free remembers at which depth. Boxes that the near
//             plane may touch are visible (rule R1). Both traversals test the frustum when a box
//             enters the list (Fig. 6), not when it leaves it (Fig. 4). Tests that need pixels are
//             made several at a time (tests_at_once; 1 is the paper). With bounds=faces the box of
//             a node with items is compared as a box, not as its rectangle at its nearest depth.
//             Sec. 6 adds up the areas of primitives; here the rectangles of drawn boxes. With the
//             occlusion buffer and items that are drawn out of turn (never_cull), boxes are
//             compared with depth: a covered pixel proves nothing then.
// Guarantees  exact, with every option: a box is hidden only if, in this frame, all pixels of its
//             screen rectangle were seen to be nearer than its nearest depth, or than the box at
//             that pixel. Keeps nothing between frames: camera cuts and moving objects cost nothing
//             extra.
// Cost        needs depth in the same frame: each change from drawing to looking waits for the
//             device to finish. A cell asked costs the reading of at most cell_size^2 pixels.
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
        busy, ///< all cells of a drawn box are looked at after its draw, for comparison
    };
    enum class Traversal : uint8_t {
        one_list,  ///< boxes by nearest depth; visible ones are drawn at once (Fig. 4)
        two_lists, ///< tests by nearest, draws by farthest depth, whichever is less (Fig. 6)
    };
    enum class Source : uint8_t {
        depth,   ///< pixels are read back: QueryDevice::read_depth, hardware or software buffer
        queries, ///< occlusion queries of rectangles in a cell; z_buffer is then always lazy
    };
    using Join = CellPixels::Join; ///< what one look at pixels takes
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
    /// A test that needs pixels waits until this many do. All of them then look at the same depth:
    /// that saves changes from drawing to looking, and finds fewer boxes hidden that lie just
    /// behind each other. 1: each test at once, as in the paper.
    uint32_t tests_at_once = 32;
    /// Section 6: a cell that must be asked counts as free, unasked, while the rectangles of the
    /// boxes drawn into it add up to less than this share of its area. 0: off.
    double free_below_covered = 0.0;
    /// Section 6: a border cell of which the box covers at least this share is asked as a whole, so
    /// that the answer can be kept. 0: off.
    double whole_cell_share = 0.0;
    /// Section 6: a box whose rectangle has at least this many pixels has only internal cells. 0:
    /// off.
    uint64_t internal_above_pixels = 0;
    /// With Source::depth: read the farthest depth of tiles of this many pixels along a side,
    /// reduced on the device, where it has such tiles. `join` is then `target`. 1: pixels.
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

    /// The cells as the last frame left them; the viewer draws them.
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
    bool has_objects(NodeId node) const ///< as direct children: they are drawn if it is visible
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
    CellPixels* pixels_ = nullptr; ///< the one of this frame
    OcclusionGrid grid_;
    bool covered_hides_ = false;     ///< in this frame: the occlusion-buffer variant
    ScreenSpace screen_;             ///< with Bounds::faces
    const Aabb* tested_ = nullptr;   ///< with Bounds::faces: the box that is tested, ...
    std::optional<ScreenBox> faces_; ///< ... and its faces, once they were needed
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
    visit("variant", o.variant, "what hides a box: nearer pixels, or covered pixels");
    visit("update", o.update, "when a cell is looked at: if a test needs it, or after each draw");
    visit("traversal", o.traversal, "one list by nearest depth, or one of tests and one of draws");
    visit("source", o.source, "how pixels are looked at: read back, or by occlusion queries");
    visit("join", o.join, "what one read-back or query batch takes");
    visit("bounds", o.bounds, "what is compared with depth: a box's rectangle, or its faces");
    visit("cell_size", o.cell_size, {1, 32768}, "side of a cell in pixels");
    visit("tests_at_once", o.tests_at_once, {1, 1'000'000},
          "how many tests that need pixels wait for each other; 1: none, as in the paper");
    visit("free_below_covered", o.free_below_covered, {},
          "a cell is free, unasked, while drawn boxes cover less than this share of it; 0: off");
    visit("whole_cell_share", o.whole_cell_share, {0.0, 1.0},
          "a border cell is asked as a whole if the box covers this share of it; 0: off");
    visit("internal_above_pixels", o.internal_above_pixels, {},
          "a box of at least this many pixels has only internal cells; 0: off");
    visit("tile", o.tile, {1, 1024},
          "read depth by the farthest of tiles of this many pixels along a side");
}

} // namespace occlude
