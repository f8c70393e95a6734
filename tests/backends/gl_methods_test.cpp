// The test methods `raster` and `pyramid` of the OpenGL device. They answer 0, or 1 for "some".
// They never answer 0 where queries see a sample, and they handle tickets as queries do.
#include "backends/gl_fixture.h"

#include <occlude/core/rng.h>

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <array>

namespace occlude {
namespace {

class GlMethodsTest : public GlFixture, public testing::WithParamInterface<TestMethod> {
protected:
    void SetUp() override
    {
        GlFixture::SetUp();
        use();
    }

    void use()
    {
        const auto used = device->use_method(GetParam());
        ASSERT_TRUE(used) << used.error().message;
    }

    bool pyramid() const { return GetParam() == TestMethod::pyramid; }
};

INSTANTIATE_TEST_SUITE_P(Each, GlMethodsTest,
                         testing::Values(TestMethod::raster, TestMethod::pyramid),
                         [](const auto& info) {
                             return info.param == TestMethod::raster ? "raster" : "pyramid";
                         });

TEST_P(GlMethodsTest, CapsNameTheDefaultFirstAndThatItDoesNotCount)
{
    EXPECT_EQ(device->caps().methods.front().method, GetParam());
    EXPECT_FALSE(device->caps().exact_counts);
    EXPECT_TRUE(device->use_method(TestMethod::automatic));
    EXPECT_EQ(device->caps().methods.front().method, TestMethod::queries);
    EXPECT_TRUE(device->caps().exact_counts);
}

TEST_P(GlMethodsTest, ATestIsTheUnionOfItsBoxesAndTestsOfABatchAreSeparate)
{
    const ItemId wall = scene->add_quad(kLow, {0.0f, 1.0f}, 0.1f); // hides the left half
    std::array<Ticket, 3> tickets;
    device->begin_frame(kFlatView);
    draw(wall);
    device->query({kUnions.boxes, kUnions.ends}, tickets);
    device->flush();
    for (const size_t test : {1u, 2u, 0u}) {
        EXPECT_EQ(device->wait(tickets[test]).samples, test == 1 ? 1u : 0u);
    }
    device->end_frame();
}

TEST_P(GlMethodsTest, TestSeesOnlyDrawsBeforeItAndTheClearOfTheNextFrame)
{
    const ItemId wall = scene->add_quad(kLow, kHigh, 0.1f);
    for (int frame = 0; frame < 3; ++frame) {
        device->begin_frame(kFlatView);
        const Ticket before = ask(kMiddle);
        draw(wall);
        const Ticket after = ask(kMiddle);
        const Ticket again = ask(kRight);
        device->flush();
        EXPECT_EQ(device->wait(before).samples, 1u);
        EXPECT_EQ(device->wait(after).samples, 0u);
        EXPECT_EQ(device->wait(again).samples, 0u);
        device->end_frame();
    }
}

TEST_P(GlMethodsTest, DrawAndQueryIsADrawToo)
{
    const ItemId wall = scene->add_quad(kLow, kHigh, 0.1f);
    device->begin_frame(kFlatView);
    EXPECT_EQ(count(kMiddle), 1u);
    EXPECT_EQ(device->wait(device->draw_and_query({&wall, 1}, DrawPass::shade)).samples, 64u * 64u);
    EXPECT_EQ(count(kMiddle), 0u);
    device->end_frame();
}

TEST_P(GlMethodsTest, TestsWriteNeitherColourNorDepth)
{
    const ItemId quad = scene->add_quad({-0.3f, -0.9f}, {0.9f, 0.2f}, 0.3f);
    device->begin_frame(kFlatView);
    draw(quad);
    const std::vector<uint32_t> colors_before = scene->colors();
    expect_nothing_written_by([&] { EXPECT_EQ(count(kMiddle), 1u); });
    draw(quad); // state is given back
    EXPECT_EQ(scene->colors(), colors_before);
    device->end_frame();
}

TEST_P(GlMethodsTest, MethodsMayBeMixedInOneFrame)
{
    const ItemId wall = scene->add_quad(kLow, {0.0f, 1.0f}, 0.1f);
    const std::array<QueryBox, 2> boxes{{{kLeft, nullptr, {}}, {kRight, nullptr, {}}}};
    const std::array<uint32_t, 2> ends{1, 2};
    device->begin_frame(kFlatView);
    draw(wall);
    std::vector<std::array<Ticket, 2>> batches(6);
    const TestMethod methods[] = {TestMethod::raster, TestMethod::queries, TestMethod::pyramid};
    for (size_t i = 0; i < batches.size(); ++i) {
        device->query({boxes, ends, methods[i % 3]}, batches[i]);
    }
    for (size_t i = 0; i < batches.size(); ++i) {
        EXPECT_EQ(device->wait(batches[i][0]).samples, 0u);
        EXPECT_EQ(device->wait(batches[i][1]).samples,
                  methods[i % 3] == TestMethod::queries ? 2u * 16u * 16u : 1u);
    }
    device->end_frame();
}

TEST_P(GlMethodsTest, PollNeverBlocksAndTicketsAreSpentOnce)
{
    const ItemId wall = scene->add_quad(kLow, kHigh, 0.1f);
    device->begin_frame(kFlatView);
    draw(wall);
    const Ticket ticket = ask(kMiddle);
    Answer answer = Answer::pending();
    for (int i = 0; i < 100'000'000 && answer.state == AnswerState::pending; ++i) {
        answer = device->poll(ticket);
    }
    EXPECT_EQ(answer.state, AnswerState::ready);
    EXPECT_EQ(answer.samples, 0u);
    EXPECT_EQ(device->wait(ticket).state, AnswerState::lost);
    device->end_frame();
}

TEST_P(GlMethodsTest, UnreadAnswersOutliveManyBatchesAndFrames)
{
    const ItemId wall = scene->add_quad(kLow, kHigh, 0.1f);
    device->begin_frame(kFlatView);
    const Ticket early = ask(kMiddle);
    device->end_frame();
    for (int frame = 0; frame < 40; ++frame) {
        device->begin_frame(kFlatView);
        draw(wall);
        EXPECT_EQ(count(kMiddle), 0u);
        device->end_frame();
    }
    EXPECT_EQ(device->wait(early).samples, 1u);
}

TEST_P(GlMethodsTest, TestsBeyondMaxOutstandingAreLostAndTheOthersAreNot)
{
    make_device({.max_outstanding = 3});
    use();
    const ItemId wall = scene->add_quad(kLow, {0.0f, 1.0f}, 0.1f);
    const std::array<QueryBox, 5> boxes{{{kLeft, nullptr, {}},
                                         {kRight, nullptr, {}},
                                         {kLeft, nullptr, {}},
                                         {kRight, nullptr, {}},
                                         {kLeft, nullptr, {}}}};
    const std::array<uint32_t, 5> ends{1, 2, 3, 4, 5};
    std::array<Ticket, 5> tickets;
    device->begin_frame(kFlatView);
    draw(wall);
    device->query({boxes, ends}, tickets);
    for (size_t i = 0; i < 5; ++i) {
        const Answer answer = device->wait(tickets[i]);
        EXPECT_EQ(answer.state, i < 3 ? AnswerState::ready : AnswerState::lost) << i;
        EXPECT_EQ(answer.samples == 0, i == 0 || i == 2) << i;
    }
    EXPECT_EQ(count(kLeft), 0u) << "room again";
    device->end_frame();
}

TEST_P(GlMethodsTest, UnboundedBoxesAreLostAndOthersOfTheBatchAreNot)
{
    const ItemId wall = scene->add_quad(kLow, kHigh, 0.1f);
    const std::array<QueryBox, 3> boxes{
        {{Aabb::everything(), nullptr, {}}, {kMiddle, nullptr, {}}, {Aabb::empty(), nullptr, {}}}};
    const std::array<uint32_t, 3> ends{1, 2, 3};
    std::array<Ticket, 3> tickets;
    device->begin_frame(kFlatView);
    draw(wall);
    device->query({boxes, ends}, tickets);
    EXPECT_EQ(device->wait(tickets[0]).state, AnswerState::lost);
    EXPECT_EQ(device->wait(tickets[1]).samples, 0u);
    EXPECT_EQ(device->wait(tickets[2]).state, AnswerState::lost);
    device->end_frame();
}

TEST_P(GlMethodsTest, AlmostAllThatQueriesHideIsHiddenAndNothingElse)
{
    // Odd sizes, with and without multisampling, every convention of depth, boxes under matrices.
    constexpr glm::ivec2 kOddSize{161, 97};
    for (const int samples : {1, 4}) {
        for (const bool reversed : {false, true}) {
            make_scene(kOddSize, samples);
            use();
            glm::mat4 projection = glm::perspectiveRH_ZO(1.0f, 161.0f / 97.0f, 0.1f, 200.0f);
            ClipConvention convention{DepthRange::zero_to_one, DepthOrder::near_is_small};
            if (reversed) {
                projection =
                    glm::mat4{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 1, 1} * projection;
                convention.order = DepthOrder::near_is_large;
            }
            const View view = View::from_clip(projection, kOddSize, convention);
            Rng rng(5);
            device->begin_frame(view);
            for (int i = 0; i < 12; ++i) {
                const float distance = rng.range(2.0f, 20.0f);
                const glm::vec2 low =
                    distance * glm::vec2{rng.range(-0.8f, 0.3f), rng.range(-0.6f, 0.3f)};
                draw(scene->add_quad(low, low + 0.4f * distance, -distance));
            }
            std::vector<glm::mat4> maps(600);
            std::vector<QueryBox> boxes(maps.size());
            std::vector<uint32_t> ends(maps.size());
            for (size_t i = 0; i < boxes.size(); ++i) {
                const float distance = rng.range(1.0f, 40.0f);
                const float size = distance * 0.02f * std::exp2(rng.range(-3.0f, 3.0f));
                const glm::vec3 center =
                    distance * glm::vec3{rng.range(-0.7f, 0.7f), rng.range(-0.5f, 0.5f), -1.0f};
                maps[i] = glm::rotate(glm::translate(glm::mat4{1.0f}, center), rng.range(0, 6),
                                      glm::normalize(glm::vec3{1.0f, rng.range(-1, 1), 0.3f}));
                const bool mapped = i % 2 == 0;
                const glm::vec3 middle = mapped ? glm::vec3{0.0f} : center;
                boxes[i].box = view.inflated_for_test({middle - size, middle + size});
                boxes[i].world_from_box = mapped ? &maps[i] : nullptr;
                ends[i] = static_cast<uint32_t>(i + 1);
            }
            std::vector<Ticket> exact(boxes.size());
            std::vector<Ticket> tickets(boxes.size());
            device->query({boxes, ends, TestMethod::queries}, exact);
            device->query({boxes, ends, TestMethod::automatic}, tickets);
            int hidden = 0;
            int missed = 0;
            for (size_t i = 0; i < boxes.size(); ++i) {
                const uint64_t counted = device->wait(exact[i]).samples;
                const uint64_t some = device->wait(tickets[i]).samples;
                ASSERT_TRUE(counted == 0 || some == 1) << "box " << i << " of " << counted;
                if (!pyramid()) {
                    ASSERT_EQ(some, counted > 0 ? 1u : 0u) << "box " << i;
                }
                hidden += counted == 0 ? 1 : 0;
                missed += counted == 0 && some > 0 ? 1 : 0;
            }
            EXPECT_GT(hidden, 60);
            EXPECT_LT(missed, hidden / 2); // rectangles reach beyond outlines, and off the target
            device->end_frame();
        }
    }
}

TEST_P(GlMethodsTest, TestsFollowATargetThatChangesItsSize)
{
    for (const glm::ivec2 size : {glm::ivec2{64, 64}, {33, 71}, {128, 16}}) {
        make_scene(size, 1);
        use();
        const ItemId wall = scene->add_quad(kLow, {0.0f, 1.0f}, 0.1f);
        device->begin_frame(View::from_clip(glm::mat4{1.0f}, size));
        draw(wall);
        EXPECT_EQ(count(kLeft), 0u);
        EXPECT_EQ(count(kRight), 1u);
        device->end_frame();
    }
}

TEST_P(GlMethodsTest, WarmUpDrawsNothingAndLeavesNoTicketBehind)
{
    make_device({.max_outstanding = 1});
    use();
    const ItemId wall = scene->add_quad(kLow, kHigh, 0.1f);
    device->begin_frame(kFlatView);
    device->warm_up();
    EXPECT_EQ(std::ranges::count(depths(), 1.0f), 64 * 64);
    draw(wall);
    EXPECT_EQ(count(kMiddle), 0u);
    device->end_frame();
}

class GlOldMethodsTest : public GlFixture {};

TEST_F(GlOldMethodsTest, OldContextsHaveNoRasterAndSaySo)
{
    make_device({.max_gl_version = 42});
    const auto used = device->use_method(TestMethod::raster);
    ASSERT_FALSE(used);
    EXPECT_NE(used.error().message.find("raster"), std::string::npos);
    EXPECT_NE(used.error().message.find("queries, pyramid"), std::string::npos);
    device->begin_frame(kFlatView);
    const QueryBox box{kMiddle, nullptr, {}};
    const uint32_t end = 1;
    Ticket ticket;
    device->query({{&box, 1}, {&end, 1}, TestMethod::raster}, {&ticket, 1});
    EXPECT_EQ(device->wait(ticket).samples, 2u * 1024u) << "answered by queries instead";
    device->end_frame();
}

} // namespace
} // namespace occlude
