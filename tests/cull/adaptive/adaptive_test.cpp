#include <occlude/cull/adaptive.h>

#include "support/culler_probe.h"
#include "support/trees.h"

#include <occlude/cull/frustum_culler.h>
#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace occlude {
namespace {

using test::look_ahead;
using test::row_tree;

// A device whose hints say that a triangle costs 1 us, a query `us_per_test`, a round nothing.
DeviceScript priced(float us_per_test, const std::vector<uint32_t>& visible)
{
    std::vector<NodeId> nodes;
    for (const uint32_t node : visible) {
        nodes.emplace_back(node);
    }
    DeviceScript script;
    script.boxes = visible_subjects(nodes);
    script.caps.us_per_triangle = 1.0f;
    script.caps.us_per_item = 0.0f;
    script.caps.methods = {{TestMethod::queries, 0.0f, us_per_test, 0.0f}};
    return script;
}

// Tree of row_tree(2): 0 (1 (3 4) 2 (5 6)), 100 triangles each; only item 0 is seen.
TEST(Adaptive, TestsInRoundsAndStartsFromTheCutOfTheLastFrame)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device(priced(1.0f, {0, 1, 3}));
    Adaptive culler{tree};
    culler.cull(look_ahead(), device);
    // The first frame draws everything and then tests it, in rounds.
    EXPECT_EQ(device.frame_text(0), "draw 0 1 2 3\n"
                                    "query queries [0]\nflush\nwait 0 -> 1000\n"
                                    "query queries [1] [2]\nflush\nwait 1 -> 1000\nwait 2 -> 0\n"
                                    "query queries [3] [4]\nflush\nwait 3 -> 1000\nwait 4 -> 0\n");
    culler.cull(look_ahead(), device);
    // 3 is drawn at once; 4 and 2 were hidden once and may share a query.
    EXPECT_EQ(device.frame_text(1), "draw 0\nflush\nquery queries [4 2]\nflush\nwait 4 2 -> 0\n");
    EXPECT_EQ(CullerProbe::cut(culler).entries().size(), 3u);
}

TEST(Adaptive, ASmallGroupThatShowsIsAskedOneByOne)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device(priced(1.0f, {0, 1, 3}));
    Adaptive culler{tree};
    culler.cull(look_ahead(), device);
    device.script().boxes = visible_subjects({NodeId{4u}});
    const FrameReport report = culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(1), "draw 0\nflush\nquery queries [4 2]\nflush\nwait 4 2 -> 1000\n"
                                    "query queries [4] [2]\nflush\nwait 4 -> 1000\nwait 2 -> 0\n"
                                    "draw 1\n");
    EXPECT_EQ(report.counters.multiqueries_failed, 1u);
}

TEST(Adaptive, WhereTestsCostMoreThanDrawingItIsFrustumCulling)
{
    const Hierarchy tree = row_tree(4);
    ScriptedDevice device(priced(1e6f, {}));
    ScriptedDevice frustum_device(priced(1e6f, {}));
    Adaptive culler{tree};
    FrustumCuller frustum{tree};
    FrameReport report;
    for (int frame = 0; frame < 5; ++frame) {
        report = culler.cull(look_ahead(), device);
        frustum.cull(look_ahead(), frustum_device);
        EXPECT_EQ(report.counters.queries, 0u);
        if (frame > 0) {
            EXPECT_EQ(device.frame_text(static_cast<uint64_t>(frame)),
                      frustum_device.frame_text(static_cast<uint64_t>(frame)));
        }
    }
    EXPECT_EQ(report.plan.kind, FramePlan::Kind::draw_all);
    EXPECT_EQ(to_string(report.plan).substr(0, 8), "draw_all");
}

// Without depth, the first frames are probes. Later probes are rare.
TEST(Adaptive, WhereNothingIsHiddenTheDeviceIsNotAskedInEveryFrame)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device(priced(1.0f, {0, 1, 2, 3, 4, 5, 6}));
    Adaptive culler{tree};
    int asked = 0;
    for (int frame = 0; frame < 100; ++frame) {
        const FrameReport report = culler.cull(look_ahead(), device);
        EXPECT_EQ(report.plan.kind, FramePlan::Kind::draw_all);
        EXPECT_EQ(report.counters.items_drawn, 4u);
        asked += report.counters.queries > 0 ? 1 : 0;
    }
    EXPECT_GT(asked, 0);
    EXPECT_LE(asked, 12 + 100 / 16);
}

