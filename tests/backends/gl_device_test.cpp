#include "backends/gl_fixture.h"

#include <occlude/core/rng.h>

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <array>
#include <numbers>

namespace occlude {
namespace {

View perspective_view(glm::ivec2 size = {64, 64})
{
    const glm::mat4 projection = glm::perspective(1.0f, 1.0f, 0.1f, 1000.0f);
    return View::from_clip(projection, size);
}

class GlDeviceTest : public GlFixture {};

TEST_F(GlDeviceTest, CapsSayWhatItCan)
{
    const DeviceCaps& caps = device->caps();
    EXPECT_EQ(caps.name, "gl");
    EXPECT_TRUE(caps.same_frame_results);
    EXPECT_TRUE(caps.exact_counts);
    EXPECT_TRUE(caps.draw_and_query);
    EXPECT_TRUE(caps.read_depth);
    EXPECT_EQ(caps.max_outstanding, 4096u);
    ASSERT_EQ(caps.depth_reads.size(), 7u) << "1 to 64 pixels";
    EXPECT_LT(caps.find_depth_read(16)->us({1280, 720}), 1e5f);
    ASSERT_EQ(caps.methods.size(), 3u);
    EXPECT_EQ(caps.methods[0].method, TestMethod::queries);
    for (const TestCost& cost : caps.methods) {
        EXPECT_GT(cost.us_per_test, 0.0f);
        EXPECT_EQ(cost.exact_counts, cost.method == TestMethod::queries);
    }
}

TEST_F(GlDeviceTest, VisibleBoxCountsItsFrontAndBackExactly)
{
    device->begin_frame(kFlatView);
    EXPECT_EQ(count(kMiddle), 2 * kMiddlePixels);
    device->end_frame();
}

TEST_F(GlDeviceTest, BoxCutByAWallCountsOnlyItsFront)
{
    const ItemId wall = scene->add_quad(kLow, kHigh, 0.3f);
    device->begin_frame(kFlatView);
    draw(wall);
    EXPECT_EQ(count(kMiddle), kMiddlePixels);
    device->end_frame();
}

TEST_F(GlDeviceTest, HiddenBoxCountsNothing)
{
    const ItemId wall = scene->add_quad(kLow, kHigh, 0.1f);
    device->begin_frame(kFlatView);
    draw(wall);
    EXPECT_EQ(count(kMiddle), 0u);
    device->end_frame();
}

TEST_F(GlDeviceTest, BoxSeenThroughOnePixelCountsIt)
{
    // A wall of two quads with a slit one pixel wide, before a box that is one pixel high there.
    const float pixel = 2.0f / 64.0f;
    const ItemId left = scene->add_quad(kLow, {0.0f, 1.0f}, 0.1f);
    const ItemId right = scene->add_quad({pixel, -1.0f}, kHigh, 0.1f);
    device->begin_frame(kFlatView);
    draw(left);
    draw(right);
    EXPECT_EQ(count({{-0.5f, 0.0f, 0.2f}, {0.5f, pixel, 0.4f}}), 2u);
    device->end_frame();
}

TEST_F(GlDeviceTest, TestSeesOnlyDrawsBeforeIt)
{
    const ItemId wall = scene->add_quad(kLow, kHigh, 0.1f);
    device->begin_frame(kFlatView);
    const Ticket before = ask(kMiddle);
    draw(wall);
    const Ticket after = ask(kMiddle);
    device->flush();
    EXPECT_EQ(device->wait(before).samples, 2 * kMiddlePixels);
    EXPECT_EQ(device->wait(after).samples, 0u);
    device->end_frame();
}

TEST_F(GlDeviceTest, TestsWriteNeitherColourNorDepth)
{
    const ItemId quad = scene->add_quad({-0.3f, -0.9f}, {0.9f, 0.2f}, 0.3f);
    device->begin_frame(kFlatView);
    draw(quad);
    expect_nothing_written_by([&] {
        EXPECT_GT(count(kMiddle), 0u);
        EXPECT_GT(count({{-1, -1, -0.5f}, {1, 1, 0}}), 0u);
    });
    const std::vector<uint32_t> colors = scene->colors();
    EXPECT_NE(std::ranges::count(colors, colors[0]), static_cast<ptrdiff_t>(colors.size()));
    device->end_frame();
}

TEST_F(GlDeviceTest, ATestIsTheUnionOfItsBoxesAndTestsOfABatchAreSeparate)
{
    const ItemId wall = scene->add_quad(kLow, {0.0f, 1.0f}, 0.1f); // hides the left half
    std::array<Ticket, 3> tickets;
    device->begin_frame(kFlatView);
    draw(wall);
    device->query({kUnions.boxes, kUnions.ends, TestMethod::queries}, tickets);
    EXPECT_EQ(device->wait(tickets[0]).samples, 0u);
    EXPECT_EQ(device->wait(tickets[1]).samples, 2u * 16u * 16u);
    EXPECT_EQ(device->wait(tickets[2]).samples, 0u);
    device->end_frame();
}

TEST_F(GlDeviceTest, TransformedBoxCoversItsImage)
{
    const Aabb unit{{-0.5f, -0.5f, -0.1f}, {0.5f, 0.5f, 0.1f}};
    const glm::mat4 moved =
        glm::scale(glm::translate(glm::mat4{1.0f}, {0.5f, 0.5f, 0.0f}), {0.5f, 0.25f, 1.0f});
    const ItemId wall = scene->add_quad(kLow, {1.0f, 0.0f}, -0.5f); // hides the lower half
    device->begin_frame(kFlatView);
    draw(wall);
    EXPECT_EQ(count(unit, &moved), 2u * 16u * 8u);
    const glm::mat4 hidden = glm::translate(moved, {0.0f, -4.0f, 0.0f});
    EXPECT_EQ(count(unit, &hidden), 0u);
    device->end_frame();
}

TEST_F(GlDeviceTest, RotatedBoxIsTight)
{
    const float pi = std::numbers::pi_v<float>;
    const glm::mat4 turned = glm::rotate(glm::mat4{1.0f}, 0.25f * pi, {0, 0, 1});
    device->begin_frame(kFlatView);
    const uint64_t samples = count({{-0.5f, -0.5f, 0.0f}, {0.5f, 0.5f, 0.1f}}, &turned);
    EXPECT_NEAR(static_cast<double>(samples), 2.0 * kMiddlePixels, 2.0 * 64.0);
    device->end_frame();
}

TEST_F(GlDeviceTest, MirroredTransformsAndProjectionsCountTheSame)
{
    const glm::mat4 mirror = glm::scale(glm::mat4{1.0f}, {-1.0f, 1.0f, 1.0f});
    device->begin_frame(kFlatView);
    EXPECT_EQ(count(kMiddle, &mirror), 2 * kMiddlePixels);
    device->end_frame();
    device->begin_frame(View::from_clip(mirror, kSize));
    EXPECT_EQ(count(kMiddle), 2 * kMiddlePixels);
    EXPECT_EQ(count(kMiddle, &mirror), 2 * kMiddlePixels);
    device->end_frame();
}

TEST_F(GlDeviceTest, ReversedDepthHidesAndShows)
{
    // Window depth = z: near is 1, far is 0.
    const View view = View::from_clip(glm::mat4{1.0f}, kSize,
                                      {DepthRange::zero_to_one, DepthOrder::near_is_large});
    const ItemId wall = scene->add_quad(kLow, {0.0f, 1.0f}, 0.5f);
    device->begin_frame(view);
    draw(wall);
    EXPECT_EQ(count({{-0.5f, -0.5f, 0.2f}, {0.0f, 0.5f, 0.4f}}), 0u);
    EXPECT_EQ(count({{-0.5f, -0.5f, 0.6f}, {0.0f, 0.5f, 0.8f}}), kMiddlePixels);
    EXPECT_EQ(count({{0.0f, -0.5f, 0.2f}, {0.5f, 0.5f, 0.4f}}), kMiddlePixels);
    EXPECT_EQ(count({{-0.5f, -0.5f, 0.5f}, {0.0f, 0.5f, 0.5f}}), kMiddlePixels) << "on the wall";
    const std::vector<float> depth = depths();
    EXPECT_EQ(depth[0], 0.5f);
    EXPECT_EQ(depth[63], 1.0f) << "background is far";
    device->end_frame();
}

TEST_F(GlDeviceTest, BoxesAcrossTheFarPlaneAreVisible)
{
    const View view = perspective_view();
    device->begin_frame(view);
    EXPECT_GT(count({{-1500, -1500, -3000}, {1500, 1500, -2000}}), 0u);
    device->end_frame();
}

TEST_F(GlDeviceTest, WallLyingOnItsOwnBoxIsVisible)
{
    // R3, at many distances, flat and tilted: the box of a mesh that was just drawn must be
    // visible.
    const View view = perspective_view({641, 359});
    make_scene({641, 359}, 1);
    Rng rng(7);
    for (int i = 0; i < 200; ++i) {
        const float distance = std::exp2(rng.range(-2.0f, 9.5f));
        const float slope = rng.range(-1.5f, 1.5f) * distance;
        const float size = 0.2f * distance;
        const glm::vec3 a{-size, -size, -distance - slope * 0.1f};
        const glm::vec3 b{size, -size, -distance + slope * 0.1f};
        const glm::vec3 c{0.0f, size, -distance};
        const ItemId item = scene->add_triangles(std::array{a, b, c, a, c, b});
        const Aabb box{glm::min(glm::min(a, b), c), glm::max(glm::max(a, b), c)};
        device->begin_frame(view);
        draw(item);
        EXPECT_GT(count(view.inflated_for_test(box)), 0u) << "distance " << distance;
        device->end_frame();
    }
}

TEST_F(GlDeviceTest, FlatBoxOnItsOwnWallIsVisibleWithoutInflation)
{
    const ItemId wall = scene->add_quad({-0.5f, -0.5f}, {0.5f, 0.5f}, 0.3f);
    device->begin_frame(kFlatView);
    draw(wall);
    EXPECT_EQ(count({{-0.5f, -0.5f, 0.3f}, {0.5f, 0.5f, 0.3f}}), 2 * kMiddlePixels);
    device->end_frame();
}

TEST_F(GlDeviceTest, TiltedFlatBoxOnItsOwnWallIsVisibleAlmostEverywhere)
{
    // The wall comes in world space, the box through a matrix. Their depths differ in the last
    // bits, and the bias must cover that at all distances.
    make_scene({320, 240}, 1);
    const View view = perspective_view({320, 240});
    Rng rng(5);
    for (int i = 0; i < 50; ++i) {
        const float distance = std::exp2(rng.range(-1.0f, 8.0f));
        const glm::mat4 world = glm::rotate(
            glm::translate(glm::mat4{1.0f}, {0.0f, 0.0f, -distance}), rng.range(-1.3f, 1.3f),
            glm::normalize(glm::vec3{rng.range(-1.0f, 1.0f), 1.0f, rng.range(-1.0f, 1.0f)}));
        const float half = 0.3f * distance;
        const auto corner = [&](float x, float y) {
            return glm::vec3{glm::dmat4{world} * glm::dvec4{x, y, 0.0, 1.0}};
        };
        const glm::vec3 a = corner(-half, -half);
        const glm::vec3 c = corner(half, half);
        const ItemId wall =
            scene->add_triangles(std::array{a, corner(half, -half), c, a, c, corner(-half, half)});
        device->begin_frame(view);
        const uint64_t drawn =
            device->wait(device->draw_and_query({&wall, 1}, DrawPass::shade)).samples;
        ASSERT_GT(drawn, 1000u);
        EXPECT_GE(count({{-half, -half, 0.0f}, {half, half, 0.0f}}, &world), 2 * drawn * 98 / 100)
            << "distance " << distance;
        device->end_frame();
    }
}

TEST_F(GlDeviceTest, ABoxIsNeverHiddenWhenATriangleInItWouldBeSeen)
{
    // C3 with triangles from a tenth of a pixel to some pixels, between and beyond random walls.
    constexpr glm::ivec2 kOddSize{161, 97};
    make_scene(kOddSize, 1);
    const View view = perspective_view(kOddSize);
    Rng rng(3);
    for (int i = 0; i < 12; ++i) {
        const float distance = rng.range(2.0f, 20.0f);
        const glm::vec2 low = distance * glm::vec2{rng.range(-0.6f, 0.3f), rng.range(-0.6f, 0.3f)};
        scene->add_quad(low, low + 0.3f * distance, -distance);
    }
    std::vector<ItemId> triangles;
    std::vector<Aabb> boxes;
    for (int i = 0; i < 2000; ++i) {
        const float distance = rng.range(1.0f, 40.0f);
        const float size = distance * 0.01f * std::exp2(rng.range(-4.0f, 3.0f));
        const glm::vec3 place =
            distance * glm::vec3{rng.range(-0.5f, 0.5f), rng.range(-0.5f, 0.5f), -1.0f};
        const auto corner = [&] {
            return place + size * glm::vec3{rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1)};
        };
        const glm::vec3 a = corner();
        const glm::vec3 b = corner();
        const glm::vec3 c = corner();
        triangles.push_back(scene->add_triangles(std::array{a, b, c, a, c, b}));
        boxes.push_back({glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))});
    }
    device->begin_frame(view);
    for (uint32_t wall = 0; wall < 12; ++wall) {
        draw(ItemId{wall});
    }
    std::vector<Ticket> box_tickets;
    std::vector<Ticket> triangle_tickets;
    for (size_t i = 0; i < triangles.size(); ++i) {
        box_tickets.push_back(ask(view.inflated_for_test(boxes[i])));
        triangle_tickets.push_back(device->draw_and_query({&triangles[i], 1}, DrawPass::shade));
    }
    size_t hidden = 0;
    size_t seen = 0;
    for (size_t i = 0; i < triangles.size(); ++i) {
        const uint64_t box = device->wait(box_tickets[i]).samples;
        const uint64_t triangle = device->wait(triangle_tickets[i]).samples;
        EXPECT_GE(box, triangle) << i;
        hidden += box == 0 ? 1u : 0u;
        seen += triangle > 0 ? 1u : 0u;
    }
    device->end_frame();
    EXPECT_GT(hidden, triangles.size() / 10);
    EXPECT_GT(seen, triangles.size() / 10);
}

