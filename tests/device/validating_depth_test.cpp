// The rules that ValidatingDevice checks by depth read around each batch: C2, C3 and C4.
#include "device_test_helpers.h"
#include "validating_bench.h"

#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/device/scripted_device.h>

#include "support/box_scene.h"

#include <gtest/gtest.h>

namespace occlude {
namespace {

using test::ask;
using test::Bench;
using test::depth_caps;
using test::draw;

TEST(ValidatingDevice, C2ATestThatSawLaterDrawsIsCaught)
{
    ScriptedDevice scripted({.boxes = visible_subjects({}), .caps = depth_caps()});
    Bench bench(scripted, ValidatingDevice::DepthChecks::around_batches);
    bench.device.begin_frame(test::camera());
    const Ticket ticket = ask(bench.device, {1}); // nothing is drawn: it must be seen
    draw(bench.device, {1});
    bench.device.wait(ticket);
    EXPECT_EQ(bench.broken(), "C2 ");
}

TEST(ValidatingDevice, C3ACountOfZeroInFrontOfAllDepthIsCaught)
{
    float depth01 = 1.0f;
    ScriptedDevice scripted({.boxes = visible_subjects({}),
                             .depth =
                                 [&](const PixelRect&, std::span<float> out) {
                                     std::fill(out.begin(), out.end(), depth01);
                                     return true;
                                 },
                             .caps = depth_caps()});
    Bench bench(scripted, ValidatingDevice::DepthChecks::around_batches);
    bench.device.begin_frame(test::camera());
    bench.device.wait(ask(bench.device, {1}));
    EXPECT_EQ(bench.broken(), "C3 ");
    // The same for a turned box in its own space.
    const glm::mat4 shift = glm::translate(glm::mat4{1.0f}, glm::vec3{0.0f, 0.0f, -10.0f});
    const QueryBox box{Aabb{glm::vec3{-0.5f}, glm::vec3{0.5f}}, &shift, NodeId{1u}};
    bench.device.wait(ask(bench.device, std::span{&box, 1}));
    EXPECT_EQ(bench.broken(), "C3 ");

    // The box spans 9.5 to 10.5; window depth there is 0.90 to 0.92. Nearer depth hides it, and
    // depth inside of it may.
    for (const float hides : {0.5f, 0.91f}) {
        depth01 = hides;
        bench.device.wait(ask(bench.device, {1}));
        EXPECT_EQ(bench.broken(), "") << hides;
    }
    depth01 = 0.93f;
    bench.device.wait(ask(bench.device, {1}));
    EXPECT_EQ(bench.broken(), "C3 ");
    scripted.script().boxes = {};
    bench.device.wait(ask(bench.device, {1}));
    EXPECT_EQ(bench.broken(), "") << "a box that is seen breaks nothing";
}

TEST(ValidatingDevice, C3HoldsInReversedDepthToo)
{
    // Reversed: near 1 is depth 1, far 100 is depth 0.
    glm::mat4 projection = glm::perspective(glm::radians(90.0f), 1.0f, 1.0f, 100.0f);
    projection[2][2] = 1.0f / 99.0f;
    projection[3][2] = 100.0f / 99.0f;
    const View view =
        View::from_clip(projection, {64, 64}, {DepthRange::zero_to_one, DepthOrder::near_is_large});
    for (const bool seen : {false, true}) {
        ScriptedDevice scripted({.boxes = visible_subjects({}),
                                 .depth =
                                     [&](const PixelRect&, std::span<float> out) {
                                         std::fill(out.begin(), out.end(), seen ? 0.93f : 0.88f);
                                         return true;
                                     },
                                 .caps = depth_caps()});
        Bench bench(scripted, ValidatingDevice::DepthChecks::around_batches);
        bench.device.begin_frame(view);
        bench.device.wait(ask(bench.device, {1}));
        EXPECT_EQ(bench.broken(), seen ? "C3 " : "");
    }
}

TEST(ValidatingDevice, C3DoesNotBlameBoxesTooSmallToCoverAPixel)
{
    ScriptedDevice scripted({.boxes = visible_subjects({}), .caps = depth_caps()});
    Bench bench(scripted, ValidatingDevice::DepthChecks::around_batches);
    bench.device.begin_frame(test::camera());
    const glm::vec3 center{0.16f, 0.16f, -10.0f}; // the middle of a pixel of 0.3125
    const QueryBox small{Aabb{center - 0.1f, center + 0.1f}, nullptr, NodeId{1u}};
    bench.device.wait(ask(bench.device, std::span{&small, 1}));
    EXPECT_EQ(bench.broken(), "");
    const QueryBox large{Aabb{center - 0.3f, center + 0.3f}, nullptr, NodeId{1u}};
    bench.device.wait(ask(bench.device, std::span{&large, 1}));
    EXPECT_EQ(bench.broken(), "C3 ");
}

TEST(ValidatingDevice, C4ABatchThatWritesDepthIsCaught)
{
    ScriptedDevice scripted({.caps = depth_caps()});
    scripted.script().depth = [&](const PixelRect&, std::span<float> out) {
        std::fill(out.begin(), out.end(), 1.0f);
        out[5] = scripted.outstanding() > 0 ? 0.5f : 1.0f; // as if the box had been drawn
        return true;
    };
    Bench bench(scripted, ValidatingDevice::DepthChecks::around_batches);
    bench.device.begin_frame(test::camera());
    ask(bench.device, {1});
    EXPECT_EQ(bench.broken(), "C4 ");
    scripted.script().depth = {};
    ask(bench.device, {1});
    EXPECT_EQ(bench.broken(), "");
}

TEST(ValidatingDevice, C4DepthThatCannotBeReadNowAndThenIsNoChange)
{
    ScriptedDevice scripted({.caps = depth_caps()});
    bool readable = false;
    scripted.script().depth = [&](const PixelRect&, std::span<float> out) {
        readable = !readable; // the first reading works, the second fails, and so on
        std::fill(out.begin(), out.end(), 1.0f);
        return readable;
    };
    Bench bench(scripted, ValidatingDevice::DepthChecks::around_batches);
    bench.device.begin_frame(test::camera());
    ask(bench.device, {1});
    EXPECT_EQ(bench.broken(), "");
    readable = true; // now the first fails
    ask(bench.device, {1});
    EXPECT_EQ(bench.broken(), "");
}

// A wall and a box just behind it, seen from 10 units away. A device that computes in float places
// them less precisely with growing distance from the origin.
size_t violations_at(float x, bool hidden)
{
    const glm::vec3 eye{x, 0.0f, 0.0f};
    const std::vector<ItemBounds> bounds{
        {Aabb{eye + glm::vec3{-8.0f, -8.0f, -12.0f}, eye + glm::vec3{8.0f, 8.0f, -10.0f}}, 12}};
    const View view = View::from_clip(glm::perspective(glm::radians(90.0f), 1.0f, 1.0f, 100.0f) *
                                          glm::translate(glm::mat4{1.0f}, -eye),
                                      {64, 64});
    const test::BoxCpuScene scene(bounds);
    CpuDevice cpu(scene);
    Bench bench(cpu, ValidatingDevice::DepthChecks::around_batches);
    bench.device.begin_frame(view);
    draw(bench.device, {0});
    const float front = hidden ? -14.0f : -8.0f;
    for (int step = -8; step <= 8; ++step) {
        const glm::vec3 middle = eye + glm::vec3{static_cast<float>(step), 0.0f, front};
        const QueryBox box{Aabb{middle - 1.0f, middle + 1.0f}, nullptr, NodeId{1u}};
        bench.device.wait(ask(bench.device, std::span{&box, 1}));
    }
    bench.device.end_frame();
    return bench.rules.size();
}

TEST(ValidatingDevice, C3BlamesNobodyForWhatFloatCannotKnowFarFromTheOrigin)
{
    for (const float x : {0.0f, 1e4f, 1e6f, 4e6f, 1e7f}) {
        EXPECT_EQ(violations_at(x, true), 0u) << x;
        EXPECT_EQ(violations_at(x, false), 0u) << x;
    }
}

// Answers "hidden" to everything, over a depth buffer that shows the opposite.
std::string blame_for_a_box_at(float x)
{
    ScriptedDevice scripted({.boxes = visible_subjects({}), .caps = depth_caps()});
    Bench bench(scripted, ValidatingDevice::DepthChecks::around_batches);
    const glm::vec3 eye{x, 0.0f, 0.0f};
    bench.device.begin_frame(
        View::from_clip(glm::perspective(glm::radians(90.0f), 1.0f, 1.0f, 100.0f) *
                            glm::translate(glm::mat4{1.0f}, -eye),
                        {64, 64}));
    const glm::vec3 middle = eye + glm::vec3{0.0f, 0.0f, -10.0f};
    const QueryBox box{Aabb{middle - 4.0f, middle + 4.0f}, nullptr, NodeId{1u}};
    bench.device.wait(ask(bench.device, std::span{&box, 1}));
    return bench.broken();
}

TEST(ValidatingDevice, C3StillBlamesAWrongAnswerWhereFloatIsSureOfIt)
{
    EXPECT_EQ(blame_for_a_box_at(0.0f), "C3 ");
    EXPECT_EQ(blame_for_a_box_at(1e4f), "C3 ");
    EXPECT_EQ(blame_for_a_box_at(1e8f), "") << "a unit is lost in rounding there";
}

} // namespace
} // namespace occlude
