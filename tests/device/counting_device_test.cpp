#include "device_test_helpers.h"

#include <occlude/device/counting_device.h>
#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

namespace occlude {
namespace {

using test::ask;
using test::ask_batch;
using test::draw;

TEST(CountingDevice, CountsAHandWorkedFrame)
{
    ScriptedDevice scripted({.boxes = visible_subjects({NodeId{9u}}),
                             .caps = {.name = "scripted", .draw_and_query = true, .methods = {}}});
    const std::vector<uint32_t> triangles{10, 20, 30, 40};
    CountingDevice device(scripted, {.triangles_by_item = triangles});
    device.begin_frame(test::camera());
    draw(device, {0, 1});
    const auto tickets = ask_batch(device, {{7}, {8, 9}, {5, 6}}); // change 1
    ask(device, {4});                                              // none
    device.flush();
    device.poll(tickets[0]);
    device.wait(tickets[1]); // a multiquery that failed
    device.wait(tickets[2]); // one that succeeded
    draw(device, {2});       // change 2
    device.wait(device.draw_and_query(test::items({3}), DrawPass::shade)); // none
    ask(device, {4});                                                      // change 3
    device.wait(tickets[2]);                                               // lost: spent
    device.end_frame();

    FrameCounters expected;
    expected.queries = 6;
    expected.boxes = 7;
    expected.multiqueries = 2;
    expected.multiqueries_failed = 1;
    expected.batches = 3;
    expected.state_changes = 3;
    expected.draw_calls = 3;
    expected.items_drawn = 4;
    expected.triangles_drawn = 100;
    expected.waits = 4;
    expected.lost_answers = 1;
    EXPECT_EQ(device.frame(), expected);
}

TEST(CountingDevice, EveryFrameStartsInTheDrawingState)
{
    ScriptedDevice scripted;
    CountingDevice device(scripted);
    for (int frame = 0; frame < 2; ++frame) {
        device.begin_frame(test::camera());
        ask(device, {1});
        device.end_frame();
        EXPECT_EQ(device.frame().state_changes, 1u);
    }
    EXPECT_EQ(device.total().state_changes, 2u);
    EXPECT_EQ(device.total().queries, 2u);
}

TEST(CountingDevice, ShadingAfterADepthPassIsACallButDrawsNoNewItems)
{
    ScriptedDevice scripted;
    CountingDevice device(scripted);
    device.begin_frame(test::camera());
    draw(device, {0, 1}, DrawPass::depth_only);
    draw(device, {0, 1}, DrawPass::shade_equal);
    EXPECT_EQ(device.frame().draw_calls, 2u);
    EXPECT_EQ(device.frame().items_drawn, 2u);
}

TEST(CountingDevice, CountsOnlyDepthThatCouldBeRead)
{
    ScriptedDevice scripted;
    CountingDevice device(scripted);
    device.begin_frame(test::camera());
    std::array<float, 6> depth{};
    EXPECT_FALSE(device.read_depth({0, 0, 3, 2}, depth));
    EXPECT_EQ(device.frame().depth_reads, 0u);
    scripted.script().caps.read_depth = true;
    EXPECT_TRUE(device.read_depth({0, 0, 3, 2}, depth));
    EXPECT_FALSE(device.read_depth_tiles(32, depth)) << "counts nothing";
    EXPECT_EQ(device.frame().depth_reads, 1u);
    EXPECT_EQ(device.frame().pixels_read, 6u);
}

TEST(CountingDevice, AMultiqueryFailsOnlyAboveTheThreshold)
{
    ScriptedDevice scripted({.boxes = [](std::span<const QueryBox>) { return uint64_t{20}; }});
    CountingDevice device(scripted, {.visible_above = 20});
    device.begin_frame(test::camera());
    device.wait(ask(device, {1, 2}));
    EXPECT_EQ(device.frame().multiqueries_failed, 0u);
    scripted.script().boxes = [](std::span<const QueryBox>) { return uint64_t{21}; };
    device.wait(ask(device, {1, 2}));
    EXPECT_EQ(device.frame().multiqueries_failed, 1u);
}

TEST(CountingDevice, BoxesOfOneSubjectAreNoMultiquery)
{
    ScriptedDevice scripted;
    CountingDevice device(scripted);
    device.begin_frame(test::camera());
    ask(device, {1, 1, 1});
    EXPECT_EQ(device.frame().multiqueries, 0u);
    EXPECT_EQ(device.frame().boxes, 3u);
}

} // namespace
} // namespace occlude
