// Tickets whose answers nobody needs: the culler that gives up a test spends its ticket.
#include <occlude/cull/adaptive.h>
#include <occlude/cull/next_frame.h>

#include "support/trees.h"

#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

namespace occlude {
namespace {

using Method = AdaptiveOptions::Method;

// A device that answers late: tests of visible nodes stay unspent over frames.
DeviceScript late_script(uint32_t frames)
{
    DeviceScript script;
    script.caps.us_per_triangle = 1.0f;
    script.caps.methods = {{TestMethod::queries, 0.0f, 0.01f, 0.0f},
                           {TestMethod::raster, 0.0f, 0.01f, 0.0f, false}};
    script.caps.max_outstanding = 200;
    script.latency = [frames](uint64_t) { return Latency::after_frames(frames); };
    script.boxes = [](std::span<const QueryBox> asked) {
        return uint64_t{asked[0].subject.value % 4 == 3 ? 0u : 100u};
    };
    return script;
}

TEST(AdaptiveTickets, AreSpentAfterAReset)
{
    const Hierarchy tree = test::random_bvh(500, 3);
    ScriptedDevice device(late_script(2));
    Adaptive culler{tree, {.method = Method::queries}};
    for (int round = 0; round < 20; ++round) {
        for (int i = 0; i < 4; ++i) {
            culler.cull(test::look({0, 0, 110}, {0.1f * static_cast<float>(i), 0, 0}), device);
        }
        ASSERT_GT(device.outstanding(), 0u) << "the case proves nothing";
        ASSERT_LE(device.outstanding(), 200u);
        culler.reset();
    }
    // With nothing in view, all tickets are spent as soon as they are answered.
    for (int i = 0; i < 4; ++i) {
        culler.cull(test::look({0, 0, 110}, {0, 0, 200}), device);
    }
    EXPECT_EQ(device.outstanding(), 0u);
}

TEST(AdaptiveTickets, AreSpentWhenTheTreeIsReplaced)
{
    Hierarchy tree = test::random_bvh(500, 3);
    ScriptedDevice device(late_script(2));
    Adaptive culler{tree, {.method = Method::queries}};
    for (int round = 0; round < 20; ++round) {
        for (int i = 0; i < 4; ++i) {
            culler.cull(test::look({0, 0, 110}, {0.1f * static_cast<float>(i), 0, 0}), device);
        }
        tree = test::random_bvh(500, 4 + static_cast<uint64_t>(round));
    }
    for (int i = 0; i < 4; ++i) {
        culler.cull(test::look({0, 0, 110}, {0, 0, 200}), device);
    }
    EXPECT_EQ(device.outstanding(), 0u);
    tree = Hierarchy{}; // an empty batch too
    culler.cull(test::look_ahead(), device);
    EXPECT_EQ(device.outstanding(), 0u);
}

TEST(AdaptiveTickets, AreSpentWhenItStopsCulling)
{
    const Hierarchy tree = test::random_bvh(500, 3);
    ScriptedDevice device(late_script(3));
    Adaptive culler{tree};
    for (int i = 0; i < 6; ++i) {
        culler.cull(test::look({0, 0, 110}, {0.1f * static_cast<float>(i), 0, 0}), device);
    }
    ASSERT_GT(device.outstanding(), 0u);
    device.script().boxes = {}; // everything is visible from now on
    FrameReport report;
    for (int i = 0; i < 100; ++i) {
        report = culler.cull(test::look({0, 0, 110}, {0, 0, 0}), device);
    }
    EXPECT_EQ(report.plan.kind, FramePlan::Kind::draw_all);
    EXPECT_EQ(device.outstanding(), 0u);
}

// One culler is reset again and again while its tests are under way. The other cullers on the
// device get their answers all the same.
TEST(AdaptiveTickets, OtherCullersKeepTheirs)
{
    const Hierarchy tree = test::random_bvh(500, 3);
    ScriptedDevice device(late_script(1));
    Adaptive restless{tree, {.method = Method::queries}};
    Adaptive other{tree, {.method = Method::raster}};
    const View view = test::look({0, 0, 110}, {0, 0, 0});
    uint64_t lost = 0;
    for (int i = 0; i < 60; ++i) {
        restless.cull(view, device);
        if (i % 3 == 2) {
            restless.reset();
        }
        if (i >= 40) { // a leak would have used up 200 tickets
            lost += other.cull(view, device).counters.lost_answers;
        }
    }
    EXPECT_EQ(lost, 0u);
}

TEST(AdaptiveTickets, AreSpentByWhoeverReleasesTheCuller)
{
    const Hierarchy tree = test::random_bvh(500, 3);
    ScriptedDevice device(late_script(5));
    for (int level = 0; level < 10; ++level) {
        Adaptive culler{tree, {.method = Method::queries}};
        for (int i = 0; i < 4; ++i) {
            culler.cull(test::look({0, 0, 110}, {0.1f * static_cast<float>(i), 0, 0}), device);
        }
        ASSERT_GT(device.outstanding(), 0u);
        culler.release(device);
        ASSERT_EQ(device.outstanding(), 0u);
    }
}

TEST(AdaptiveTickets, NextFrameSpendsThoseItGivesUpToo)
{
    Hierarchy tree = test::random_bvh(100, 3);
    ScriptedDevice device(late_script(2));
    NextFrame culler{tree, {.read = NextFrameOptions::Read::poll}};
    for (int round = 0; round < 10; ++round) {
        culler.cull(test::look({0, 0, 110}, {0, 0, 0}), device);
        ASSERT_GT(device.outstanding(), 0u);
        culler.reset();
    }
    tree = Hierarchy{};
    for (int i = 0; i < 4; ++i) {
        culler.cull(test::look_ahead(), device);
    }
    EXPECT_EQ(device.outstanding(), 0u);
}

} // namespace
} // namespace occlude
