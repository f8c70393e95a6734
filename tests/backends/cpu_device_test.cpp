#include "backends/cpu_test_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace occlude {
namespace {

using namespace test;

Answer test_box(CpuDevice& device, const Aabb& box, const glm::mat4* world_from_box = nullptr)
{
    const QueryBox query_box{box, world_from_box, {}};
    const uint32_t end = 1;
    Ticket ticket;
    device.query({.boxes = {&query_box, 1}, .test_ends = {&end, 1}}, {&ticket, 1});
    return device.wait(ticket);
}

// --------------------------------------------------------------------------------------- tests

TEST(CpuDevice, BoxCountsTheSamplesOfItsUnionOnce)
{
    TestScene scene;
    CpuDevice device(scene);
    device.begin_frame(pixel_view({32, 32}));
    EXPECT_EQ(test_box(device, {{4, 4, 0.2f}, {12, 10, 0.6f}}).samples, 48u);

    // Two overlapping boxes and one apart, in one test; then each in its own.
    const QueryBox boxes[] = {{{{4, 4, 0.2f}, {12, 10, 0.6f}}, nullptr, {}},
                              {{{8, 4, 0.3f}, {16, 10, 0.6f}}, nullptr, {}},
                              {{{20, 20, 0.3f}, {22, 21, 0.6f}}, nullptr, {}}};
    const uint32_t one_test[] = {3};
    Ticket ticket;
    device.query({.boxes = boxes, .test_ends = one_test}, {&ticket, 1});
    EXPECT_EQ(device.poll(ticket).samples, 12u * 6u + 2u);

    const uint32_t three_tests[] = {1, 2, 3};
    Ticket tickets[3];
    device.query({.boxes = boxes, .test_ends = three_tests, .method = TestMethod::raster}, tickets);
    EXPECT_EQ(device.wait(tickets[0]).samples, 48u);
    EXPECT_EQ(device.wait(tickets[1]).samples, 48u);
    EXPECT_EQ(device.wait(tickets[2]).samples, 2u);
    device.end_frame();
}

TEST(CpuDevice, PyramidAnswersSomeOrNoneByTheDrawsBeforeIt)
{
    TestScene scene;
    const ItemId wall = scene.add_rectangle({0, 0}, {16, 32}, 0.5f);
    CpuDevice device(scene);
    ASSERT_TRUE(device.use_method(TestMethod::pyramid));
    EXPECT_EQ(device.caps().methods.front().method, TestMethod::pyramid);
    EXPECT_FALSE(device.caps().exact_counts);
    const Aabb behind{{4, 4, 0.6f}, {12, 8, 0.7f}};
    const Aabb across{{12, 4, 0.6f}, {20, 8, 0.7f}};
    const Aabb in_front{{4, 4, 0.3f}, {12, 8, 0.4f}};
    const Aabb around{{4, 4, 0.4f}, {12, 8, 0.7f}};
    const glm::mat4 shift = glm::translate(glm::mat4{1.0f}, glm::vec3{16.0f, 0.0f, 0.0f});
    for (int frame = 0; frame < 2; ++frame) {
        device.begin_frame(pixel_view({32, 32}));
        EXPECT_EQ(test_box(device, behind).samples, 1u);
        device.draw({&wall, 1}, DrawPass::shade);
        EXPECT_EQ(test_box(device, behind).samples, 0u);
        EXPECT_EQ(test_box(device, behind, &shift).samples, 1u);
        EXPECT_EQ(test_box(device, across).samples, 1u);
        EXPECT_EQ(test_box(device, in_front).samples, 1u);
        EXPECT_EQ(test_box(device, around).samples, 1u);
        EXPECT_EQ(test_box(device, Aabb::everything()).state, AnswerState::lost);
        device.end_frame();
    }
}

TEST(CpuDevice, HasNoRasterAndSaysWhatItHas)
{
    TestScene scene;
    CpuDevice device(scene);
    const auto used = device.use_method(TestMethod::raster);
    ASSERT_FALSE(used);
    EXPECT_NE(used.error().message.find("queries or pyramid"), std::string::npos);
    EXPECT_EQ(device.caps().methods.front().method, TestMethod::queries);
}

TEST(CpuDevice, BoxSeesExactlyTheDrawsBeforeIt)
{
    TestScene scene;
    const ItemId wall = scene.add_rectangle({0, 0}, {16, 32}, 0.5f);
    CpuDevice device(scene);
    const Aabb behind{{4, 4, 0.6f}, {12, 8, 0.7f}};
    const Aabb across{{12, 4, 0.6f}, {20, 8, 0.7f}};
    const Aabb in_front{{4, 4, 0.3f}, {12, 8, 0.4f}};
    const Aabb around{{4, 4, 0.4f}, {12, 8, 0.7f}};
    device.begin_frame(pixel_view({32, 32}));
    EXPECT_EQ(test_box(device, behind).samples, 32u);
    device.draw({&wall, 1}, DrawPass::depth_only);
    EXPECT_EQ(test_box(device, behind).samples, 0u);
    EXPECT_EQ(test_box(device, across).samples, 16u);
    EXPECT_EQ(test_box(device, in_front).samples, 32u);
    EXPECT_EQ(test_box(device, around).samples, 32u);
    device.draw({&wall, 1}, DrawPass::shade_equal);
    EXPECT_EQ(test_box(device, behind).samples, 0u);
    EXPECT_EQ(test_box(device, around).samples, 32u);
    device.end_frame();
    device.begin_frame(pixel_view({32, 32}));
    EXPECT_EQ(test_box(device, behind).samples, 32u);
    device.end_frame();
}

TEST(CpuDevice, BoxFaceInTheWallIsVisibleAndAStepBehindIsNot)
{
    TestScene scene;
    const ItemId wall = scene.add_rectangle({0, 0}, {32, 32}, 0.5f);
    CpuDevice device(scene);
    device.begin_frame(pixel_view({32, 32}));
    device.draw({&wall, 1}, DrawPass::shade);
    EXPECT_EQ(test_box(device, {{4, 4, 0.5f}, {12, 8, 0.7f}}).samples, 32u);
    EXPECT_EQ(test_box(device, {{4, 4, 0.5f}, {12, 8, 0.5f}}).samples, 32u) << "flat";
    EXPECT_EQ(test_box(device, {{4, 4, 0.5f + 0x1p-22f}, {12, 8, 0.7f}}).samples, 0u);
    device.end_frame();
}

TEST(CpuDevice, EdgeOnFlatBoxesAreSeenOnceInflated)
{
    TestScene scene;
    CpuDevice device(scene);
    const View view = perspective_view({0, 0, 0}, {0, 0, -1}, {64, 64}, kOpenGl);
    device.begin_frame(view);
    // Edge-on in the plane of the eye: a line on the screen, through no sample even if inflated.
    const Aabb edge_on{{0, -1, -6}, {0, 1, -4}};
    EXPECT_EQ(test_box(device, edge_on).state, AnswerState::ready);
    // A box that lies on a column of samples is found. So are a line and a point there.
    const float x = 5.0f * std::tan(glm::radians(30.0f)) / 64.0f; // half a pixel at distance 5
    for (const Aabb& box : {Aabb{{x, -1, -5}, {x, 1, -5}}, Aabb{{x, x, -5}, {x, x, -5}}}) {
        EXPECT_GT(test_box(device, view.inflated_for_test(box)).samples, 0u);
    }
    EXPECT_GT(test_box(device, view.inflated_for_test({{-1, -1, -5}, {1, 1, -5}})).samples, 400u);
    device.end_frame();
}

TEST(CpuDevice, BoxesOutsideOfTheViewCountNothing)
{
    TestScene scene;
    CpuDevice device(scene);
    device.begin_frame(perspective_view({0, 0, 0}, {0, 0, -1}, {64, 64}, kOpenGl));
    EXPECT_EQ(test_box(device, {{-1, -1, 5}, {1, 1, 7}}).samples, 0u) << "behind";
    EXPECT_EQ(test_box(device, {{50, -1, -7}, {52, 1, -5}}).samples, 0u) << "beside";
    EXPECT_EQ(test_box(device, {{-1, -1, -150}, {1, 1, -120}}).samples, 0u) << "beyond far";
    EXPECT_GT(test_box(device, {{-1, -1, -150}, {1, 1, -50}}).samples, 0u) << "across far";
    device.end_frame();
}

TEST(CpuDevice, BoxBesideTheEyeThatCrossesTheNearPlaneIsTestedWhereItIsSeen)
{
    TestScene scene;
    CpuDevice device(scene);
    const View view = perspective_view({0, 0, 0}, {0, 0, -1}, {64, 64}, kOpenGl, 0.1f, 100.0f);
    // A wall along the right-hand side, from behind the eye to far ahead.
    const Aabb wall{{2, -50, -60}, {3, 50, 20}};
    ASSERT_FALSE(view.touches_near(wall));
    device.begin_frame(view);
    const Answer answer = test_box(device, wall);
    device.end_frame();
    ASSERT_EQ(answer.state, AnswerState::ready);
    // Its face at x = 2 is seen from distance 2 / tan 30 on: right of column 32 + 32 * 2 / (60 tan
    // 30).
    size_t expected = 0;
    const double tangent = std::tan(glm::radians(30.0));
    for (int column = 32; column < 64; ++column) {
        const double right = (column + 0.5) / 32.0 - 1.0;
        expected += 3.0 / (right * tangent) <= 60.0 || 2.0 / (right * tangent) <= 60.0 ? 64 : 0;
    }
    EXPECT_EQ(answer.samples, expected);
}

TEST(CpuDevice, TransformedBoxesAreTestedInTheirOwnSpace)
{
    TestScene scene;
    CpuDevice device(scene);
    device.begin_frame(pixel_view({32, 32}));
    const Aabb box{{-4, -4, 0.2f}, {4, 4, 0.4f}};
    const glm::mat4 moved = glm::translate(glm::mat4{1.0f}, {16, 16, 0});
    const glm::mat4 turned = glm::rotate(moved, glm::radians(45.0f), {0, 0, 1});
    const glm::mat4 mirrored = glm::scale(moved, {-1, 1, 1});
    EXPECT_EQ(test_box(device, box, &moved).samples, 64u);
    EXPECT_EQ(test_box(device, box, &mirrored).samples, 64u);
    // |x| + |y| < 4 sqrt 2 around the middle: rows of 2, 4, ..., 10, 10, ..., 2.
    EXPECT_EQ(test_box(device, box, &turned).samples, 2u * (2 + 4 + 6 + 8 + 10));
    device.end_frame();
}

TEST(CpuDevice, TestsWriteNothing)
{
    Rng rng(3);
    const TestScene scene = random_scene(rng, 30);
    CpuDevice device(scene);
    const View view = perspective_view({0, 1, 9}, {0, 0, 0}, {321, 179}, kOpenGl);
    device.begin_frame(view);
    device.draw(scene.all(), DrawPass::shade);
    const std::vector<float> depth(device.depth().begin(), device.depth().end());
    std::vector<CpuDevice::Owner> owners;
    for (size_t pixel = 0; pixel < depth.size(); ++pixel) {
        owners.push_back(device.owner(pixel));
    }
    uint64_t counted = 0;
    for (int i = 0; i < 100; ++i) {
        const glm::vec3 centre = random_point(rng, 6.0f);
        counted += test_box(device, {centre - 0.5f, centre + 0.5f}).state == AnswerState::ready;
    }
    EXPECT_GT(counted, 80u);
    EXPECT_TRUE(std::equal(depth.begin(), depth.end(), device.depth().begin()));
    for (size_t pixel = 0; pixel < depth.size(); ++pixel) {
        ASSERT_EQ(device.owner(pixel), owners[pixel]);
    }
    device.end_frame();
}

// Rule R2: at each sample that shows an item, its inflated box is counted too: against the depth of
// everything else, and against its own depth (R3).
TEST(CpuDevice, InflatedBoxCountsAtLeastTheSamplesThatItsContentsShow)
{
    int shown = 0;
    int hidden = 0;
    int small = 0;
    int lost_if_tight = 0;
    for (uint64_t seed = 1; seed <= 16; ++seed) {
        Rng rng(hash64(seed, 77u));
        const TestScene scene = random_scene(rng, 70);
        const glm::ivec2 size = seed % 2 == 0 ? glm::ivec2{641, 359} : glm::ivec2{320, 180};
        const ClipConvention convention = kConventions[seed / 2 % 4];
        const glm::vec3 eye = glm::vec3{0.0f, 1.0f, 8.0f} + random_point(rng, 3.0f);
        const View view = perspective_view(eye, random_point(rng, 1.0f), size, convention);
        CpuDevice all(scene);
        draw_frame(all, view, scene.all());
        std::vector<uint64_t> samples(scene.meshes.size(), 0);
        for (size_t pixel = 0; pixel < all.depth().size(); ++pixel) {
            if (all.owner(pixel).item.valid()) {
                ++samples[all.owner(pixel).item.value];
            }
        }
        CpuDevice device(scene);
        for (const ItemId item : scene.all()) {
            const TestMesh& mesh = scene.meshes[item.value];
            Aabb box_mesh;
            for (const glm::vec3& p : mesh.positions) {
                box_mesh = merge(box_mesh, {p, p});
            }
            const Aabb tight_box = transformed(mesh.world_from_mesh, box_mesh);
            const Aabb box = view.inflated_for_test(tight_box);
            if (samples[item.value] == 0 || view.touches_near(box)) {
                ++hidden;
                continue;
            }
            ++shown;
            small += samples[item.value] <= 4 ? 1 : 0;
            std::vector<ItemId> others = scene.all();
            std::erase(others, item);
            device.begin_frame(view);
            device.draw(others, DrawPass::shade);
            ASSERT_GE(test_box(device, box).samples, samples[item.value])
                << "seed " << seed << " item " << item.value;
            lost_if_tight += test_box(device, tight_box).samples < samples[item.value] ? 1 : 0;
            device.draw({&item, 1}, DrawPass::shade);
            ASSERT_GE(test_box(device, box).samples, samples[item.value])
                << "own depth, seed " << seed << " item " << item.value;
            device.end_frame();
        }
    }
    EXPECT_GT(shown, 300);
    EXPECT_GT(hidden, 100);
    EXPECT_GT(lost_if_tight, 0) << "cases that only the inflation saves";
    EXPECT_GT(small, 20) << "items of a few samples are what rasterisation rules can lose";
}

TEST(CpuDevice, DrawAndQueryCountsEachSampleThatTheItemsWonOnce)
{
    TestScene scene;
    const ItemId far_wall = scene.add_rectangle({0, 0}, {16, 16}, 0.75f);
    const ItemId near_wall = scene.add_rectangle({0, 0}, {8, 16}, 0.25f);
    const ItemId middle = scene.add_rectangle({4, 0}, {12, 16}, 0.5f);
    CpuDevice device(scene);
    const View view = pixel_view({16, 16});
    device.begin_frame(view);
    const std::vector<ItemId> both = {far_wall, near_wall};
    EXPECT_EQ(device.wait(device.draw_and_query(both, DrawPass::shade)).samples, 256u);
    EXPECT_EQ(device.wait(device.draw_and_query({&middle, 1}, DrawPass::depth_only)).samples, 64u);
    EXPECT_EQ(device.wait(device.draw_and_query({&middle, 1}, DrawPass::shade_equal)).samples, 64u);
    EXPECT_EQ(device.wait(device.draw_and_query({&far_wall, 1}, DrawPass::shade_equal)).samples,
              64u);
    EXPECT_EQ(owned_by(device, middle), 64u);
    device.end_frame();
}

// --------------------------------------------------------------------------------- the contract

TEST(CpuDevice, TicketsAreSpentByTheFirstAnswer)
{
    TestScene scene;
    CpuDevice device(scene);
    device.begin_frame(pixel_view({8, 8}));
    const QueryBox box{{{1, 1, 0.2f}, {3, 3, 0.4f}}, nullptr, {}};
    const uint32_t end = 1;
    Ticket first;
    device.query({.boxes = {&box, 1}, .test_ends = {&end, 1}}, {&first, 1});
    ASSERT_TRUE(first.valid());
    device.end_frame();
    EXPECT_EQ(device.poll(first).samples, 4u) << "good outside of the frame (C12)";
    EXPECT_EQ(device.poll(first).state, AnswerState::lost);
    EXPECT_EQ(device.wait(first).state, AnswerState::lost);
    EXPECT_EQ(device.wait(first).samples, Answer::kUnknownSamples);

    device.begin_frame(pixel_view({8, 8}));
    Ticket second;
    device.query({.boxes = {&box, 1}, .test_ends = {&end, 1}}, {&second, 1});
    EXPECT_EQ(second.index, first.index) << "the slot is used again";
    EXPECT_EQ(device.wait(first).state, AnswerState::lost) << "but not for its former owner";
    EXPECT_EQ(device.wait(second).samples, 4u);
    EXPECT_EQ(device.wait(Ticket{}).state, AnswerState::lost);
    EXPECT_EQ(device.wait(Ticket{1000, 1}).state, AnswerState::lost);
    device.end_frame();
}

TEST(CpuDevice, TestsBeyondMaxOutstandingAreLostUntilATicketIsSpent)
{
    TestScene scene;
    CpuDevice device(scene, {.max_outstanding = 2});
    ASSERT_EQ(device.caps().max_outstanding, 2u);
    device.begin_frame(pixel_view({8, 8}));
    const QueryBox boxes[] = {{{{1, 1, 0.2f}, {3, 3, 0.4f}}, nullptr, {}},
                              {{{1, 1, 0.2f}, {3, 4, 0.4f}}, nullptr, {}},
                              {{{1, 1, 0.2f}, {3, 5, 0.4f}}, nullptr, {}}};
    const uint32_t ends[] = {1, 2, 3};
    Ticket tickets[3];
    device.query({.boxes = boxes, .test_ends = ends}, tickets);
    EXPECT_EQ(device.wait(tickets[2]).state, AnswerState::lost);
    EXPECT_EQ(device.wait(tickets[0]).samples, 4u);
    EXPECT_EQ(device.wait(device.draw_and_query({}, DrawPass::shade)).samples, 0u);
    EXPECT_EQ(device.wait(tickets[1]).samples, 6u);
    device.end_frame();
}

TEST(CpuDevice, TestsThatCannotBeAnsweredAreLostAndNeverZero)
{
    TestScene scene;
    CpuDevice device(scene);
    const View view = perspective_view({0, 0, 0}, {0, 0, -1}, {64, 64}, kOpenGl);
    const float nan = std::nanf("");
    device.begin_frame(view);
    EXPECT_EQ(test_box(device, {{-1, -1, -1}, {1, 1, 1}}).state, AnswerState::lost) << "eye inside";
    EXPECT_EQ(test_box(device, {{-1, -1, -1}, {1, 1, -0.1f}}).state, AnswerState::lost);
    EXPECT_EQ(test_box(device, Aabb::everything()).state, AnswerState::lost);
    EXPECT_EQ(test_box(device, Aabb::empty()).state, AnswerState::lost);
    EXPECT_EQ(test_box(device, {{nan, 0, -5}, {1, 1, -4}}).state, AnswerState::lost);
    const glm::mat4 to_the_eye = glm::translate(glm::mat4{1.0f}, {0, 0, 5});
    EXPECT_EQ(test_box(device, {{-1, -1, -6}, {1, 1, -4}}, &to_the_eye).state, AnswerState::lost);
    device.end_frame();

    glm::mat4 broken{1.0f};
    broken[2][1] = nan;
    for (const View& bad :
         {View{}, View::from_clip(broken, {8, 8}), View::from_clip(glm::mat4{0.0f}, {8, 8}),
          View::from_clip(glm::mat4{1.0f}, {0, 8}),
          View::from_clip(glm::mat4{1.0f}, {8, 1 << 20})}) {
        device.begin_frame(bad);
        EXPECT_EQ(test_box(device, {{-1, -1, -6}, {1, 1, -4}}).state, AnswerState::lost);
        device.end_frame();
    }
}

TEST(CpuDevice, ChangesItsSizeWithTheView)
{
    TestScene scene;
    scene.add({{{-1, -1, 0.5f}, {1, -1, 0.5f}, {1, 1, 0.5f}, {-1, 1, 0.5f}}, {0, 1, 2, 0, 2, 3}});
    CpuDevice device(scene);
    for (const glm::ivec2 size : {glm::ivec2{16, 8}, {33, 17}, {4, 4}, {8, 16}}) {
        draw_frame(device, View::from_clip(glm::mat4{1.0f}, size), scene.all());
        EXPECT_EQ(device.size_px(), size);
        EXPECT_EQ(covered(device), static_cast<size_t>(size.x * size.y));
    }
    EXPECT_EQ(device.frame_count(), 4u);
}

} // namespace
} // namespace occlude
