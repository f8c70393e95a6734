#include <occlude/cull/lazy_grid.h>

#include "support/culler_probe.h"
#include "support/trees.h"

#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

#include <algorithm>

namespace occlude {
namespace {

using test::look_ahead;
using test::row_tree;
using Variant = LazyGridOptions::Variant;
using Update = LazyGridOptions::Update;
using Traversal = LazyGridOptions::Traversal;
using Source = LazyGridOptions::Source;
using Join = LazyGridOptions::Join;

// The depth of distance d before look_ahead() is about 1 - 0.1 / d: 0.98899 at 9, the front of item
// 0; 0.9910 at 11, its back; 0.9948 at 19, the front of item 1.
constexpr float kBackOfItem0 = 0.9911f;

// Depth as if item 0 covered the pixels of `covered` once it is drawn. All other pixels are far.
DeviceScript item_0_covers(const ScriptedDevice& device, PixelRect covered)
{
    DeviceScript script;
    script.depth = [&device, covered](const PixelRect& rect, std::span<float> out) {
        const auto drawn = device.items_drawn_this_frame();
        const bool there = std::find(drawn.begin(), drawn.end(), ItemId{0u}) != drawn.end();
        for (int y = 0; y < rect.height; ++y) {
            for (int x = 0; x < rect.width; ++x) {
                const bool hit =
                    there && intersection({rect.x + x, rect.y + y, 1, 1}, covered).width == 1;
                out[static_cast<size_t>(y * rect.width + x)] = hit ? kBackOfItem0 : 1.0f;
            }
        }
        return true;
    };
    script.caps.read_depth = true;
    return script;
}

constexpr PixelRect kAll{0, 0, 64, 64};

struct Outcome {
    std::string text;
    FrameCounters counters;
};

Outcome run(const LazyGridOptions& options, PixelRect covered = kAll)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device;
    device.script() = item_0_covers(device, covered);
    LazyGrid culler{tree, options};
    const FrameReport report = culler.cull(look_ahead(), device);
    EXPECT_EQ(to_string(report.guarantee), "exact");
    return {device.frame_text(0), report.counters};
}

// Tree of row_tree(2): 0 (1 (3 4) 2 (5 6)). The rectangle of node 4 is pixels 30 to 33 in both
// directions, that of node 2 the same; both lie across the corner of the four cells.
constexpr const char* kFourBorderCells = "read_depth 30 30 2x2\nread_depth 32 30 2x2\n"
                                         "read_depth 30 32 2x2\nread_depth 32 32 2x2\n";

TEST(LazyGrid, NothingIsAskedBeforeSomethingIsDrawn)
{
    const Outcome paper = run({.tests_at_once = 1});
    EXPECT_EQ(paper.text.find("draw 0\n"), 0u) << paper.text;
}

TEST(LazyGrid, BorderCellsAreAskedForTheSharedPixelsOnlyAndEveryTime)
{
    const Outcome paper = run({.tests_at_once = 1});
    EXPECT_EQ(paper.text, std::string{"draw 0\n"} + kFourBorderCells + kFourBorderCells);
    EXPECT_EQ(paper.counters.cells_asked, 8u);
    EXPECT_EQ(paper.counters.depth_reads, 8u);
    EXPECT_EQ(paper.counters.pixels_read, 32u);
    EXPECT_EQ(paper.counters.nodes_visited, 5u);
}

TEST(LazyGrid, InternalCellsAreAskedOnceAndRemembered)
{
    // Cells of two pixels: node 4 consists of four internal cells, and so does node 2.
    const Outcome paper = run({.cell_size = 2, .tests_at_once = 1});
    EXPECT_EQ(paper.text, std::string{"draw 0\n"} + kFourBorderCells);
    EXPECT_EQ(paper.counters.cells_asked, 4u);
}

TEST(LazyGrid, TheFirstFreeCellEndsTheTest)
{
    // Only the two lower cells are covered, so node 4 is visible by the third.
    const Outcome paper = run({.cell_size = 2, .tests_at_once = 1}, {0, 0, 64, 32});
    EXPECT_EQ(paper.text.find("draw 0\nread_depth 30 30 2x2\nread_depth 32 30 2x2\n"
                              "read_depth 30 32 2x2\ndraw 1\n"),
              0u)
        << paper.text;
    EXPECT_EQ(paper.counters.items_drawn, 4u);
}

TEST(LazyGrid, AnUpToDateFreeCellIsTakenBeforeAnOutdatedOne)
{
    // Two items beside each other and one behind both. The cells of item 0 are outdated. Nothing
    // was drawn into the cells between the two, so that item 2 is visible without reading pixels.
    const std::vector<ItemBounds> items{{{{-4, -1, -11}, {-2, 1, -10}}, 1},
                                        {{{2, -1, -12}, {4, 1, -11}}, 1},
                                        {{{-4, -1, -21}, {4, 1, -20}}, 1}};
    const Hierarchy tree = build_bvh(items, {.leaf_triangles = 1});
    ScriptedDevice device;
    device.script() = item_0_covers(device, kAll);
    LazyGrid culler{tree, {.cell_size = 4, .tests_at_once = 1}};
    const FrameReport report = culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0), "draw 0 1 2\n");
    EXPECT_EQ(report.counters.cells_asked, 0u);
}

