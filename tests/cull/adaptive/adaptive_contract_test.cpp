// `adaptive` keeps the device contract: with a clock, after resets, with few tickets, in views
// without a pixel, with a useless clock, and after a draw that threw.
#include <occlude/cull/adaptive.h>
#include <occlude/cull/frustum_culler.h>

#include "support/all_methods_device.h"
#include "support/box_scene.h"
#include "support/culler_probe.h"
#include "support/trees.h"

#include <occlude/device/cost_model_device.h>
#include <occlude/device/forwarding_device.h>
#include <occlude/device/scripted_device.h>
#include <occlude/device/validating_device.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

namespace occlude {
namespace {

using Method = AdaptiveOptions::Method;

constexpr uint32_t kTriangles = 3000;

std::vector<ItemBounds> boxes()
{
    std::vector<ItemBounds> items = test::random_boxes(500, 31, 24.0f, 7.0f);
    for (ItemBounds& item : items) {
        item.triangles = kTriangles;
    }
    return items;
}

// A walk that passes through boxes, so that some touch the near plane in every frame.
View walk(uint64_t frame, glm::ivec2 size)
{
    const float t = static_cast<float>(frame % 40);
    return test::look({1.0f, 0.5f, 24.0f - t}, {0.3f * t, 0.0f, -60.0f}, size);
}

// A scene on the CPU device. A cost model defines the time of each call, and all test methods are
// available. `violations` collects what the validating device reports.
class Rig {
public:
    explicit Rig(const DeviceCosts& costs = {}, uint32_t max_outstanding = 4096)
        : bounds_(boxes())
        , tree(build_bvh(bounds_, {.leaf_triangles = kTriangles}))
        , scene_(bounds_)
        , triangles_(bounds_.size(), kTriangles)
        , cpu_(scene_, {.max_outstanding = max_outstanding})
        , reference_cpu_(scene_)
        , all_(cpu_)
        , timed(all_, costs, triangles_)
        , device(timed, {.on_violation =
                             [this](std::string_view rule, std::string_view text) {
                                 violations.push_back(std::string{rule} + " " + std::string{text});
                             }})
        , reference_(tree)
    {
    }

