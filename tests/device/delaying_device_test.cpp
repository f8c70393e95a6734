#include "device_test_helpers.h"

#include <occlude/device/delaying_device.h>
#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

namespace occlude {
namespace {

using test::ask;

TEST(DelayingDevice, HoldsAnswersBackForTheGivenPollsWithoutAskingTheDevice)
{
    ScriptedDevice scripted({.boxes = visible_subjects({})});
    DelayingDevice device(scripted, {.min_polls = 2, .max_polls = 2});
    device.begin_frame(test::camera());
    const Ticket ticket = ask(device, {1});
    EXPECT_EQ(device.poll(ticket).state, AnswerState::pending);
    EXPECT_EQ(device.poll(ticket).state, AnswerState::pending);
    EXPECT_EQ(scripted.frame_text(0), "query [1]\n");
    const Answer answer = device.poll(ticket);
    EXPECT_EQ(answer.state, AnswerState::ready);
    EXPECT_EQ(answer.samples, 0u);
    EXPECT_EQ(device.poll(ticket).state, AnswerState::lost) << "it is spent";
}

TEST(DelayingDevice, HoldsAnswersBackForTheGivenFrames)
{
    ScriptedDevice scripted;
    DelayingDevice device(scripted, {.min_frames = 1, .max_frames = 1});
    device.begin_frame(test::camera());
    const Ticket ticket = ask(device, {1});
    EXPECT_EQ(device.poll(ticket).state, AnswerState::pending);
    device.end_frame();
    EXPECT_EQ(device.poll(ticket).state, AnswerState::ready);
}

TEST(DelayingDevice, WaitDoesNotWaitForTheDelay)
{
    ScriptedDevice scripted({.boxes = visible_subjects({})});
    DelayingDevice device(scripted, {.min_polls = 100, .max_polls = 100});
    device.begin_frame(test::camera());
    EXPECT_EQ(device.wait(ask(device, {1})).samples, 0u);
}

TEST(DelayingDevice, LosesEveryNthTestAndFreesItOnTheDevice)
{
    ScriptedDevice scripted({.boxes = visible_subjects({})});
    DelayingDevice device(scripted, {.lose_every = 3});
    device.begin_frame(test::camera());
    std::string fates;
    for (uint32_t i = 0; i < 9; ++i) {
        const Ticket ticket = ask(device, {i});
        const Answer answer = i % 2 == 0 ? device.poll(ticket) : device.wait(ticket);
        fates += answer.state == AnswerState::lost ? 'x' : '.';
        EXPECT_TRUE(answer.state == AnswerState::ready || answer.samples > 0);
    }
    EXPECT_EQ(fates, "..x..x..x");
    EXPECT_EQ(scripted.outstanding(), 0u);
}

std::string pattern_of(uint64_t seed)
{
    ScriptedDevice scripted;
    DelayingDevice device(scripted, {.seed = seed, .min_polls = 1, .max_polls = 6});
    device.begin_frame(test::camera());
    std::string pattern;
    for (uint32_t i = 0; i < 200; ++i) {
        const Ticket ticket = ask(device, {i});
        int polls = 0;
        while (device.poll(ticket).state == AnswerState::pending) {
            ++polls;
        }
        pattern += std::to_string(polls);
    }
    return pattern;
}

TEST(DelayingDevice, DelaysFollowTheSeedAndStayInTheirRange)
{
    const std::string pattern = pattern_of(7);
    EXPECT_EQ(pattern, pattern_of(7));
    EXPECT_NE(pattern, pattern_of(8));
    EXPECT_EQ(pattern.find_first_not_of("123456"), std::string::npos);
    EXPECT_NE(pattern.find('1'), std::string::npos);
    EXPECT_NE(pattern.find('6'), std::string::npos);
}

TEST(DelayingDevice, ARecycledTicketCannotReadAnothersAnswer)
{
    ScriptedDevice scripted({.boxes = visible_subjects({NodeId{1u}})});
    DelayingDevice device(scripted, {});
    device.begin_frame(test::camera());
    const Ticket spent = ask(device, {1});
    device.wait(spent);
    const Ticket hidden = ask(device, {2});
    ASSERT_EQ(hidden.index, spent.index);
    EXPECT_EQ(device.wait(spent).state, AnswerState::lost);
    EXPECT_EQ(device.wait(hidden).samples, 0u);
}

TEST(DelayingDevice, ATestTheDeviceRefusedStaysLost)
{
    ScriptedDevice scripted({.caps = {.name = "none", .max_outstanding = 0, .methods = {}}});
    DelayingDevice device(scripted, {.min_polls = 5, .max_polls = 5});
    device.begin_frame(test::camera());
    EXPECT_EQ(device.poll(ask(device, {1})).state, AnswerState::lost);
}

} // namespace
} // namespace occlude