// The defect in the paper's Fig. 3: after a draw the cells hold zmax until they are next read. A
// border cell with zmax would make every box visible.
TEST(LazyGrid, ABorderCellThatWasDrawnIntoIsAskedAlthoughItsBoundIsStillTheFarthest)
{
    const Outcome paper = run({.tests_at_once = 1});
    EXPECT_EQ(paper.counters.items_drawn, 1u);
}

// Cells that are partly sky always hold zmax, though the box behind the horizon covers only their
// other part. When they are tested as a whole, they are known to be partly free.
TEST(LazyGrid, ABoxBehindTheHorizonOfAPartlyFreeCellIsHidden)
{
    for (const Variant variant : {Variant::z_buffer, Variant::occlusion_buffer}) {
        for (const Update update : {Update::lazy, Update::busy}) {
            const Outcome run_it =
                run({.variant = variant, .update = update, .tests_at_once = 1}, {0, 0, 64, 40});
            EXPECT_EQ(run_it.counters.items_drawn, 1u);
        }
    }
}

TEST(LazyGrid, BusyUpdateAsksAllCellsOfADrawnBox)
{
    const Outcome busy = run({.update = Update::busy, .tests_at_once = 1});
    EXPECT_EQ(busy.text, "draw 0\nread_depth 0 0 32x32\nread_depth 32 0 32x32\n"
                         "read_depth 0 32 32x32\nread_depth 32 32 32x32\n");
    EXPECT_EQ(busy.counters.cells_asked, 4u);
}

TEST(LazyGrid, JoinedReadBacksTakeRowsOfCellsAndCountBoth)
{
    const Outcome rows = run({.join = Join::rows, .cell_size = 16, .tests_at_once = 1});
    EXPECT_EQ(rows.text, "draw 0\nread_depth 0 16 64x32\n");
    EXPECT_EQ(rows.counters.cells_asked, 8u);
    EXPECT_EQ(rows.counters.depth_reads, 1u);
    const Outcome target = run({.join = Join::target, .cell_size = 16, .tests_at_once = 1});
    EXPECT_EQ(target.text, "draw 0\nread_depth 0 0 64x64\n");
    EXPECT_EQ(target.counters.cells_asked, 8u);
}

TEST(LazyGrid, DrawingMakesCopiedRowsOutdated)
{
    // Nothing hides anything: each drawn item makes the next test read again.
    const Outcome rows = run({.join = Join::rows, .tests_at_once = 1}, {});
    EXPECT_EQ(rows.text, "draw 0\nread_depth 0 0 64x64\ndraw 1\nflush\nread_depth 0 0 64x64\n"
                         "draw 2\nflush\nread_depth 0 0 64x64\ndraw 3\n");
}