    // Culls one frame, and compares its picture with that of frustum culling.
    FrameReport cull(Culler& culler, const View& view)
    {
        const FrameReport report = culler.cull(view, device);
        reference_.cull(view, reference_cpu_);
        EXPECT_TRUE(std::ranges::equal(cpu_.depth(), reference_cpu_.depth()));
        hidden += reference_.drawn_items().size() - culler.drawn_items().size();
        return report;
    }

private:
    std::vector<ItemBounds> bounds_;

public:
    Hierarchy tree;

private:
    test::BoxCpuScene scene_;
    std::vector<uint32_t> triangles_;
    CpuDevice cpu_;
    CpuDevice reference_cpu_;
    test::AllMethodsDevice all_;

public:
    CostModelDevice timed;
    ValidatingDevice device;
    std::vector<std::string> violations;
    size_t hidden = 0; ///< items that were not drawn, in all frames

private:
    FrustumCuller reference_;
};

// Reading depth is expensive, so that other methods are measured while it is in use.
DeviceCosts expensive_reads()
{
    DeviceCosts costs;
    costs.per_depth_read = 1500.0;
    return costs;
}

// --- with a clock --------------------------------------------------------------------------------

TEST(AdaptiveContract, HoldsByEveryMethodWhileItMeasures)
{
    for (const Method method :
         {Method::automatic, Method::queries, Method::raster, Method::pyramid}) {
        SCOPED_TRACE(static_cast<int>(method));
        Rig rig(expensive_reads());
        Adaptive culler{rig.tree, {.method = method}, [&] { return rig.timed.seconds(); }};
        uint64_t queries = 0;
        uint64_t reads = 0;
        for (uint64_t frame = 0; frame < 60; ++frame) {
            const FrameReport report = rig.cull(culler, walk(frame, {96, 54}));
            queries += report.counters.queries;
            reads += report.counters.depth_reads;
        }
        EXPECT_EQ(rig.violations, std::vector<std::string>{});
        EXPECT_GT(rig.hidden, 1000u);
        if (method == Method::automatic) { // it used one method and measured the other
            EXPECT_GT(queries, 0u);
            EXPECT_GT(reads, 0u);
        }
    }
}

// Looks to one side and to the other in turn. Each side has plates at the near plane, a wall, and
// boxes behind the wall. A floor is always visible, so that depth can be read at once.
std::vector<ItemBounds> plates_and_walls()
{
    std::vector<ItemBounds> items;
    const auto add = [&](const glm::vec3& a, const glm::vec3& b) {
        items.push_back({{glm::min(a, b), glm::max(a, b)}, kTriangles});
    };
    add({-60.0f, -2.2f, -60.0f}, {60.0f, -2.0f, 60.0f});
    for (const float side : {-1.0f, 1.0f}) {
        for (int i = 0; i < 40; ++i) {
            const float z = 0.002f * static_cast<float>(i) - 0.04f;
            add({side * 0.05f, -0.05f, z}, {side * 0.3f, 0.05f, z + 0.001f});
        }
        add({side * 6.0f, -2.0f, -30.0f}, {side * 7.0f, 30.0f, 30.0f});
        for (int i = 0; i < 100; ++i) {
            const float z = static_cast<float>(i % 10) - 5.0f;
            const float x = side * (10.0f + 2.0f * static_cast<float>(i / 10));
            add({x, 0.0f, z}, {x + side, 1.0f, z + 0.5f});
        }
    }
    return items;
}

// C5: a trial of another method takes tests that are due anyway, and many of these boxes touch the
// near plane.
TEST(AdaptiveContract, NoTrialTestsABoxAtTheNearPlane)
{
    const std::vector<ItemBounds> items = plates_and_walls();
    const Hierarchy tree = build_bvh(items, {.leaf_triangles = kTriangles});
    test::BoxCpuScene scene(items);
    CpuDevice cpu(scene);
    const std::vector<uint32_t> triangles(items.size(), kTriangles);
    CostModelDevice timed(cpu, expensive_reads(), triangles);
    std::vector<std::string> violations;
    ValidatingDevice device(timed, {.on_violation = [&](std::string_view rule, std::string_view) {
                                violations.emplace_back(rule);
                            }});
    Adaptive culler{tree, {}, [&] { return timed.seconds(); }};
    uint64_t trials = 0;
    for (int frame = 0; frame < 40; ++frame) {
        const float side = frame / 2 % 2 == 0 ? 1.0f : -1.0f;
        const View view = test::look({0.0f, 0.0f, 0.0f}, {side, -0.2f, 0.0f}, {64, 64});
        const FrameReport report = culler.cull(view, device);
        trials += report.plan.kind == FramePlan::Kind::pyramid ? report.counters.batches : 0;
    }
    EXPECT_EQ(violations, std::vector<std::string>{});
    EXPECT_GT(trials, 2u) << "the case proves nothing";
}

// C11: rounds, tests for later frames and trials together, on devices with few tickets.
TEST(AdaptiveContract, NeverHoldsMoreTicketsThanTheDeviceHas)
{
    for (const uint32_t tickets : {1u, 2u, 7u, 40u}) {
        for (const Method method : {Method::automatic, Method::queries, Method::raster}) {
            SCOPED_TRACE(std::to_string(tickets) + " tickets");
            Rig rig(expensive_reads(), tickets);
            Adaptive culler{rig.tree, {.method = method}, [&] { return rig.timed.seconds(); }};
            uint64_t lost = 0;
            for (uint64_t frame = 0; frame < 40; ++frame) {
                lost += rig.cull(culler, walk(frame, {96, 54})).counters.lost_answers;
            }
            EXPECT_EQ(rig.violations, std::vector<std::string>{});
            EXPECT_EQ(lost, 0u);
            EXPECT_GT(rig.hidden, 500u);
        }
    }
}

TEST(AdaptiveContract, ReadsNothingFromATargetWithoutAPixel)
{
    for (const glm::ivec2 size : {glm::ivec2{0, 0}, glm::ivec2{0, 64}, glm::ivec2{64, 0}}) {
        ScriptedDevice scripted;
        scripted.script().caps.read_depth = true;
        std::vector<std::string> violations;
        ValidatingDevice device(scripted,
                                {.on_violation = [&](std::string_view rule, std::string_view) {
                                    violations.emplace_back(rule);
                                }});
        double seconds = 0.0;
        const Hierarchy tree = test::random_bvh(200, 3);
        for (const Method method : {Method::automatic, Method::pyramid, Method::queries}) {
            Adaptive culler{tree, {.method = method}, [&] { return seconds += 1e-4; }};
            for (int frame = 0; frame < 5; ++frame) {
                const View view = View::from_clip(test::look_ahead().clip_from_world(), size);
                EXPECT_EQ(culler.cull(view, device).counters.depth_reads, 0u);
            }
        }
        EXPECT_EQ(violations, std::vector<std::string>{});
    }
}

// --- useless clocks ------------------------------------------------------------------------------

// The cost hints of the CPU device differ from these costs. Only a clock would show it.
TEST(AdaptiveClock, ThatStandsStillIsNoticedAndHintsAreUsed)
{
    for (const double tick : {0.0, 0.5}) { // seconds: the clock stands still, or is coarse
        Rig with_clock(expensive_reads());
        Rig without(expensive_reads());
        Adaptive culler{with_clock.tree, {}, [&] {
                            return tick > 0.0 ? tick * std::floor(with_clock.timed.seconds() / tick)
                                              : 42.0;
                        }};
        Adaptive by_hints{without.tree};
        FrameReport report;
        FrameReport expected;
        for (uint64_t frame = 0; frame < 30; ++frame) {
            report = with_clock.cull(culler, walk(frame, {96, 54}));
            expected = without.cull(by_hints, walk(frame, {96, 54}));
        }
        EXPECT_EQ(report.plan.reason, FramePlan::Reason::useless_clock);
        EXPECT_NE(to_string(report.plan).find("clock"), std::string::npos);
        EXPECT_EQ(expected.plan.reason, FramePlan::Reason::saves);
        EXPECT_EQ(report.plan.kind, expected.plan.kind);
        EXPECT_EQ(CullerProbe::costs(culler).us_per_unit(),
                  CullerProbe::costs(by_hints).us_per_unit());
        EXPECT_GT(with_clock.hidden, 1000u);
    }
}

TEST(AdaptiveClock, ThatTicksIsKept)
{
    Rig rig(expensive_reads());
    Adaptive culler{rig.tree, {}, [&] { return rig.timed.seconds(); }};
    for (uint64_t frame = 0; frame < 60; ++frame) {
        EXPECT_NE(rig.cull(culler, walk(frame, {96, 54})).plan.reason,
                  FramePlan::Reason::useless_clock);
    }
    EXPECT_GT(CullerProbe::costs(culler).rounds_measured(TestMethod::pyramid), 0u);
}

TEST(CostMeter, AResetGivesAClockAnotherChance)
{
    double seconds = 1.0;
    CostMeter meter{[&] { return seconds; }};
    meter.start_frame(DeviceCaps{});
    meter.note_drawing(1000.0, 5000.0);
    const double learnt = meter.costs().us_per_unit();
    EXPECT_NE(learnt, double{DeviceCaps{}.us_per_triangle});
    for (int i = 0; i < 2; ++i) {
        meter.check_clock(meter.now_us(), meter.now_us());
    }
    EXPECT_TRUE(meter.has_clock()); // two in a row may be chance
    EXPECT_EQ(meter.costs().us_per_unit(), learnt);
    meter.check_clock(meter.now_us(), meter.now_us());
    EXPECT_FALSE(meter.has_clock());
    EXPECT_TRUE(meter.clock_is_useless());
    EXPECT_EQ(meter.costs().us_per_unit(), double{DeviceCaps{}.us_per_triangle});
    meter.trust_clock();
    EXPECT_TRUE(meter.has_clock());
}

TEST(CostMeter, WithoutAClockNothingIsMeasuredAndNothingIsSaid)
{
    CostMeter meter{{}};
    meter.start_frame(DeviceCaps{});
    for (int i = 0; i < 10; ++i) {
        meter.check_clock(0.0, 0.0);
        meter.note_drawing(1000.0, 5000.0);
    }
    EXPECT_FALSE(meter.clock_is_useless());
    EXPECT_EQ(meter.costs().us_per_unit(), double{DeviceCaps{}.us_per_triangle});
}

// --- draws that throw ----------------------------------------------------------------------------

// A device whose draw throws when it is told to.
class ThrowingDevice final : public ForwardingDevice {
public:
    explicit ThrowingDevice(QueryDevice& inner)
        : ForwardingDevice(inner)
    {
    }
    void draw(std::span<const ItemId> items, DrawPass pass) override
    {
        if (std::exchange(throws, false)) {
            throw std::runtime_error{"no such mesh"};
        }
        inner().draw(items, pass);
    }

    bool throws = false;
};

TEST(AdaptiveContract, HoldsInTheFramesAfterADrawThatThrew)
{
    for (const Method method :
         {Method::automatic, Method::queries, Method::raster, Method::pyramid}) {
        Rig rig;
        ThrowingDevice device(rig.device);
        Adaptive culler{rig.tree, {.method = method}};
        size_t thrown = 0;
        for (uint64_t frame = 0; frame < 40; ++frame) {
            device.throws = frame % 4 == 3;
            const View view = walk(7 * frame, {96, 54}); // the items that were outside come back
            try {
                culler.cull(view, device);
            } catch (const std::runtime_error&) {
                ++thrown;
                continue;
            }
            std::vector<ItemId> drawn(culler.drawn_items().begin(), culler.drawn_items().end());
            std::ranges::sort(drawn);
            EXPECT_EQ(std::ranges::adjacent_find(drawn), drawn.end());
            rig.cull(culler, view);
        }
        EXPECT_EQ(thrown, 10u);
        EXPECT_EQ(rig.violations, std::vector<std::string>{});
        EXPECT_GT(rig.hidden, 500u);
    }
}

} // namespace
} // namespace occlude
