#include <occlude/cull/next_frame.h>

#include "support/trees.h"
#include "support/visibility_script.h"

#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/device/counting_device.h>
#include <occlude/device/scripted_device.h>
#include <occlude/device/validating_device.h>

#include <gtest/gtest.h>

namespace occlude {
namespace {

using test::look;
using test::look_ahead;
using test::row_tree;
using Hysteresis = NextFrameOptions::Hysteresis;

// Tree of row_tree(1): objects 1 (item 0) and 2 (item 1). Draws count `seen` samples per item.
DeviceScript script(std::vector<NodeId> visible_boxes, uint64_t seen = 50)
{
    DeviceScript script{.boxes = visible_subjects(std::move(visible_boxes)),
                        .items = [seen](auto items) { return items.size() * seen; }};
    script.caps.draw_and_query = true;
    return script;
}

View look_away()
{
    return look({0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f});
}

TEST(NextFrame, TestsVisibleObjectsByDrawingThemAndHiddenOnesByTheirBoxes)
{
    const Hierarchy tree = row_tree(1);
    DeviceScript far_hidden = script({});
    far_hidden.items = [](std::span<const ItemId> items) {
        return items[0] == ItemId{0u} ? uint64_t{70} : uint64_t{0};
    };
    ScriptedDevice device(far_hidden);
    NextFrame culler{tree, {.visible_interval = 1}};
    const FrameReport first = culler.cull(look_ahead(), device);
    EXPECT_EQ(to_string(first.guarantee), "latent(1)");
    EXPECT_EQ(culler.visible_samples(NodeId{1u}), Answer::kUnknownSamples);
    // Frame 0: everything is taken as visible.
    EXPECT_EQ(device.frame_text(0), "draw_and_query 0\ndraw_and_query 1\n");
    culler.cull(look_ahead(), device);
    // Frame 1: reads the results of frame 0, then decides by them.
    EXPECT_EQ(device.frame_text(1), "wait item 0 -> 70\nwait item 1 -> 0\n"
                                    "draw_and_query 0\nquery [2]\nflush\n");
    EXPECT_EQ(culler.visible_samples(NodeId{1u}), 70u);
    EXPECT_EQ(culler.visible_samples(NodeId{2u}), 0u);
    // Frame 2: the box is still hidden, and is tested every frame.
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(2), "wait item 0 -> 70\nwait 2 -> 0\n"
                                    "draw_and_query 0\nquery [2]\nflush\n");
}

TEST(NextFrame, AnObjectThatTurnsVisibleAppearsOneFrameLate)
{
    const Hierarchy tree = row_tree(1);
    ScriptedDevice device(script({}, 0));
    NextFrame culler{tree, {.visible_interval = 1}};
    culler.cull(look_ahead(), device);
    culler.cull(look_ahead(), device);
    EXPECT_TRUE(culler.drawn_items().empty());
    device.script() = script({NodeId{2u}}, 50);
    culler.cull(look_ahead(), device); // it is visible now, and not drawn yet
    EXPECT_TRUE(culler.drawn_items().empty());
    culler.cull(look_ahead(), device);
    ASSERT_EQ(culler.drawn_items().size(), 1u);
    EXPECT_EQ(culler.drawn_items()[0], ItemId{1u});
}

TEST(NextFrame, VisibleObjectsAreTestedEveryKFramesInTurns)
{
    const Hierarchy tree = row_tree(1);
    ScriptedDevice device(script({}));
    NextFrame culler{tree, {.visible_interval = 3}};
    std::vector<uint64_t> queries;
    for (int frame = 0; frame < 6; ++frame) {
        queries.push_back(culler.cull(look_ahead(), device).counters.queries);
    }
    // Stamps 1 to 6; node n is due when stamp + n is a multiple of 3.
    EXPECT_EQ(queries, (std::vector<uint64_t>{1, 1, 0, 1, 1, 0}));
}

// Expects the frames in which item 1 is drawn while it is hidden and its box is visible.
std::string drawn_frames(NextFrameOptions options, int frames)
{
    const Hierarchy tree = row_tree(1);
    ScriptedDevice device(script({NodeId{2u}}, 0));
    NextFrame culler{tree, options};
    std::string text;
    for (int frame = 0; frame < frames; ++frame) {
        culler.cull(look_ahead(), device);
        text += culler.drawn_items().empty() ? '.' : culler.drawn_items().size() == 1 ? 'x' : 'X';
    }
    return text;
}

TEST(NextFrame, WithoutHysteresisAHiddenObjectInAVisibleBoxFlickers)
{
    EXPECT_EQ(drawn_frames({.visible_interval = 1, .hysteresis = Hysteresis::off}, 8), "X.x.x.x.");
}

TEST(NextFrame, HysteresisDrawKeepsItDrawn)
{
    EXPECT_EQ(drawn_frames({.visible_interval = 1}, 8), "X.xxxxxx");
    EXPECT_EQ(drawn_frames({.visible_interval = 5}, 12).substr(8), "xxxx");
}

TEST(NextFrame, HysteresisHideDisbelievesTheBoxForHFrames)
{
    const NextFrameOptions options{
        .visible_interval = 1, .hysteresis = Hysteresis::hide, .hold_frames = 4};
    EXPECT_EQ(drawn_frames(options, 14), "X.x....x....x.");
    const Hierarchy tree = row_tree(1);
    ScriptedDevice device;
    EXPECT_EQ(to_string(NextFrame(tree, options).cull(look_ahead(), device).guarantee),
              "latent(5)");
}

TEST(NextFrame, HysteresisDrawEndsWhenTheBoxIsHidden)
{
    const Hierarchy tree = row_tree(1);
    ScriptedDevice device(script({NodeId{2u}}, 0));
    NextFrame culler{tree, {.visible_interval = 1}};
    for (int frame = 0; frame < 6; ++frame) {
        culler.cull(look_ahead(), device);
    }
    ASSERT_EQ(culler.drawn_items().size(), 1u);
    device.script() = script({}, 0);
    culler.cull(look_ahead(), device);
    culler.cull(look_ahead(), device);
    EXPECT_TRUE(culler.drawn_items().empty());
}

TEST(NextFrame, WhatComesBackIntoTheFrustumIsTakenAsVisibleForAFrame)
{
    const Hierarchy tree = row_tree(1);
    ScriptedDevice device(script({}, 0));
    NextFrame culler{tree, {.visible_interval = 1}};
    culler.cull(look_ahead(), device);
    culler.cull(look_ahead(), device);
    EXPECT_TRUE(culler.drawn_items().empty());
    culler.cull(look_away(), device);
    culler.cull(look_ahead(), device);
    EXPECT_EQ(culler.drawn_items().size(), 2u);
    culler.cull(look_ahead(), device);
    EXPECT_TRUE(culler.drawn_items().empty());
}

TEST(NextFrame, PolledResultsLeaveObjectsAsTheyWereUntilTheyAreThere)
{
    const Hierarchy tree = row_tree(1);
    DeviceScript slow = script({}, 0);
    slow.latency = [](uint64_t) { return Latency::never(); };
    ScriptedDevice device(slow);
    NextFrame culler{
        tree, {.read = NextFrameOptions::Read::poll, .max_latency = 3, .visible_interval = 1}};
    std::vector<size_t> drawn;
    std::vector<uint64_t> waits;
    for (int frame = 0; frame < 4; ++frame) {
        const FrameReport report = culler.cull(look_ahead(), device);
        drawn.push_back(culler.drawn_items().size());
        waits.push_back(report.counters.waits);
        EXPECT_EQ(to_string(report.guarantee), "latent(3)");
    }
    EXPECT_EQ(drawn, (std::vector<size_t>{2, 2, 2, 0}));
    EXPECT_EQ(waits, (std::vector<uint64_t>{0, 0, 0, 2}));
}

TEST(NextFrame, WithoutDrawAndQueryBoxesDecide)
{
    const Hierarchy tree = row_tree(1);
    ScriptedDevice device({.boxes = visible_subjects({NodeId{1u}})});
    NextFrame culler{tree, {.visible_interval = 1}};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0), "draw 0 1\nquery [1] [2]\nflush\n");
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(1), "wait 1 -> 1000\nwait 2 -> 0\ndraw 0\nquery [1] [2]\nflush\n");
}

