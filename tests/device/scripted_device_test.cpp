#include "device_test_helpers.h"

#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

namespace occlude {
namespace {

using test::ask;
using test::ask_batch;
using test::draw;

TEST(ScriptedDevice, TraceReadsAsTheVerbsInCallOrder)
{
    ScriptedDevice device({.boxes = visible_subjects({NodeId{7u}}, 50),
                           .latency = [](uint64_t) { return Latency::after_polls(1); },
                           .caps = {.name = "scripted", .draw_and_query = true, .methods = {}}});
    device.begin_frame(test::camera());
    draw(device, {3, 4});
    draw(device, {5}, DrawPass::depth_only);
    const auto tickets = ask_batch(device, {{7}, {8, 9}});
    device.flush();
    device.poll(tickets[0]);
    device.poll(tickets[0]);
    device.wait(tickets[1]);
    device.wait(tickets[1]);
    device.wait(device.draw_and_query(test::items({6, 1}), DrawPass::shade));
    std::array<float, 6> depth{};
    device.read_depth({1, 2, 3, 2}, depth);
    device.end_frame();
    device.begin_frame(test::camera());
    device.flush();
    EXPECT_EQ(device.trace_text(), "frame 0\n"
                                   "draw 3 4\n"
                                   "draw depth_only 5\n"
                                   "query [7] [8 9]\n"
                                   "flush\n"
                                   "poll 7 pending\n"
                                   "poll 7 -> 50\n"
                                   "wait 8 9 -> 0\n"
                                   "wait ? -> lost\n"
                                   "draw_and_query 6 1\n"
                                   "wait item 6 1 -> 2000\n"
                                   "read_depth 1 2 3x2\n"
                                   "end\n"
                                   "frame 1\n"
                                   "flush\n");
    EXPECT_EQ(device.frame_text(1), "flush\n");
}

TEST(ScriptedDevice, ATestCompletesWhileAnotherOneIsPolled)
{
    ScriptedDevice device(
        {.latency = [](uint64_t test) { return Latency::after_polls(test == 0 ? 3 : 1); }});
    device.begin_frame(test::camera());
    const Ticket slow = ask(device, {1});
    const Ticket fast = ask(device, {2});
    EXPECT_EQ(device.poll(slow).state, AnswerState::pending);
    EXPECT_EQ(device.poll(fast).state, AnswerState::ready) << "the later test overtakes";
    EXPECT_EQ(device.poll(slow).state, AnswerState::pending);
    EXPECT_EQ(device.poll(slow).state, AnswerState::ready);
}

TEST(ScriptedDevice, EqualLatenciesCompleteInOrder)
{
    ScriptedDevice device({.latency = [](uint64_t) { return Latency::after_polls(2); }});
    device.begin_frame(test::camera());
    const Ticket first = ask(device, {1});
    EXPECT_EQ(device.poll(first).state, AnswerState::pending);
    const Ticket second = ask(device, {2});
    EXPECT_EQ(device.poll(second).state, AnswerState::pending);
    EXPECT_EQ(device.poll(first).state, AnswerState::ready);
    EXPECT_EQ(device.poll(second).state, AnswerState::ready);
}

TEST(ScriptedDevice, WaitGetsAnAnswerThatPollNeverSees)
{
    ScriptedDevice device(
        {.boxes = visible_subjects({}), .latency = [](uint64_t) { return Latency::never(); }});
    device.begin_frame(test::camera());
    const Ticket ticket = ask(device, {1});
    for (int i = 0; i < 100; ++i) {
        ASSERT_EQ(device.poll(ticket).state, AnswerState::pending);
    }
    const Answer answer = device.wait(ticket);
    EXPECT_EQ(answer.state, AnswerState::ready);
    EXPECT_EQ(answer.samples, 0u);
}

TEST(ScriptedDevice, LostTestsReadAsVisibleFromPollAndFromWait)
{
    ScriptedDevice device(
        {.boxes = visible_subjects({}), .latency = [](uint64_t) { return Latency::lost(1); }});
    device.begin_frame(test::camera());
    const auto tickets = ask_batch(device, {{1}, {2}});
    EXPECT_EQ(device.poll(tickets[0]).state, AnswerState::pending);
    for (const Answer& answer : {device.poll(tickets[0]), device.wait(tickets[1])}) {
        EXPECT_EQ(answer.state, AnswerState::lost);
        EXPECT_EQ(answer.samples, Answer::kUnknownSamples);
    }
    EXPECT_EQ(device.outstanding(), 0u);
}

TEST(ScriptedDevice, LatencyInFramesEndsWithThatManyEndFrames)
{
    ScriptedDevice device({.latency = [](uint64_t) { return Latency::after_frames(2); }});
    device.begin_frame(test::camera());
    const Ticket ticket = ask(device, {1});
    device.end_frame();
    EXPECT_EQ(device.poll(ticket).state, AnswerState::pending);
    device.begin_frame(test::camera());
    device.end_frame();
    EXPECT_EQ(device.poll(ticket).state, AnswerState::ready);
}

TEST(ScriptedDevice, WithoutSameFrameResultsAnAnswerComesInTheNextFrameOrIsLost)
{
    ScriptedDevice device({.caps = {.name = "late", .same_frame_results = false, .methods = {}}});
    device.begin_frame(test::camera());
    const auto tickets = ask_batch(device, {{1}, {2}});
    EXPECT_EQ(device.poll(tickets[0]).state, AnswerState::pending);
    EXPECT_EQ(device.wait(tickets[1]).state, AnswerState::lost);
    device.end_frame();
    EXPECT_EQ(device.wait(tickets[0]).state, AnswerState::ready);
}

TEST(ScriptedDevice, ARecycledTicketCannotReadAnothersAnswer)
{
    ScriptedDevice device({.boxes = visible_subjects({NodeId{1u}})});
    device.begin_frame(test::camera());
    const Ticket spent = ask(device, {1});
    device.wait(spent);
    const Ticket hidden = ask(device, {2});
    ASSERT_EQ(hidden.index, spent.index) << "the case is one of a slot used again";
    EXPECT_EQ(device.poll(spent).state, AnswerState::lost);
    EXPECT_EQ(device.wait(spent).state, AnswerState::lost);
    EXPECT_EQ(device.wait(hidden).samples, 0u) << "asking the old ticket did not spend the new";
    EXPECT_EQ(device.poll(Ticket{}).state, AnswerState::lost);
}

TEST(ScriptedDevice, TestsBeyondTheLimitAreLost)
{
    ScriptedDevice device({.boxes = visible_subjects({}),
                           .caps = {.name = "small", .max_outstanding = 2, .methods = {}}});
    device.begin_frame(test::camera());
    const auto tickets = ask_batch(device, {{1}, {2}, {3}});
    EXPECT_EQ(device.wait(tickets[2]).state, AnswerState::lost);
    EXPECT_EQ(device.wait(tickets[0]).samples, 0u);
    EXPECT_EQ(device.wait(ask(device, {4})).samples, 0u) << "a spent ticket makes room";
}

TEST(ScriptedDevice, TheScriptCanSeeWhatWasDrawnBeforeTheTest)
{
    ScriptedDevice device;
    device.script().boxes = [&](std::span<const QueryBox>) {
        return device.items_drawn_this_frame().empty() ? 1u : 0u;
    };
    device.begin_frame(test::camera());
    const Ticket before = ask(device, {1});
    draw(device, {0});
    const Ticket after = ask(device, {1});
    EXPECT_EQ(device.wait(before).samples, 1u);
    EXPECT_EQ(device.wait(after).samples, 0u);
}

TEST(ScriptedDevice, OptionalVerbsFollowTheCaps)
{
    ScriptedDevice device;
    device.begin_frame(test::camera());
    std::array<float, 1> depth{0.5f};
    EXPECT_FALSE(device.read_depth({0, 0, 1, 1}, depth));
    EXPECT_EQ(depth[0], 0.5f);
    EXPECT_FALSE(device.draw_and_query(test::items({1}), DrawPass::shade).valid());
    EXPECT_EQ(device.items_drawn_this_frame().size(), 1u) << "it draws all the same";
    device.script().caps.read_depth = true;
    EXPECT_TRUE(device.read_depth({0, 0, 1, 1}, depth));
    EXPECT_EQ(depth[0], 1.0f);
}

} // namespace
} // namespace occlude