TEST_F(GlDeviceTest, DepthBiasIsSmall)
{
    const ItemId wall = scene->add_quad(kLow, kHigh, 0.3f);
    device->begin_frame(kFlatView);
    draw(wall);
    EXPECT_EQ(count({{-0.5f, -0.5f, 0.30001f}, {0.5f, 0.5f, 0.4f}}), 0u);
    device->end_frame();
}

TEST_F(GlDeviceTest, WorksWithTwentyFourBitDepth)
{
    make_scene(kSize, 1, GL_DEPTH24_STENCIL8);
    const ItemId wall = scene->add_quad(kLow, {0.0f, 1.0f}, 0.3f);
    device->begin_frame(kFlatView);
    draw(wall);
    EXPECT_EQ(count({{-0.5f, -0.5f, 0.3f}, {0.0f, 0.5f, 0.3f}}), kMiddlePixels);
    EXPECT_EQ(count({{-0.5f, -0.5f, 0.31f}, {0.0f, 0.5f, 0.4f}}), 0u);
    EXPECT_NEAR(depths()[0], 0.65f, 1e-6f);
    device->end_frame();
}

TEST_F(GlDeviceTest, MultisampledTargetsCountSamples)
{
    make_scene(kSize, 4);
    const float pixel = 2.0f / 64.0f;
    // The wall leaves a slit half a pixel wide: whole pixels are covered by no sample at their
    // centre, but by some of four.
    const ItemId left = scene->add_quad(kLow, {0.25f * pixel, 1.0f}, 0.1f);
    const ItemId right = scene->add_quad({0.75f * pixel, -1.0f}, kHigh, 0.1f);
    device->begin_frame(kFlatView);
    EXPECT_EQ(count(kMiddle), 2 * 4 * kMiddlePixels);
    draw(left);
    draw(right);
    const uint64_t through_slit = count(kMiddle);
    EXPECT_GT(through_slit, 0u);
    EXPECT_LT(through_slit, 2u * 4u * 32u);
    device->end_frame();
}