TEST(LazyGrid, TestsThatWaitForEachOtherSeeTheSameDepth)
{
    // Nodes 4 and 2 wait and turn out to be visible. Then 5 and 6 wait, and item 1 is drawn
    // meanwhile.
    const Outcome together = run({.tests_at_once = 16}, {});
    EXPECT_EQ(together.text, "draw 0\nread_depth 30 30 2x2\nread_depth 30 30 2x2\n"
                             "draw 1\nflush\nread_depth 30 30 2x2\nread_depth 31 31 1x1\n"
                             "draw 2 3\n");
}

TEST(LazyGrid, QueriesTestRectanglesCellByCell)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device({.boxes = visible_subjects({NodeId{2u}, NodeId{5u}})});
    LazyGrid culler{tree, {.source = Source::queries, .tests_at_once = 1}};
    const FrameReport report = culler.cull(look_ahead(), device);
    const std::string hidden_4 = "query [4]\nflush\nwait 4 -> 0\n";
    EXPECT_EQ(device.frame_text(0),
              "draw 0\n" + hidden_4 + hidden_4 + hidden_4 + hidden_4 +
                  "query [2]\nflush\nwait 2 -> 1000\n"
                  "query [5]\nflush\nwait 5 -> 1000\ndraw 2\nflush\n" +
                  "query [6]\nflush\nwait 6 -> 0\n" + "query [6]\nflush\nwait 6 -> 0\n" +
                  "query [6]\nflush\nwait 6 -> 0\n" + "query [6]\nflush\nwait 6 -> 0\n");
    EXPECT_EQ(report.counters.cells_asked, 10u);
    EXPECT_EQ(report.counters.depth_reads, 0u);
}

TEST(LazyGrid, JoinedQueriesTestAllCellsInOneBatch)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device({.boxes = visible_subjects({})});
    LazyGrid culler{tree, {.source = Source::queries, .join = Join::rows, .tests_at_once = 1}};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0).find("draw 0\nquery [4] [4] [4] [4]\nflush\nwait 4 -> 0\n"), 0u);
    EXPECT_EQ(culler.drawn_items().size(), 1u);
}

// The defect in the paper's sec. 5: if no pixel of the box passes, the pixels are only known to be
// nearer than the box's surface there. A queried rectangle must lie at znear everywhere.
TEST(LazyGrid, QueriedRectanglesLieAtTheNearestDepthOfTheBoxAndCoverTheCell)
{
    const Hierarchy tree = row_tree(1);
    const View view = look_ahead();
    int rectangles = 0;
    ScriptedDevice device({.boxes = [&](std::span<const QueryBox> boxes) {
        for (const QueryBox& box : boxes) {
            const ScreenBounds bounds = project(view, tree.node(box.subject).box);
            EXPECT_EQ(box.box, (Aabb{glm::vec3{0.0f}, {1.0f, 1.0f, 0.0f}}));
            for (int k = 0; k < 4; ++k) {
                const glm::vec4 world = *box.world_from_box * glm::vec4{k & 1, k >> 1, 0, 1};
                const glm::vec4 clip = view.clip_from_world() * world;
                EXPECT_LE(0.5f * clip.z / clip.w + 0.5f, bounds.near_depth);
                EXPECT_GE(0.5f * clip.z / clip.w + 0.5f, bounds.near_depth - 1e-5f);
            }
            ++rectangles;
        }
        return uint64_t{0};
    }});
    LazyGrid culler{tree, {.source = Source::queries, .cell_size = 2}};
    culler.cull(view, device);
    EXPECT_EQ(rectangles, 4); // node 2 in its four internal cells
    for (const glm::ivec2 cell : {glm::ivec2{15, 15}, glm::ivec2{16, 16}}) {
        EXPECT_LT(CullerProbe::grid(culler).cell(cell).zfar,
                  project(view, tree.node(NodeId{2u}).box).near_depth);
        EXPECT_GT(CullerProbe::grid(culler).cell(cell).zfar, 0.9947f);
    }
}