TEST(NextFrame, TheFirstPassOfSeveralCanBeTheTest)
{
    const Hierarchy tree = row_tree(1);
    ScriptedDevice device(script({}));
    NextFrame culler{tree, {.visible_interval = 1, .depth_only_pass = true}};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0), "draw_and_query depth_only 0\ndraw_and_query depth_only 1\n"
                                    "draw shade_equal 0 1\n");
}

TEST(NextFrame, AResetLeavesNoTicketsBehind)
{
    const Hierarchy tree = row_tree(3);
    ScriptedDevice device(script({}));
    NextFrame culler{tree, {.visible_interval = 1}};
    for (int i = 0; i < 10; ++i) {
        culler.cull(look_ahead(), device);
        EXPECT_EQ(device.outstanding(), 8u);
        culler.reset();
    }
}

TEST(NextFrame, TheDeviceContractHoldsAndTheReportAgreesWithACount)
{
    const Hierarchy tree = test::random_bvh(600, 21);
    uint64_t frame = 0;
    DeviceScript made_up{.boxes = test::consistent_visibility(tree, 9, frame, 0.2f),
                         .items =
                             [&](std::span<const ItemId> items) {
                                 uint64_t samples = 0;
                                 for (const ItemId item : items) {
                                     samples += test::item_visible(9, frame, item, 0.2f) ? 10 : 0;
                                 }
                                 return samples;
                             },
                         .latency =
                             [](uint64_t test) {
                                 const uint64_t random = hash64(4, test);
                                 return random % 11 == 0 ? Latency::never()
                                        : random % 13 == 0
                                            ? Latency::lost()
                                            : Latency::after_frames(uniform_below(random, 3));
                             }};
    made_up.caps.draw_and_query = true;
    for (const auto read : {NextFrameOptions::Read::wait, NextFrameOptions::Read::poll}) {
        ScriptedDevice scripted(made_up);
        std::vector<std::string> violations;
        ValidatingDevice valid(scripted,
                               {.on_violation = [&](std::string_view rule, std::string_view text) {
                                   violations.push_back(std::string{rule} + std::string{text});
                               }});
        CountingDevice device(valid);
        NextFrame culler{tree, {.read = read}};
        uint64_t hidden = 0;
        for (frame = 0; frame < 40; ++frame) {
            const float t = static_cast<float>(frame);
            const FrameReport report =
                culler.cull(look({0.0f, 0.0f, 60.0f - t}, {0.5f * t, 0.0f, -60.0f}), device);
            EXPECT_EQ(report.counters.queries, device.frame().queries);
            EXPECT_EQ(report.counters.boxes, device.frame().boxes);
            EXPECT_EQ(report.counters.waits, device.frame().waits);
            EXPECT_EQ(report.counters.lost_answers, device.frame().lost_answers);
            EXPECT_EQ(report.counters.state_changes, device.frame().state_changes);
            EXPECT_EQ(report.counters.items_drawn, device.frame().items_drawn);
            for (const auto& entry : culler.decisions().entries()) {
                hidden += entry.decision == Decision::hidden ? 1 : 0;
            }
        }
        EXPECT_GT(hidden, 100u);
        EXPECT_EQ(violations, std::vector<std::string>{});
    }
}