TEST_F(GlDeviceTest, StateIsGivenBackOnceBeforeTheNextDrawAndBeforeTheEnd)
{
    const ItemId quad = scene->add_quad({-0.5f, -0.5f}, {0.5f, 0.5f}, 0.3f);
    device->begin_frame(kFlatView);
    draw(quad);
    EXPECT_EQ(scene->restores, 0) << "no tests, nothing to restore";
    const Ticket a = ask(kMiddle);
    const Ticket b = ask(kMiddle);
    EXPECT_EQ(scene->restores, 0);
    draw(quad);
    draw(quad);
    EXPECT_EQ(scene->restores, 1);
    const Ticket c = ask(kMiddle);
    device->end_frame();
    EXPECT_EQ(scene->restores, 2);
    EXPECT_EQ(scene->ended, 1);
    for (const Ticket ticket : {a, b, c}) {
        EXPECT_EQ(device->wait(ticket).state, AnswerState::ready);
    }
}

TEST_F(GlDeviceTest, TestsLeaveExactlyTheDeclaredState)
{
    device->begin_frame(kFlatView);
    GLint framebuffer = 0;
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &framebuffer);
    const Ticket ticket = ask(kMiddle);

    GLboolean color_mask[4];
    glGetBooleanv(GL_COLOR_WRITEMASK, color_mask);
    EXPECT_FALSE(color_mask[0] || color_mask[1] || color_mask[2] || color_mask[3]);
    GLboolean depth_mask = GL_TRUE;
    glGetBooleanv(GL_DEPTH_WRITEMASK, &depth_mask);
    EXPECT_FALSE(depth_mask);
    GLint function = 0;
    glGetIntegerv(GL_DEPTH_FUNC, &function);
    EXPECT_EQ(function, GL_LEQUAL);
    EXPECT_TRUE(glIsEnabled(GL_DEPTH_TEST));
    EXPECT_TRUE(glIsEnabled(GL_DEPTH_CLAMP));
    EXPECT_FALSE(glIsEnabled(GL_CULL_FACE));
    EXPECT_FALSE(glIsEnabled(GL_SCISSOR_TEST));
    GLint active = 0;
    glGetQueryiv(GL_SAMPLES_PASSED, GL_CURRENT_QUERY, &active);
    EXPECT_EQ(active, 0);
    GLint after = 0;
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &after);
    EXPECT_EQ(after, framebuffer);
    EXPECT_EQ(device->wait(ticket).state, AnswerState::ready);
    device->end_frame();
}

} // namespace
} // namespace occlude