TEST(LazyGrid, ALostAnswerIsVisibleAndTeachesNothing)
{
    const Hierarchy tree = row_tree(1);
    ScriptedDevice device(
        {.boxes = visible_subjects({}), .latency = [](uint64_t) { return Latency::lost(); }});
    LazyGrid culler{tree, {.source = Source::queries, .cell_size = 2}};
    const FrameReport report = culler.cull(look_ahead(), device);
    EXPECT_EQ(report.counters.lost_answers, 1u);
    EXPECT_EQ(culler.drawn_items().size(), 2u);
    EXPECT_EQ(CullerProbe::grid(culler).cell({15, 15}).known_free, OcclusionGrid::kUnknown);
}

TEST(LazyGrid, TwoListsTestABoxBeforeWhatIsNotWhollyInFrontOfItIsDrawn)
{
    // Item 0 reaches from before item 1 to behind it.
    const std::vector<ItemBounds> items{{{{-4, -1, -30}, {-2, 1, -9}}, 1},
                                        {{{-1, -1, -14}, {4, 1, -12}}, 1}};
    const Hierarchy tree = build_bvh(items, {.max_leaf_items = 1, .leaf_triangles = 1});
    const auto text = [&](const LazyGridOptions& options) {
        ScriptedDevice device;
        device.script() = item_0_covers(device, kAll);
        LazyGrid culler{tree, options};
        culler.cull(look_ahead(), device);
        return device.frame_text(0);
    };
    EXPECT_EQ(text({.traversal = Traversal::two_lists}), "draw 1 0\n");
    // By the covered pixels it would be hidden, although item 0 lies partly behind it.
    EXPECT_EQ(text({.variant = Variant::occlusion_buffer, .traversal = Traversal::one_list}),
              "draw 1 0\n");
    // By depth it may be drawn first. In this order its pixels are not nearer than item 1.
    EXPECT_EQ(text({.traversal = Traversal::one_list}).find("draw 0"), 0u);
}

TEST(LazyGrid, DefaultsAreThePapersCellsAndNoneOfTheExtensionsOfSection6)
{
    const Outcome off = run({.tests_at_once = 1,
                             .free_below_covered = 0.0,
                             .whole_cell_share = 0.0,
                             .internal_above_pixels = 0});
    const Outcome defaults = run({.tests_at_once = 1});
    const Outcome cells_of_32 = run({.cell_size = 32, .tests_at_once = 1});
    EXPECT_EQ(defaults.text, off.text);
    EXPECT_EQ(defaults.text, cells_of_32.text);
}

TEST(LazyGrid, AnImprobableCellIsFreeUnasked)
{
    // Item 0 covers at most 4 x 4 of the 32 x 32 pixels of a cell.
    const Outcome off = run({.free_below_covered = 0.015});
    EXPECT_EQ(off.counters.items_drawn, 1u);
    const Outcome on = run({.free_below_covered = 0.03});
    EXPECT_EQ(on.text, "draw 0 1 2 3\n");
    EXPECT_EQ(on.counters.cells_asked, 0u);
}

TEST(LazyGrid, AWholeBorderCellIsAskedOnceAndRemembered)
{
    const Outcome run_it = run({.tests_at_once = 1, .whole_cell_share = 0.003}); // 4 of 1024 pixels
    EXPECT_EQ(run_it.text, "draw 0\nread_depth 0 0 32x32\nread_depth 32 0 32x32\n"
                           "read_depth 0 32 32x32\nread_depth 32 32 32x32\n");
    EXPECT_EQ(run_it.counters.cells_asked, 4u);
    const Outcome off = run({.tests_at_once = 1, .whole_cell_share = 0.005});
    EXPECT_EQ(off.counters.pixels_read, 32u);
    // The part still counts where the whole cell is not hidden: the horizon.
    const Outcome horizon = run({.tests_at_once = 1, .whole_cell_share = 0.003}, {0, 0, 64, 40});
    EXPECT_EQ(horizon.counters.items_drawn, 1u);
}

