#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

#include <array>

namespace occlude {
namespace {

QueryBox box_of(uint32_t subject)
{
    return {Aabb{glm::vec3{-1.0f}, glm::vec3{1.0f}}, nullptr, NodeId{subject}};
}

Ticket ask(QueryDevice& device, std::vector<uint32_t> subjects)
{
    std::vector<QueryBox> boxes;
    for (const uint32_t subject : subjects) {
        boxes.push_back(box_of(subject));
    }
    const std::array ends{static_cast<uint32_t>(boxes.size())};
    Ticket ticket;
    device.query({boxes, ends}, std::span{&ticket, 1});
    return ticket;
}

TEST(ScriptedDevice, TraceReadsAsTheVerbsInCallOrder)
{
    ScriptedDevice device({.boxes = visible_subjects({NodeId{7u}}, 50),
                           .latency = [](uint64_t) { return Latency::after_polls(1); }});
    device.begin_frame({});
    const std::array items{ItemId{3u}, ItemId{4u}};
    device.draw(items, DrawPass::shade);
    const std::array boxes{box_of(7), box_of(8), box_of(9)};
    const std::array<uint32_t, 2> ends{1, 3};
    std::array<Ticket, 2> tickets;
    device.query({boxes, ends}, tickets);
    device.flush();
    device.poll(tickets[0]);
    device.poll(tickets[0]);
    device.wait(tickets[1]);
    device.wait(tickets[1]);
    device.end_frame();
    EXPECT_EQ(device.trace_text(), "frame 0\n"
                                   "draw 3 4\n"
                                   "query [7] [8 9]\n"
                                   "flush\n"
                                   "poll 7 pending\n"
                                   "poll 7 -> 50\n"
                                   "wait 8 9 -> 0\n"
                                   "wait ? -> lost\n"
                                   "end\n");
    EXPECT_EQ(device.frame_text(0).find("frame"), std::string::npos);
}

TEST(ScriptedDevice, ATestCompletesWhileAnotherOneIsPolled)
{
    ScriptedDevice device(
        {.latency = [](uint64_t test) { return Latency::after_polls(test == 0 ? 3 : 1); }});
    device.begin_frame({});
    const Ticket slow = ask(device, {1});
    const Ticket fast = ask(device, {2});
    EXPECT_EQ(device.poll(slow).state, AnswerState::pending);
    EXPECT_EQ(device.poll(fast).state, AnswerState::ready);
    EXPECT_EQ(device.poll(slow).state, AnswerState::pending);
    EXPECT_EQ(device.poll(slow).state, AnswerState::ready);
}

} // namespace
} // namespace occlude