TEST(Adaptive, WithoutAnyTestItDrawsAllAndSaysWhy)
{
    const Hierarchy tree = row_tree(2);
    DeviceScript script = priced(1.0f, {});
    script.caps.same_frame_results = false;
    ScriptedDevice device(std::move(script));
    Adaptive culler{tree};
    const FrameReport report = culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0), "draw 0 1 2 3\n");
    EXPECT_EQ(report.plan.reason, FramePlan::Reason::no_tests);
}

// Depth that lies between item 0 and item 1 of the row everywhere.
TEST(Adaptive, ReadsDepthOnceAFrameAndTestsWhatWasNotVisibleAgainstIt)
{
    const Hierarchy tree = row_tree(2);
    DeviceScript script = priced(1e6f, {});
    script.caps.read_depth = true;
    script.caps.us_per_triangle = 100.0f; // against 400 us for the read-back
    script.depth = [](const PixelRect&, std::span<float> out) {
        std::fill(out.begin(), out.end(), 0.992f);
        return true;
    };
    ScriptedDevice device(std::move(script));
    Adaptive culler{tree};
    FrameReport report;
    for (int frame = 0; frame < 3; ++frame) {
        report = culler.cull(look_ahead(), device);
    }
    EXPECT_EQ(device.frame_text(2), "draw 0\nflush\nread_depth 0 0 64x64\n");
    EXPECT_EQ(report.plan.kind, FramePlan::Kind::pyramid);
    EXPECT_EQ(report.plan.reason, FramePlan::Reason::saves);
    EXPECT_GT(report.plan.saved_us, 100.0f * 250.0f); // of 300 triangles
    EXPECT_LT(report.plan.spent_us, 1000.0f);
}

// Without a clock nothing depends on time.
TEST(Adaptive, RepeatsItselfWithoutAClock)
{
    const Hierarchy tree = test::random_bvh(500, 3);
    std::string traces[2];
    for (std::string& trace : traces) {
        DeviceScript script = priced(3.0f, {});
        script.boxes = [](std::span<const QueryBox> boxes) {
            return static_cast<uint64_t>(boxes[0].subject.value % 3);
        };
        ScriptedDevice device(std::move(script));
        Adaptive culler{tree};
        for (int frame = 0; frame < 6; ++frame) {
            culler.cull(test::look({0.0f, 0.0f, 40.0f}, {static_cast<float>(frame), 0.0f, 0.0f}),
                        device);
        }
        trace = device.trace_text();
    }
    EXPECT_EQ(traces[0], traces[1]);
    EXPECT_NE(traces[0].find("query queries"), std::string::npos);
}

TEST(CostModel, LearnsTheSlopeOfDrawingNotThePixels)
{
    CostModel costs;
    DeviceCaps caps;
    caps.us_per_triangle = 0.15f;
    caps.us_per_item = 0.0f;
    costs.take_hints(caps);
    EXPECT_DOUBLE_EQ(costs.us_per_unit(), double{0.15f});
    for (int i = 0; i < 5; ++i) {
        costs.record_drawing(1000.0, 5000.0 + 0.5 * 1000.0);
        costs.record_drawing(64000.0, 5000.0 + 0.5 * 64000.0);
    }
    EXPECT_NEAR(costs.us_per_unit(), 0.5, 1e-9);
    costs.record_drawing(64000.0, 1e6); // one frame is disturbed
    EXPECT_NEAR(costs.us_per_unit(), 0.5, 1e-9);
}

TEST(CostModel, LearnsRoundsAndTests)
{
    CostModel costs;
    DeviceCaps caps;
    caps.methods = {{TestMethod::queries, 60.0f, 18.0f, 4.0f}};
    costs.take_hints(caps);
    EXPECT_FALSE(costs.has(TestMethod::raster));
    EXPECT_NEAR(costs.round(TestMethod::queries).of(10.0), 60.0 + 220.0, 1e-3);
    EXPECT_EQ(costs.rounds_measured(TestMethod::queries), 0u);
    EXPECT_EQ(costs.least_known(TestMethod::raster).tests, 0u);
    EXPECT_EQ(costs.least_known(TestMethod::queries).boxes, 1u);
    costs.record_round(TestMethod::queries, 1, 1, 100.0);
    EXPECT_GT(costs.least_known(TestMethod::queries).tests, 1u);
    costs.record_round(TestMethod::queries, 17, 17, 100.0 + 16 * 5.0);
    EXPECT_NEAR(costs.round(TestMethod::queries).of(10.0), 100.0 + 50.0, 1e-9);
    EXPECT_EQ(costs.least_known(TestMethod::queries).tests, 1u);
    EXPECT_GT(costs.least_known(TestMethod::queries).boxes, 1u);
    costs.record_round(TestMethod::queries, 1, 11, 100.0 + 10 * 2.0);
    EXPECT_NEAR(costs.round(TestMethod::queries).of(10.0, 20.0), 100.0 + 50.0 + 20.0, 1e-9);
    EXPECT_EQ(costs.least_known(TestMethod::queries).boxes, 1u);
    EXPECT_EQ(costs.rounds_measured(TestMethod::queries), 1u);
}