// Boxes of six faces in front of a standing camera.
class Boxes final : public CpuScene {
public:
    explicit Boxes(std::vector<ItemBounds> bounds)
        : bounds_(std::move(bounds))
    {
        for (const ItemBounds& item : bounds_) {
            auto& corners = positions_.emplace_back();
            for (int c = 0; c < 8; ++c) {
                corners.push_back({(c & 1) != 0 ? item.box.max.x : item.box.min.x,
                                   (c & 2) != 0 ? item.box.max.y : item.box.min.y,
                                   (c & 4) != 0 ? item.box.max.z : item.box.min.z});
            }
        }
    }
    CpuItem item(ItemId item) const override
    {
        static const std::vector<uint32_t> kIndices{0, 1, 2, 2, 1, 3, 4, 6, 5, 5, 6, 7,
                                                    0, 4, 1, 1, 4, 5, 2, 3, 6, 6, 3, 7,
                                                    0, 2, 4, 4, 2, 6, 1, 5, 3, 3, 5, 7};
        return {.positions = positions_[item.value], .indices = kIndices};
    }

private:
    std::vector<ItemBounds> bounds_;
    std::vector<std::vector<glm::vec3>> positions_;
};

TEST(NextFrame, AStandingCameraSeesTheExactImageFromTheThirdFrameOn)
{
    const std::vector<ItemBounds> bounds = test::random_boxes(400, 5, 24.0f, 7.0f);
    const Boxes scene(bounds);
    const Hierarchy tree = build_bvh(bounds, {.leaf_triangles = 300});
    CpuDevice device(scene);
    CpuDevice reference(scene);
    const View view = look({1.0f, 0.5f, 40.0f}, {0.0f, 0.0f, -60.0f}, {97, 61});
    std::vector<ItemId> all;
    for (uint32_t i = 0; i < bounds.size(); ++i) {
        all.push_back(ItemId{i});
    }
    reference.begin_frame(view);
    reference.draw(all, DrawPass::shade);
    reference.end_frame();
    NextFrame culler{tree, {.visible_interval = 1}};
    for (int frame = 0; frame < 12; ++frame) {
        culler.cull(view, device);
        size_t wrong = 0;
        for (size_t pixel = 0; pixel < reference.depth().size(); ++pixel) {
            wrong += reference.depth()[pixel] != device.depth()[pixel] ? 1 : 0;
        }
        EXPECT_EQ(wrong, 0u) << "frame " << frame;
    }
    EXPECT_LT(culler.drawn_items().size(), bounds.size() * 9 / 10);
}

} // namespace
} // namespace occlude
