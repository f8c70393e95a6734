// Tickets and answers of the OpenGL device, and reading its depth.
#include "backends/gl_fixture.h"

#include <occlude/core/rng.h>

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <array>

namespace occlude {
namespace {

class GlTicketsTest : public GlFixture {};
class GlDepthTest : public GlFixture {};

TEST_F(GlTicketsTest, DrawAndQueryCountsTheSamplesDrawn)
{
    const ItemId quad = scene->add_quad({-0.5f, -0.5f}, {0.5f, 0.5f}, 0.3f);
    const ItemId half = scene->add_quad({-0.5f, -0.5f}, {0.5f, 0.0f}, 0.1f);
    device->begin_frame(kFlatView);
    EXPECT_EQ(device->wait(device->draw_and_query({&half, 1}, DrawPass::shade)).samples,
              kMiddlePixels / 2);
    EXPECT_EQ(device->wait(device->draw_and_query({&quad, 1}, DrawPass::shade)).samples,
              kMiddlePixels / 2);
    const Answer nothing = device->wait(device->draw_and_query({}, DrawPass::shade));
    EXPECT_EQ(nothing.state, AnswerState::ready);
    EXPECT_EQ(nothing.samples, 0u);
    EXPECT_NE(scene->colors()[32 * 64 + 32], scene->colors()[0]);
    device->end_frame();
}

TEST_F(GlTicketsTest, PollNeverBlocksAndEndsReady)
{
    const ItemId wall = scene->add_quad(kLow, kHigh, 0.1f);
    device->begin_frame(kFlatView);
    draw(wall);
    const Ticket ticket = ask(kMiddle);
    device->flush();
    Answer answer = Answer::pending();
    for (int i = 0; i < 100'000'000 && answer.state == AnswerState::pending; ++i) {
        answer = device->poll(ticket);
        if (answer.state == AnswerState::pending) {
            EXPECT_EQ(answer.samples, Answer::kUnknownSamples);
        }
    }
    EXPECT_EQ(answer.state, AnswerState::ready);
    EXPECT_EQ(answer.samples, 0u);
    EXPECT_EQ(device->poll(ticket).state, AnswerState::lost) << "spent";
    device->end_frame();
}

TEST_F(GlTicketsTest, SpentForeignAndInventedTicketsAreLost)
{
    device->begin_frame(kFlatView);
    const Ticket ticket = ask(kMiddle);
    EXPECT_EQ(device->wait(ticket).state, AnswerState::ready);
    EXPECT_EQ(device->wait(ticket).state, AnswerState::lost);
    EXPECT_EQ(device->wait(Ticket{}).state, AnswerState::lost);
    EXPECT_EQ(device->wait(Ticket{ticket.index, ticket.generation + 1}).state, AnswerState::lost);
    EXPECT_EQ(device->wait(Ticket{12345, 1}).state, AnswerState::lost);
    device->end_frame();
}

TEST_F(GlTicketsTest, ReusedQueryObjectsNeverAnswerForTheirFormerOwner)
{
    make_device({.max_outstanding = 2});
    const ItemId wall = scene->add_quad(kLow, kHigh, 0.1f);
    device->begin_frame(kFlatView);
    const Ticket visible = ask(kMiddle);
    EXPECT_EQ(device->wait(visible).samples, 2 * kMiddlePixels);
    draw(wall);
    for (int i = 0; i < 7; ++i) {
        const Ticket hidden = ask(kMiddle);
        EXPECT_TRUE(hidden.valid());
        EXPECT_EQ(device->wait(visible).state, AnswerState::lost);
        EXPECT_EQ(device->wait(hidden).samples, 0u);
    }
    device->end_frame();
}

TEST_F(GlTicketsTest, TestsBeyondMaxOutstandingAreLostAndTheOthersAreNot)
{
    make_device({.max_outstanding = 3});
    const std::vector<QueryBox> boxes(5, QueryBox{kMiddle, nullptr, {}});
    const std::array<uint32_t, 5> ends{1, 2, 3, 4, 5};
    std::array<Ticket, 5> tickets;
    device->begin_frame(kFlatView);
    device->query({boxes, ends, TestMethod::queries}, tickets);
    const ItemId quad = scene->add_quad(kLow, kHigh, 0.9f);
    EXPECT_FALSE(device->draw_and_query({&quad, 1}, DrawPass::shade).valid());
    EXPECT_NE(scene->colors()[0], 0xff000000u) << "drawn all the same";
    for (size_t i = 0; i < 5; ++i) {
        const Answer answer = device->wait(tickets[i]);
        EXPECT_EQ(answer.state, i < 3 ? AnswerState::ready : AnswerState::lost) << i;
        EXPECT_GT(answer.samples, 0u) << "never hidden";
    }
    EXPECT_EQ(count(kMiddle), 2 * kMiddlePixels) << "room again";
    device->end_frame();
}

TEST_F(GlTicketsTest, AnswersMayBeReadInAnyOrder)
{
    const std::array<float, 4> sizes{0.25f, 0.5f, 0.75f, 1.0f};
    std::vector<Ticket> tickets;
    device->begin_frame(kFlatView);
    for (const float size : sizes) {
        tickets.push_back(ask({{-size, -size, 0.2f}, {size, size, 0.4f}}));
    }
    for (const size_t i : {2u, 0u, 3u, 1u}) {
        const auto side = static_cast<uint64_t>(64.0f * sizes[i]);
        EXPECT_EQ(device->wait(tickets[i]).samples, 2 * side * side);
    }
    device->end_frame();
}

TEST_F(GlTicketsTest, UnreadTicketsStayGoodInLaterFrames)
{
    device->begin_frame(kFlatView);
    const Ticket early = ask(kMiddle);
    device->end_frame();
    const ItemId wall = scene->add_quad(kLow, kHigh, 0.1f);
    for (int frame = 0; frame < 100; ++frame) {
        device->begin_frame(kFlatView);
        draw(wall);
        EXPECT_EQ(count(kMiddle), 0u);
        device->end_frame();
    }
    EXPECT_EQ(device->wait(early).samples, 2 * kMiddlePixels);
}

TEST_F(GlTicketsTest, AbandonedTicketsGiveTheirRoomBackAndAreLost)
{
    make_device({.max_outstanding = 2});
    device->begin_frame(kFlatView);
    const Ticket abandoned = ask(kMiddle);
    ask(kMiddle);
    EXPECT_FALSE(ask(kMiddle).valid());
    device->end_frame();
    glFinish();
    for (int frame = 0; frame < 70; ++frame) {
        device->begin_frame(kFlatView);
        device->end_frame();
    }
    device->begin_frame(kFlatView);
    EXPECT_EQ(count(kMiddle), 2 * kMiddlePixels);
    EXPECT_EQ(device->wait(abandoned).state, AnswerState::lost);
    device->end_frame();
}

TEST_F(GlTicketsTest, UnboundedBoxesAreLostNotHidden)
{
    const ItemId wall = scene->add_quad(kLow, kHigh, -0.9f);
    device->begin_frame(kFlatView);
    draw(wall);
    EXPECT_EQ(device->wait(ask(Aabb::everything())).state, AnswerState::lost);
    EXPECT_EQ(device->wait(ask(Aabb::empty())).state, AnswerState::lost);
    EXPECT_EQ(count(kMiddle), 0u);
    device->end_frame();
}

TEST_F(GlTicketsTest, ManyBatchesWrapTheUploadRing)
{
    const ItemId wall = scene->add_quad(kLow, {0.0f, 1.0f}, 0.1f);
    const Aabb hidden{{-0.75f, -0.25f, 0.2f}, {-0.25f, 0.25f, 0.4f}};
    const Aabb seen{{0.25f, -0.25f, 0.2f}, {0.75f, 0.25f, 0.4f}};
    device->begin_frame(kFlatView);
    draw(wall);
    for (const size_t box_count : {3000u, 2000u, 9001u, 1u}) {
        std::vector<QueryBox> boxes(box_count, QueryBox{hidden, nullptr, {}});
        boxes.push_back({seen, nullptr, {}});
        const std::array<uint32_t, 2> ends{static_cast<uint32_t>(box_count),
                                           static_cast<uint32_t>(box_count + 1)};
        std::array<Ticket, 2> tickets;
        device->query({boxes, ends, TestMethod::queries}, tickets);
        EXPECT_EQ(device->wait(tickets[0]).samples, 0u);
        EXPECT_EQ(device->wait(tickets[1]).samples, 2u * 16u * 16u);
    }
    device->end_frame();
}

TEST_F(GlTicketsTest, OldestVersionAnswersTheSame)
{
    make_device({.max_gl_version = 33});
    const ItemId wall = scene->add_quad(kLow, {0.0f, 1.0f}, 0.1f);
    const std::array<QueryBox, 3> boxes{
        {{kLeft, nullptr, {}}, {kLeft, nullptr, {}}, {kRight, nullptr, {}}}};
    const std::array<uint32_t, 2> ends{1, 3};
    std::array<Ticket, 2> tickets;
    device->begin_frame(kFlatView);
    draw(wall);
    for (int repeat = 0; repeat < 3; ++repeat) {
        device->query({boxes, ends, TestMethod::queries}, tickets);
        EXPECT_EQ(device->wait(tickets[0]).samples, 0u);
        EXPECT_EQ(device->wait(tickets[1]).samples, 2u * 16u * 16u);
    }
    device->end_frame();
}

TEST_F(GlDepthTest, ReadDepthGivesTheRectangleRowByRowFromTheBottom)
{
    const ItemId quad = scene->add_quad({-1.0f, -1.0f}, {0.0f, 0.0f}, 0.0f); // lower left quarter
    device->begin_frame(kFlatView);
    draw(quad);
    std::array<float, 6> out{};
    ASSERT_TRUE(device->read_depth({30, 31, 3, 2}, out));
    EXPECT_EQ(out, (std::array<float, 6>{0.5f, 0.5f, 1.0f, 1.0f, 1.0f, 1.0f}));
    EXPECT_EQ(count(kMiddle), 2 * kMiddlePixels - kMiddlePixels / 2) << "tests go on after it";
    GLint viewport[4];
    glGetIntegerv(GL_VIEWPORT, viewport);
    EXPECT_EQ(viewport[2], 64);
    device->end_frame();
}

TEST_F(GlDepthTest, ReadDepthOfMultisampledPixelsIsTheFarthestSample)
{
    for (const GLenum format : {GLenum{GL_DEPTH_COMPONENT32F}, GLenum{GL_DEPTH24_STENCIL8}}) {
        make_scene({40, 20}, 4, format);
        const View view = View::from_clip(glm::mat4{1.0f}, {40, 20});
        const float pixel = 2.0f / 40.0f;
        // Covers columns 0..19 and half of column 20.
        const ItemId quad = scene->add_quad(kLow, {0.5f * pixel, 1.0f}, 0.0f);
        device->begin_frame(view);
        draw(quad);
        std::array<float, 6> out{};
        ASSERT_TRUE(device->read_depth({19, 7, 3, 2}, out));
        EXPECT_NEAR(out[0], 0.5f, 1e-6f);
        EXPECT_EQ(out[1], 1.0f) << "half covered: the farthest sample is the background";
        EXPECT_EQ(out[2], 1.0f);
        EXPECT_NEAR(out[3], 0.5f, 1e-6f);
        device->end_frame();
        EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    }
}

TEST_F(GlDepthTest, ReadDepthOfMultisampledReversedDepthIsTheFarthestSample)
{
    make_scene(kSize, 4);
    const View view = View::from_clip(glm::mat4{1.0f}, kSize,
                                      {DepthRange::zero_to_one, DepthOrder::near_is_large});
    const ItemId quad = scene->add_quad(kLow, {1.0f / 64.0f, 1.0f}, 0.75f);
    device->begin_frame(view);
    draw(quad);
    std::array<float, 3> out{};
    ASSERT_TRUE(device->read_depth({31, 5, 3, 1}, out));
    EXPECT_EQ(out, (std::array<float, 3>{0.25f, 1.0f, 1.0f}));
    device->end_frame();
}

TEST_F(GlTicketsTest, WarmUpDrawsNothingAndLeavesNoTicketBehind)
{
    make_device({.max_outstanding = 1});
    const ItemId wall = scene->add_quad(kLow, kHigh, 0.1f);
    device->begin_frame(kFlatView);
    device->warm_up();
    EXPECT_EQ(std::ranges::count(depths(), 1.0f), 64 * 64);
    draw(wall);
    EXPECT_EQ(count(kMiddle), 0u);
    device->end_frame();
}

} // namespace
} // namespace occlude
