#include "device_test_helpers.h"
#include "validating_bench.h"

#include <occlude/device/counting_device.h>
#include <occlude/device/delaying_device.h>
#include <occlude/device/recording_device.h>
#include <occlude/device/replay_device.h>
#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

#include <limits>

namespace occlude {
namespace {

using test::ask;
using test::ask_batch;
using test::Bench;
using test::box_of;
using test::draw;

/// Gives the answers that a test sets, however wrong.
struct WrongDevice : QueryDevice {
    DeviceCaps wrong_caps{.name = "wrong", .methods = {}};
    Ticket next_ticket{0, 1};
    Answer next_answer = Answer::ready(1);

    const DeviceCaps& caps() const override { return wrong_caps; }
    void begin_frame(const View&) override {}
    void draw(std::span<const ItemId>, DrawPass) override {}
    void query(const QueryBatch&, std::span<Ticket> tickets) override
    {
        std::fill(tickets.begin(), tickets.end(), next_ticket);
    }
    void flush() override {}
    Answer poll(Ticket) override { return next_answer; }
    Answer wait(Ticket) override { return next_answer; }
    bool read_depth(const PixelRect&, std::span<float> out) override
    {
        std::fill(out.begin(), out.end(), 2.0f);
        return true;
    }
    void end_frame() override {}
};

TEST(ValidatingDevice, ARightCallerOnARightDeviceBreaksNothing)
{
    ScriptedDevice scripted(
        {.latency = [](uint64_t) { return Latency::after_polls(1); },
         .caps = {.name = "scripted", .draw_and_query = true, .read_depth = true, .methods = {}}});
    Bench bench(scripted, ValidatingDevice::DepthChecks::around_batches);
    QueryDevice& device = bench.device;
    Ticket kept;
    for (int frame = 0; frame < 3; ++frame) {
        if (frame > 0) {
            ASSERT_EQ(device.poll(kept).state, AnswerState::ready) << "outside of a frame";
        }
        device.begin_frame(test::camera());
        draw(device, {0, 1}, DrawPass::depth_only);
        draw(device, {2});
        const auto tickets = ask_batch(device, {{1}, {2, 3}, {4}});
        device.flush();
        device.poll(tickets[0]);
        device.poll(tickets[0]);
        device.wait(tickets[1]);
        device.wait(device.draw_and_query(test::items({3}), DrawPass::shade));
        draw(device, {1, 0}, DrawPass::shade_equal);
        std::array<float, 4> depth{};
        device.read_depth({62, 62, 2, 2}, depth);
        kept = tickets[2];
        device.end_frame();
    }
    EXPECT_EQ(bench.broken(), "") << bench.messages;
}

TEST(ValidatingDevice, C1FramesDoNotNestAndVerbsComeInside)
{
    ScriptedDevice scripted;
    Bench bench(scripted);
    QueryDevice& device = bench.device;
    device.end_frame();
    EXPECT_EQ(bench.broken(), "C1 ");
    draw(device, {1});
    EXPECT_EQ(bench.broken(), "C1 ");
    device.flush();
    EXPECT_EQ(bench.broken(), "C1 ");
    device.draw_and_query(test::items({2}), DrawPass::shade);
    EXPECT_EQ(bench.broken(), "C1 ");
    device.begin_frame(test::camera());
    EXPECT_EQ(bench.broken(), "");
    device.begin_frame(test::camera());
    EXPECT_EQ(bench.broken(), "C1 ");
    device.end_frame();
    std::array<float, 1> depth{};
    device.read_depth({0, 0, 1, 1}, depth);
    EXPECT_EQ(bench.broken(), "C1 ");
    ask(device, {1});
    EXPECT_EQ(bench.broken(), "C1 ");
    device.poll(Ticket{});
    device.wait(Ticket{});
    EXPECT_EQ(bench.broken(), "");
}

TEST(ValidatingDevice, C5BoxesAreBoundedAndAwayFromTheNearPlane)
{
    ScriptedDevice scripted;
    Bench bench(scripted);
    bench.device.begin_frame(test::camera());
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const Aabb& wrong :
         {Aabb::empty(), Aabb::everything(), Aabb{glm::vec3{nan}, glm::vec3{1.0f}},
          Aabb{{-1.0f, -1.0f, -5.0f}, {1.0f, 1.0f, -0.5f}}}) {
        const QueryBox box{wrong, nullptr, NodeId{3u}};
        ask(bench.device, std::span{&box, 1});
        EXPECT_EQ(bench.broken(), "C5 ");
    }
    EXPECT_NE(bench.messages.find("node 3"), std::string::npos);
    const QueryBox beyond{Aabb{{-1.0f, -1.0f, -5.0f}, {1.0f, 1.0f, -1.1f}}, nullptr, NodeId{3u}};
    ask(bench.device, std::span{&beyond, 1});
    EXPECT_EQ(bench.broken(), "");
}

TEST(ValidatingDevice, C5TakesTheTransformOfABoxIntoAccount)
{
    ScriptedDevice scripted;
    Bench bench(scripted);
    bench.device.begin_frame(test::camera());
    const Aabb cube{glm::vec3{-0.5f}, glm::vec3{0.5f}}; // around the eye if it stays there
    const glm::mat4 away = glm::translate(glm::mat4{1.0f}, glm::vec3{0.0f, 0.0f, -10.0f});
    const QueryBox good{cube, &away, NodeId{1u}};
    ask(bench.device, std::span{&good, 1});
    EXPECT_EQ(bench.broken(), "");
    const glm::mat4 close = glm::translate(glm::mat4{1.0f}, glm::vec3{0.0f, 0.0f, -1.0f});
    const QueryBox bad{cube, &close, NodeId{1u}};
    ask(bench.device, std::span{&bad, 1});
    EXPECT_EQ(bench.broken(), "C5 ");

    // A long box turned by 45 degrees: its AABB reaches the near plane, the box itself does not.
    glm::mat4 turned = glm::translate(glm::mat4{1.0f}, glm::vec3{4.0f, 0.0f, -4.0f});
    turned = glm::rotate(turned, glm::radians(-45.0f), glm::vec3{0.0f, 1.0f, 0.0f});
    const Aabb wall{{-5.0f, -0.1f, -0.1f}, {5.0f, 0.1f, 0.1f}};
    ASSERT_TRUE(test::camera().touches_near(transformed(turned, wall)));
    const QueryBox tight{wall, &turned, NodeId{1u}};
    ask(bench.device, std::span{&tight, 1});
    EXPECT_EQ(bench.broken(), "") << bench.messages;
}

TEST(ValidatingDevice, C5NoBoxMayBeTestedInADegenerateView)
{
    ScriptedDevice scripted;
    Bench bench(scripted);
    bench.device.begin_frame(View::from_clip(glm::mat4{0.0f}, {64, 64}));
    ask(bench.device, {1});
    EXPECT_EQ(bench.broken(), "C5 ");
}

TEST(ValidatingDevice, C6TestsHaveBoxesAndEndsAscendToTheLast)
{
    ScriptedDevice scripted;
    Bench bench(scripted);
    bench.device.begin_frame(test::camera());
    const std::array boxes{box_of(1), box_of(2), box_of(3)};
    for (const std::array<uint32_t, 2> ends :
         {std::array<uint32_t, 2>{0, 3}, {3, 3}, {2, 1}, {1, 2}, {1, 4}}) {
        std::array<Ticket, 2> tickets{Ticket{9, 9}, Ticket{9, 9}};
        bench.device.query({boxes, ends}, tickets);
        EXPECT_EQ(bench.broken(), "C6 ") << ends[0] << " " << ends[1];
        EXPECT_FALSE(tickets[0].valid());
        EXPECT_EQ(bench.device.wait(tickets[1]).state, AnswerState::lost);
    }
    EXPECT_EQ(scripted.outstanding(), 0u) << "a broken batch does not reach the device";
    std::array<Ticket, 2> tickets;
    const std::array<uint32_t, 2> ends{1, 3};
    bench.device.query({boxes, ends}, tickets);
    EXPECT_EQ(bench.broken(), "");
}

TEST(ValidatingDevice, C7SpentAndForeignTicketsOfTheCallerAreReported)
{
    ScriptedDevice scripted;
    Bench bench(scripted);
    bench.device.begin_frame(test::camera());
    const Ticket ticket = ask(bench.device, {1});
    bench.device.wait(ticket);
    EXPECT_EQ(bench.broken(), "");
    EXPECT_EQ(bench.device.poll(ticket).state, AnswerState::lost);
    EXPECT_EQ(bench.broken(), "C7 ");
    EXPECT_EQ(bench.device.wait(Ticket{77, 3}).state, AnswerState::lost);
    EXPECT_EQ(bench.broken(), "C7 ");
    EXPECT_EQ(bench.device.wait(Ticket{}).state, AnswerState::lost);
    EXPECT_EQ(bench.broken(), "") << "an invalid ticket is what a device without the verb gives";
}

TEST(ValidatingDevice, C7ADeviceMayNotAnswerOrReissueATicket)
{
    WrongDevice wrong;
    Bench bench(wrong);
    bench.device.begin_frame(test::camera());
    bench.device.wait(Ticket{});
    EXPECT_EQ(bench.broken(), "C7 ") << "it answered an invalid ticket";
    const Ticket ticket = ask(bench.device, {1});
    EXPECT_EQ(bench.broken(), "");
    ask(bench.device, {2});
    EXPECT_EQ(bench.broken(), "C7 ") << "it gave the same ticket to two tests";
    bench.device.wait(ticket);
    EXPECT_EQ(bench.broken(), "");
    ask(bench.device, {3});
    EXPECT_EQ(bench.broken(), "C7 ") << "it gave a slot out again without a new generation";
    bench.device.wait(ticket);
    wrong.next_ticket = {0, 2};
    ask(bench.device, {4});
    EXPECT_EQ(bench.broken(), "") << "with a new generation it is a new ticket";
}

TEST(ValidatingDevice, C8UnknownAnswersReadAsVisible)
{
    WrongDevice wrong;
    Bench bench(wrong);
    bench.device.begin_frame(test::camera());
    const auto answer = [&](Answer next) {
        ++wrong.next_ticket.generation;
        wrong.next_answer = next;
        bench.device.poll(ask(bench.device, {1}));
        return bench.broken();
    };
    EXPECT_EQ(answer({AnswerState::lost, 0}), "C8 ");
    EXPECT_EQ(answer({AnswerState::ready, Answer::kUnknownSamples}), "C8 ");
    EXPECT_EQ(answer(Answer::lost()), "");
    EXPECT_EQ(answer(Answer::ready(0)), "");
    EXPECT_EQ(answer({AnswerState::pending, 0}), "C8 ");
}

TEST(ValidatingDevice, C9WaitNeverAnswersPending)
{
    WrongDevice wrong;
    Bench bench(wrong);
    bench.device.begin_frame(test::camera());
    const Ticket ticket = ask(bench.device, {1});
    wrong.next_answer = Answer::pending();
    bench.device.poll(ticket);
    EXPECT_EQ(bench.broken(), "");
    bench.device.wait(ticket);
    EXPECT_EQ(bench.broken(), "C9 ");
}

TEST(ValidatingDevice, C10ItemsAreDrawnOncePerFrameAndPass)
{
    ScriptedDevice scripted;
    Bench bench(scripted);
    bench.device.begin_frame(test::camera());
    draw(bench.device, {1, 2, 1});
    EXPECT_EQ(bench.broken(), "C10 ");
    bench.device.draw_and_query(test::items({2}), DrawPass::shade);
    EXPECT_EQ(bench.broken(), "C10 ");
    bench.device.end_frame();
    bench.device.begin_frame(test::camera());
    draw(bench.device, {1, 2});
    EXPECT_EQ(bench.broken(), "");
}

TEST(ValidatingDevice, C11TheLimitOfUnspentTicketsHolds)
{
    ScriptedDevice scripted({.caps = {.name = "small", .max_outstanding = 2, .methods = {}}});
    Bench bench(scripted);
    bench.device.begin_frame(test::camera());
    const auto tickets = ask_batch(bench.device, {{1}, {2}});
    EXPECT_EQ(bench.broken(), "");
    ask(bench.device, {3});
    EXPECT_EQ(bench.broken(), "C11 ");
    bench.device.wait(tickets[0]);
    ask(bench.device, {3});
    EXPECT_EQ(bench.broken(), "");
}

TEST(ValidatingDevice, ABatchNamesAMethodThatThereIs)
{
    ScriptedDevice scripted; // has queries alone
    Bench bench(scripted);
    bench.device.begin_frame(test::camera());
    const QueryBox box = box_of(1);
    const uint32_t end = 1;
    Ticket ticket;
    for (const TestMethod method : {TestMethod::automatic, TestMethod::queries}) {
        bench.device.query({{&box, 1}, {&end, 1}, method}, {&ticket, 1});
        EXPECT_EQ(bench.broken(), "");
    }
    bench.device.query({{&box, 1}, {&end, 1}, TestMethod::raster}, {&ticket, 1});
    EXPECT_EQ(bench.broken(), "methods ");
}

TEST(ValidatingDevice, C12TicketsOfEarlierFramesStayGood)
{
    WrongDevice wrong;
    Bench bench(wrong);
    bench.device.begin_frame(test::camera());
    const Ticket ticket = ask(bench.device, {1});
    bench.device.end_frame();
    bench.device.begin_frame(test::camera());
    ask(bench.device, {2});
    EXPECT_EQ(bench.broken(), "C12 ") << "the device recycled it although it is unspent";
    bench.device.wait(ticket);
    EXPECT_EQ(bench.broken(), "");
}

TEST(ValidatingDevice, DepthPassesAndShadingComeInPairs)
{
    ScriptedDevice scripted;
    Bench bench(scripted);
    bench.device.begin_frame(test::camera());
    draw(bench.device, {1}, DrawPass::shade_equal);
    EXPECT_EQ(bench.broken(), "passes ");
    draw(bench.device, {4, 2, 3}, DrawPass::depth_only);
    draw(bench.device, {3}, DrawPass::shade_equal);
    EXPECT_EQ(bench.broken(), "");
    bench.messages.clear();
    bench.device.end_frame();
    EXPECT_EQ(bench.broken(), "passes passes ");
    EXPECT_EQ(bench.messages, "item 2 was drawn depth_only and never shaded with shade_equal\n"
                              "item 4 was drawn depth_only and never shaded with shade_equal\n");
}

TEST(ValidatingDevice, PreconditionsOfTheVerbsAreReported)
{
    WrongDevice wrong;
    Bench bench(wrong);
    bench.device.begin_frame(test::camera());
    const QueryBox box = box_of(1);
    const uint32_t end = 1;
    std::array<Ticket, 2> tickets;
    bench.device.query({{&box, 1}, {&end, 1}}, tickets);
    EXPECT_EQ(bench.broken(), "precondition ");
    const ItemId invalid;
    bench.device.draw({&invalid, 1}, DrawPass::shade);
    EXPECT_EQ(bench.broken(), "precondition ");
    std::array<float, 4> depth{};
    for (const PixelRect& rect : {PixelRect{-1, 0, 2, 2}, PixelRect{63, 0, 2, 2},
                                  PixelRect{0, 63, 2, 2}, PixelRect{0, 0, -2, -2}}) {
        EXPECT_FALSE(bench.device.read_depth(rect, depth));
        EXPECT_EQ(bench.broken(), "precondition ");
    }
    EXPECT_FALSE(bench.device.read_depth({0, 0, 3, 1}, depth));
    EXPECT_EQ(bench.broken(), "precondition ");
    EXPECT_TRUE(bench.device.read_depth({0, 0, 2, 2}, depth));
    EXPECT_EQ(bench.broken(), "precondition ") << "depth of 2";
}

TEST(ValidatingDevice, TheDefaultHandlerIsTheAssertHandler)
{
    std::string seen;
    const AssertHandler before = set_assert_handler(
        [&](std::string_view rule, std::string_view, std::string_view, int) { seen += rule; });
    ScriptedDevice scripted;
    ValidatingDevice device(scripted);
    device.end_frame();
    set_assert_handler(before);
    EXPECT_EQ(seen, "C1");
}

TEST(ValidatingDevice, TheOtherDevicesObeyTheContract)
{
    ScriptedDevice scripted(
        {.latency =
             [](uint64_t test) {
                 return test % 5 == 0 ? Latency::lost(2)
                                      : Latency::after_polls(static_cast<uint32_t>(test % 3));
             },
         .caps = {
             .name = "scripted", .draw_and_query = true, .max_outstanding = 64, .methods = {}}});
    CountingDevice counting(scripted);
    DelayingDevice delaying(counting, {.seed = 3, .max_polls = 4, .lose_every = 7});
    RecordingDevice recording(delaying);
    const auto run = [](QueryDevice& device) {
        Bench bench(device);
        for (uint32_t frame = 0; frame < 20; ++frame) {
            bench.device.begin_frame(test::camera());
            auto tickets = ask_batch(bench.device, {{1}, {2, 3}, {4}});
            tickets.push_back(bench.device.draw_and_query(test::items({frame}), DrawPass::shade));
            for (size_t i = 0; i < tickets.size(); ++i) {
                if ((frame + i) % 2 == 0) {
                    bench.device.wait(tickets[i]);
                    continue;
                }
                while (bench.device.poll(tickets[i]).state == AnswerState::pending) {
                }
            }
            bench.device.end_frame();
        }
        return bench.broken();
    };
    EXPECT_EQ(run(recording), "");
    EXPECT_EQ(counting.total().queries, 80u);
    EXPECT_EQ(scripted.outstanding(), 0u);
    ReplayDevice replay(recording.recording());
    EXPECT_EQ(run(replay), "");
    EXPECT_TRUE(replay.complete()) << replay.mismatch();
}

} // namespace
} // namespace occlude