// Costs of reads of 1280x720: pixels take `pixels_us`, tiles of 8 `tiles_us`, and tiles of 16 half
// of that.
DeviceCaps caps_with_tiles(float pixels_us, float tiles_us)
{
    DeviceCaps caps;
    caps.read_depth = true;
    caps.depth_reads = {{.tile_px = 1, .us_per_read = pixels_us},
                        {.tile_px = 8, .us_per_read = tiles_us},
                        {.tile_px = 16, .us_per_read = 0.5f * tiles_us}};
    return caps;
}

TEST(CostModel, ReadsTheTilesThatCostLeastWithWhatTheyFailToHide)
{
    CostModel costs;
    costs.take_hints(caps_with_tiles(800.0f, 1000.0f), {1280, 720});
    const double pixels_us = costs.round(TestMethod::pyramid).us_per_round;
    costs.choose_tile(0.0);
    EXPECT_EQ(costs.tile_px(), 16);
    EXPECT_DOUBLE_EQ(costs.round(TestMethod::pyramid).us_per_round, 0.625 * pixels_us);
    costs.choose_tile(1e6);
    EXPECT_EQ(costs.tile_px(), 1) << "where drawing takes a second, what tiles do not hide decides";
    EXPECT_DOUBLE_EQ(costs.round(TestMethod::pyramid).us_per_round, pixels_us);

    DeviceCaps without = caps_with_tiles(800.0f, 100.0f);
    without.depth_reads.clear();
    costs.take_hints(without, {1280, 720});
    costs.choose_tile(0.0);
    EXPECT_EQ(costs.tile_px(), 1) << "the device has no tiles";
}

TEST(CostModel, MeasuresTilesThatMayCostLessAndThenGoesByThat)
{
    CostModel costs;
    costs.take_hints(caps_with_tiles(800.0f, 1200.0f), {1280, 720});
    for (const int tile_px : {1, 8, 16}) {
        for (int i = 0; i < 3; ++i) {
            EXPECT_EQ(costs.unmeasured_tile_px(), tile_px);
            costs.record_read(tile_px, tile_px == 8 ? 50.0 : 300.0);
            costs.choose_tile(0.0);
        }
        EXPECT_EQ(costs.tile_px(), tile_px == 1 ? 1 : 8);
    }
    EXPECT_EQ(costs.unmeasured_tile_px(), 0);
    EXPECT_DOUBLE_EQ(costs.round(TestMethod::pyramid).us_per_round, 50.0);
    costs.forget_measurements();
    EXPECT_EQ(costs.tile_px(), 1);

    costs.take_hints(caps_with_tiles(100.0f, 10000.0f), {1280, 720});
    for (int i = 0; i < 3; ++i) {
        costs.record_read(1, 100.0);
    }
    EXPECT_EQ(costs.unmeasured_tile_px(), 0) << "tiles are hopeless by their hints";
}

TEST(Adaptive, ReadsTilesWhereTheyCostLess)
{
    const Hierarchy tree = row_tree(2);
    DeviceScript script;
    script.caps = caps_with_tiles(800.0f, 80.0f);
    script.caps.us_per_triangle = 100.0f;
    ScriptedDevice device(script);
    Adaptive culler{tree, {.method = AdaptiveOptions::Method::pyramid, .measure = false}};
    culler.cull(look_ahead(), device);
    EXPECT_NE(device.trace_text().find("read_depth_tiles 16"), std::string::npos)
        << device.trace_text();
    EXPECT_EQ(device.trace_text().find("read_depth "), std::string::npos);
}

TEST(ScreenCoverage, FillsTheScreenFrontToBack)
{
    ScreenCoverage coverage;
    coverage.start_frame({100, 100});
    const ScreenBounds half{{0, 0, 100, 100}, 0.5f, 0.6f, true};
    const double share = coverage.share(half);
    EXPECT_DOUBLE_EQ(share, 0.5);
    EXPECT_EQ(coverage.chance_covered(0.01), 0.0);
    coverage.add_drawn(share);
    coverage.add_drawn(share); // 0.75 of the screen
    EXPECT_NEAR(coverage.chance_covered(0.01), (0.8660254 - 0.1) * (0.8660254 - 0.1), 1e-6);
    EXPECT_EQ(coverage.chance_covered(0.8), 0.0);
}

} // namespace
} // namespace occlude
