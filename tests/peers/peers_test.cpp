// Defects of other culling code: each is a test here, named after the defect. The comment says what
// the defect does to a picture or a frame. (complaints_test.cpp: the complaints of users.)
#include "peers/peers.h"

#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/cull/registry.h>
#include <occlude/device/counting_device.h>
#include <occlude/device/delaying_device.h>
#include <occlude/device/scripted_device.h>
#include <occlude/hierarchy/builders/bvh_builder.h>
#include <occlude/screen/depth_pyramid.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

namespace occlude {
namespace {

using namespace test::peers;

// A query system drained the GPU before each look at a result, so that coherent culling became
// stop-and-wait. Here: with answers that take long, most of them arrive without a wait.
TEST(PeerDefects, FinishBeforeEveryPollMakesCoherentCullingStopAndWait)
{
    const std::vector<ItemBounds> items = behind_a_wall(300);
    const Hierarchy tree = build_bvh(items, {.leaf_triangles = 600});
    const test::BoxCpuScene scene(items);
    for (const char* algorithm : {"chc", "chc_plus_plus"}) {
        CpuDevice cpu(scene);
        DelayingDevice late(cpu, {.min_polls = 1, .max_polls = 3});
        const auto culler = make(algorithm, tree);
        FrameCounters sum;
        for (int frame = 0; frame < 8; ++frame) {
            const float t = static_cast<float>(frame);
            sum += culler->cull(test::look({t - 4, 0, -7.5f}, {0, 0, -40}), late).counters;
        }
        EXPECT_GT(sum.queries, 40u);
        EXPECT_LT(sum.waits, sum.queries) << algorithm;
    }
}

// A pull-up loop tested an array instead of the entry of its frame, so that ancestors of visible
// nodes stayed "hidden" and were tested in every frame. Here: where everything is visible, inner
// nodes are not tested from the second frame on.
TEST(PeerDefects, PullUpThatStopsAtOnceKeepsTestingTheAncestorsOfVisibleNodes)
{
    const Hierarchy tree = test::row_tree(4);
    for (const char* algorithm : {"chc", "chc_plus_plus"}) {
        ScriptedDevice device; // everything is visible
        const auto culler = make(algorithm, tree);
        for (int frame = 0; frame < 4; ++frame) {
            device.clear_trace();
            culler->cull(test::look_ahead(), device);
        }
        for (const ScriptedDevice::Event& event : device.trace()) {
            for (const NodeId subject : event.subjects) {
                EXPECT_TRUE(!subject.valid() || tree.is_leaf(subject)) << algorithm;
            }
        }
    }
}

// Tests ran against the depth of the frame before: objects behind a corner appeared a frame late.
// Here: the camera jumps to and fro past the wall, and every frame is right.
TEST(PeerDefects, DepthOfThePreviousFrameHidesWhatTheCameraHasJustUncovered)
{
    const std::vector<ItemBounds> items = behind_a_wall(200);
    const Hierarchy tree = build_bvh(items, {.leaf_triangles = 400});
    const test::BoxCpuScene scene(items);
    for (const char* algorithm : kExact) {
        CpuDevice device(scene);
        const auto culler = make(algorithm, tree);
        for (int frame = 0; frame < 8; ++frame) {
            const View view =
                frame % 2 == 0 ? test::look_ahead() : test::look({0, 0, -7.5f}, {0, 0, -20});
            culler->cull(view, device);
            ASSERT_EQ(test::owners(device), owners_of_everything(scene, items.size(), view))
                << algorithm << ", frame " << frame;
        }
    }
}

// The mode called the fastest skipped the tests of visible leaves for good: they were drawn for
// ever. Here: what gets hidden is found within the frames that the options name.
TEST(PeerDefects, VisibleLeavesThatAreNeverTestedAgainAreDrawnForEver)
{
    const std::vector<ItemBounds> items = behind_a_wall(300);
    const Hierarchy tree = build_bvh(items, {.leaf_triangles = 600});
    const test::BoxCpuScene scene(items);
    for (const char* algorithm : kExact) {
        CpuDevice device(scene);
        const auto culler = make(algorithm, tree);
        for (int frame = 0; frame < 5; ++frame) {
            culler->cull(test::look({0, 0, -7.5f}, {0, 0, -20}), device); // behind the wall
        }
        const size_t seen_behind = culler->drawn_items().size();
        for (int frame = 0; frame < 60; ++frame) {
            culler->cull(test::look_ahead(), device);
        }
        EXPECT_GT(seen_behind, 50u) << algorithm;
        EXPECT_LT(culler->drawn_items().size(), 10u) << algorithm;
    }
}

// State that belonged to the scene, not to the camera, and one random engine for all: two views
// disturbed each other, and nothing could be repeated. Here: a culler decides the same whether
// another one works between its frames or not.
TEST(PeerDefects, TemporalStateKeyedByTheSceneIsDisturbedByASecondView)
{
    const std::vector<ItemBounds> items = behind_a_wall(200);
    const Hierarchy tree = build_bvh(items, {.leaf_triangles = 400});
    const test::BoxCpuScene scene(items);
    for (const char* algorithm : kExact) {
        std::array<std::vector<uint64_t>, 2> hashes;
        for (const int others : {0, 1}) {
            CpuDevice device(scene);
            const auto culler = make(algorithm, tree);
            const auto other = make(algorithm, tree);
            for (uint64_t frame = 0; frame < 10; ++frame) {
                const float t = static_cast<float>(frame);
                culler->cull(test::look({0.3f * t, 0, 0}, {0, 0, -20}), device);
                hashes[static_cast<size_t>(others)].push_back(
                    culler->decisions().hash(tree, frame));
                if (others != 0) {
                    other->cull(test::look({5, 2, -50}, {0, 0, t}), device);
                }
            }
        }
        EXPECT_EQ(hashes[0], hashes[1]) << algorithm;
    }
}

// With an empty queue of visible nodes a loop span on a pending result instead of going on with the
// traversal. Here: answers that never come by themselves let every frame end, with a bounded number
// of polls.
TEST(PeerDefects, SpinningOnAPendingResultNeverEndsTheFrame)
{
    const Hierarchy tree = test::random_bvh(200, 5);
    for (const char* algorithm : {"chc", "chc_plus_plus", "statistical", "two_level", "adaptive"}) {
        ScriptedDevice device({.latency = [](uint64_t) { return Latency::never(); }});
        CountingDevice counting(device);
        const auto culler = make(algorithm, tree);
        for (int frame = 0; frame < 3; ++frame) {
            culler->cull(test::look({0, 0, 70}, {0, 0, 0}), counting);
        }
        const auto& trace = device.trace();
        const auto polls = std::count_if(trace.begin(), trace.end(), [](const auto& event) {
            return event.verb == DeviceVerb::poll;
        });
        EXPECT_LT(polls, 200000) << algorithm;
    }
}

// Depth, colour and lighting were switched for each single box. Here: batches of tests need far
// fewer changes of state than tests.
TEST(PeerDefects, OneChangeOfStatePerQueryThrashesTheDriver)
{
    const std::vector<ItemBounds> items = behind_a_wall(600);
    const Hierarchy tree = build_bvh(items, {.leaf_triangles = 400});
    const test::BoxCpuScene scene(items);
    CpuDevice device(scene);
    const auto culler = make("chc_plus_plus", tree, {{"multiqueries", "off"}});
    FrameCounters sum;
    for (int frame = 0; frame < 6; ++frame) {
        const float t = static_cast<float>(frame);
        sum += culler->cull(test::look({-8 + 3 * t, 0, -7.5f}, {0, 0, -40}), device).counters;
    }
    EXPECT_GT(sum.queries, 100u);
    EXPECT_LT(sum.state_changes, sum.queries / 2);
}

// Defaults dropped objects of up to 500 pixels and kept answers for five frames, without a word.
// Here: with its default options, an algorithm that promises an exact image keeps the promise.
TEST(PeerDefects, DefaultsThatSilentlyDropVisibleObjects)
{
    expect_worlds_pass([](worlds::Spec& spec) { spec.options.clear(); }, 500);
}

// Boxes grew by a fixed 0.001 units: too little in kilometres, far too much in millimetres.
TEST(PeerDefects, InflationByAFixedLengthBreaksAtOtherScales)
{
    for (const float unit : {1e-3f, 1e3f}) {
        expect_worlds_pass([unit](worlds::Spec& spec) { spec.unit = unit; }, 600);
    }
}

// The faces of a tested box were culled by their winding: it was not there when seen from the
// right. Here: from all sides and in all mirrorings, a box before a wall is seen, and one behind is
// not.
TEST(PeerDefects, WindingHidesTheTestedBoxFromSomeDirections)
{
    for (int direction = 0; direction < 27; ++direction) {
        const glm::vec3 toward{static_cast<float>(direction % 3 - 1),
                               static_cast<float>(direction / 3 % 3 - 1),
                               static_cast<float>(direction / 9 - 1)};
        if (toward == glm::vec3{0.0f}) {
            continue;
        }
        // A cube at the origin hides a smaller one behind it; another stands before it.
        const std::vector<ItemBounds> items{{{glm::vec3{-4.0f}, glm::vec3{4.0f}}, 12}};
        const test::BoxCpuScene scene(items);
        const glm::vec3 ahead = glm::normalize(toward);
        const glm::vec3 up = std::abs(ahead.y) > 0.9f ? glm::vec3{1, 0, 0} : glm::vec3{0, 1, 0};
        const View view = View::from_clip(glm::perspectiveRH_NO(1.2f, 1.0f, 0.1f, 200.0f) *
                                              glm::lookAtRH(-25.0f * ahead, glm::vec3{0.0f}, up),
                                          {64, 64});
        CpuDevice device(scene);
        for (const float mirror : {1.0f, -1.0f}) {
            const glm::mat4 before =
                glm::scale(glm::translate(glm::mat4{1.0f}, -12.0f * ahead), {mirror, 1.0f, 1.0f});
            const glm::mat4 behind =
                glm::scale(glm::translate(glm::mat4{1.0f}, 12.0f * ahead), {1.0f, mirror, mirror});
            const Aabb unit{glm::vec3{-0.5f}, glm::vec3{0.5f}};
            const std::array boxes{QueryBox{unit, &before, NodeId{}},
                                   QueryBox{unit, &behind, NodeId{}}};
            const std::array ends{1u, 2u};
            std::array<Ticket, 2> tickets;
            const ItemId cube{0u};
            device.begin_frame(view);
            device.draw(std::span{&cube, 1}, DrawPass::shade);
            device.query({boxes, ends}, tickets);
            device.end_frame();
            EXPECT_GT(device.wait(tickets[0]).samples, 0u) << direction;
            EXPECT_EQ(device.wait(tickets[1]).samples, 0u) << direction;
        }
    }
}

// A pyramid over a target whose sides are no powers of two lost its last rows and columns: boxes at
// the right and upper edge were called hidden. Here: one far pixel anywhere shows every box over
// it, at all sizes.
TEST(PeerDefects, PyramidOfOddSizesForgetsTheLastRowsAndColumns)
{
    Rng rng{7};
    for (int i = 0; i < 300; ++i) {
        const glm::ivec2 size{1 + static_cast<int>(rng.below(70)),
                              1 + static_cast<int>(rng.below(70))};
        DepthPyramid pyramid;
        const std::span<float> depth = pyramid.resize(size);
        std::fill(depth.begin(), depth.end(), 0.25f);
        const glm::ivec2 hole{static_cast<int>(rng.below(static_cast<uint32_t>(size.x))),
                              static_cast<int>(rng.below(static_cast<uint32_t>(size.y)))};
        depth[static_cast<size_t>(hole.y * size.x + hole.x)] = 1.0f;
        pyramid.build();
        const int x = static_cast<int>(rng.below(static_cast<uint32_t>(hole.x + 1)));
        const int y = static_cast<int>(rng.below(static_cast<uint32_t>(hole.y + 1)));
        const PixelRect over{x, y, size.x - x, size.y - y};
        for (const auto refinement :
             {DepthPyramid::Refinement::none, DepthPyramid::Refinement::pixels}) {
            EXPECT_FALSE(pyramid.hides(over, 0.5f, refinement))
                << size.x << 'x' << size.y << ", hole at " << hole.x << ", " << hole.y;
        }
        if (hole.x > 0) {
            EXPECT_TRUE(
                pyramid.hides({0, 0, hole.x, size.y}, 0.5f, DepthPyramid::Refinement::pixels));
        }
    }
}

// An object that took over the number of another inherited its answer, and was missing for up to
// three frames. Here: an item whose number belonged to a hidden one is drawn in its first frame,
// although the test of the hidden one is still in flight.
TEST(PeerDefects, RecycledObjectInheritsTheAnswerOfItsPredecessor)
{
    for (const char* algorithm : kExact) {
        std::vector<ItemBounds> items = behind_a_wall(60);
        Hierarchy tree = build_bvh(items, {.leaf_triangles = 200});
        auto scene = std::make_unique<test::BoxCpuScene>(items);
        struct Current final : CpuScene {
            std::unique_ptr<test::BoxCpuScene>& scene;
            explicit Current(std::unique_ptr<test::BoxCpuScene>& s)
                : scene(s)
            {
            }
            CpuItem item(ItemId item) const override { return scene->item(item); }
        } current{scene};
        CpuDevice cpu(current);
        DelayingDevice late(cpu, {.max_polls = 50, .min_frames = 2, .max_frames = 3});
        const auto culler = make(algorithm, tree);
        for (int frame = 0; frame < 4; ++frame) {
            culler->cull(test::look_ahead(), late);
        }
        items[20].box = {{-0.5f, -0.5f, -3.0f}, {0.5f, 0.5f, -2.0f}}; // before the wall
        scene = std::make_unique<test::BoxCpuScene>(items);
        tree.refit(items);
        culler->cull(test::look_ahead(), late);
        const auto drawn = culler->drawn_items();
        EXPECT_NE(std::find(drawn.begin(), drawn.end(), ItemId{20u}), drawn.end()) << algorithm;
        EXPECT_EQ(test::owners(cpu), owners_of_everything(*scene, items.size(), test::look_ahead()))
            << algorithm;
    }
}

// A guard against stalls measured from the wrong moment, so that it never or always took effect.
// Here: a budget of time counts from the start of the frame's work, whatever the clock showed then.
TEST(PeerDefects, BudgetMeasuredFromTheWrongMomentIsNoBudget)
{
    const std::vector<ItemBounds> items = test::random_boxes(400, 3);
    const Hierarchy tree = build_bvh(items);
    std::array<size_t, 2> drawn{};
    for (const double start : {0.0, 1e6}) {
        ScriptedDevice device;
        const std::array<OptionValue, 2> options{
            {{"budget_time", "10"}, {"cell_triangles", "500"}}};
        auto culler = make_culler("prioritized", tree, options,
                                  [now = start]() mutable { return now += 0.001; });
        ASSERT_TRUE(culler) << culler.error().message;
        for (int frame = 0; frame < 3; ++frame) {
            (*culler)->cull(test::look({0, 0, 90}, {0, 0, 0}), device);
        }
        drawn[start > 0.0 ? 1 : 0] = (*culler)->drawn_items().size();
    }
    EXPECT_EQ(drawn[0], drawn[1]);
    EXPECT_GT(drawn[0], 0u);
    EXPECT_LT(drawn[0], items.size());
}

} // namespace
} // namespace occlude