// A box to the right of the eye and above it. The box does not cover the upper left and lower right
// corners of its rectangle. After item 0 is drawn, pixels there are free.
TEST(LazyGrid, WhereABoxIsNotInItsRectangleFreePixelsDoNotMakeItVisible)
{
    const std::vector<ItemBounds> items{{{{-2, -2, -6}, {6, 4, -5}}, 100},
                                        {{{5, 2, -20}, {10, 5, -10}}, 100}};
    const Hierarchy tree = build_bvh(items, {.leaf_triangles = 1});
    const PixelRect rect = project(look_ahead(), items[1].box).rect;
    const PixelRect corner{rect.x, rect.y + rect.height - 3, 3, 3};
    const auto drawn = [&](LazyGridOptions options, PixelRect free) {
        ScriptedDevice device;
        device.script().caps.read_depth = true;
        device.script().depth = [&](const PixelRect& asked, std::span<float> out) {
            for (int y = 0; y < asked.height; ++y) {
                for (int x = 0; x < asked.width; ++x) {
                    const PixelRect pixel{asked.x + x, asked.y + y, 1, 1};
                    out[static_cast<size_t>(y * asked.width + x)] =
                        intersection(pixel, free).width > 0 ? 1.0f : 0.5f;
                }
            }
            return true;
        };
        LazyGrid culler{tree, options};
        return culler.cull(look_ahead(), device).counters.items_drawn;
    };
    for (const Join join : {Join::cell, Join::rows}) {
        for (const uint32_t cell_size : {4u, 32u}) {
            EXPECT_EQ(drawn({.join = join, .cell_size = cell_size}, corner), 2u);
            const LazyGridOptions faces{
                .join = join, .bounds = LazyGridOptions::Bounds::faces, .cell_size = cell_size};
            EXPECT_EQ(drawn(faces, corner), 1u);
            const PixelRect middle{rect.x + rect.width / 2, rect.y + rect.height / 2, 1, 1};
            EXPECT_EQ(drawn(faces, middle), 2u);
        }
    }
}

TEST(LazyGrid, LargeBoxesHaveOnlyInternalCells)
{
    const Outcome run_it = run({.tests_at_once = 1, .internal_above_pixels = 16});
    EXPECT_EQ(run_it.counters.cells_asked, 4u);
    EXPECT_EQ(run_it.counters.pixels_read, 4096u);
    // Those behind the horizon are visible then: fewer are hidden, and the image is the same.
    const Outcome horizon = run({.tests_at_once = 1, .internal_above_pixels = 16}, {0, 0, 64, 40});
    EXPECT_GT(horizon.counters.items_drawn, 1u);
}

TEST(LazyGrid, WithoutDepthEverythingIsDrawn)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device; // caps.read_depth is false
    for (const Join join : {Join::cell, Join::rows, Join::target}) {
        LazyGrid culler{tree, {.join = join}};
        const FrameReport report = culler.cull(look_ahead(), device);
        EXPECT_EQ(culler.drawn_items().size(), 4u);
        EXPECT_EQ(report.counters.depth_reads, 0u);
    }
}

TEST(LazyGrid, BoxesThatTheNearPlaneMayTouchAreDrawnUntested)
{
    const Hierarchy tree = row_tree(1);
    ScriptedDevice device;
    device.script() = item_0_covers(device, kAll);
    LazyGrid culler{tree};
    culler.cull(test::look({0.0f, 0.0f, -10.0f}, {0.0f, 0.0f, -20.0f}), device);
    EXPECT_EQ(culler.decisions().by_item(tree),
              (std::vector<Decision>{Decision::drawn_near, Decision::drawn_revealed}));
}

} // namespace
} // namespace occlude
