#include "backends/cpu_test_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace occlude {
namespace {

using namespace test;

// The rows of the image, top row first, '#' where something was drawn.
std::string picture(const CpuDevice& device)
{
    const glm::ivec2 size = device.size_px();
    std::string rows;
    for (int y = size.y - 1; y >= 0; --y) {
        for (int x = 0; x < size.x; ++x) {
            rows += device.depth()[static_cast<size_t>(y * size.x + x)] < 1.0f ? '#' : '.';
        }
        rows += '\n';
    }
    return rows;
}

// ------------------------------------------------------------------------------------ coverage

TEST(CpuDeviceDraw, CoversExactlyThePixelsWhoseCentresAreInside)
{
    TestScene scene;
    scene.add_triangle({1.0f, 1.0f, 0.5f}, {6.9f, 1.0f, 0.5f}, {1.0f, 6.9f, 0.5f});
    CpuDevice device(scene);
    draw_frame(device, pixel_view({8, 8}), scene.all());
    // Centres (x + .5, y + .5) with x + y + 1 < 7.9.
    EXPECT_EQ(picture(device), "........\n"
                               "........\n"
                               ".#......\n"
                               ".##.....\n"
                               ".###....\n"
                               ".####...\n"
                               ".#####..\n"
                               "........\n");
}

TEST(CpuDeviceDraw, EdgesThroughCentresBelongToTheLeftAndTheTopOfTheTriangle)
{
    TestScene scene;
    scene.add_rectangle({1.5f, 1.5f}, {4.5f, 3.5f}, 0.5f);
    CpuDevice device(scene);
    draw_frame(device, pixel_view({8, 8}), scene.all());
    // Centres on the left column and top row are in; on the right column and bottom row they are
    // out.
    EXPECT_EQ(picture(device), "........\n"
                               "........\n"
                               "........\n"
                               "........\n"
                               ".###....\n"
                               ".###....\n"
                               "........\n"
                               "........\n");
}

TEST(CpuDeviceDraw, DrawsBothSides)
{
    TestScene scene;
    scene.add_triangle({1.0f, 1.0f, 0.5f}, {6.0f, 1.0f, 0.5f}, {1.0f, 6.0f, 0.5f});
    CpuDevice device(scene);
    draw_frame(device, pixel_view({8, 8}), scene.all());
    const std::string front = picture(device);
    std::swap(scene.meshes[0].indices[1], scene.meshes[0].indices[2]);
    draw_frame(device, pixel_view({8, 8}), scene.all());
    EXPECT_EQ(picture(device), front);
    EXPECT_GT(covered(device), 0u);
}

TEST(CpuDeviceDraw, FullScreenRectangleCoversWidthTimesHeight)
{
    for (const glm::ivec2 size : {glm::ivec2{1, 1}, {64, 32}, {641, 359}, {3, 511}}) {
        TestScene scene;
        scene.add(
            {{{-1, -1, 0.5f}, {1, -1, 0.5f}, {1, 1, 0.5f}, {-1, 1, 0.5f}}, {0, 1, 2, 0, 2, 3}});
        CpuDevice device(scene);
        device.begin_frame(View::from_clip(glm::mat4{1.0f}, size));
        const Answer answer = device.wait(device.draw_and_query(scene.all(), DrawPass::shade));
        device.end_frame();
        const auto pixels = static_cast<size_t>(size.x * size.y);
        EXPECT_EQ(answer.samples, pixels);
        EXPECT_EQ(covered(device), pixels);
    }
}

// In a fan, the triangles must cover each sample exactly once in total. They are drawn one by one.
TEST(CpuDeviceDraw, SamplesOnSharedEdgesAreCoveredByExactlyOneTriangle)
{
    Rng rng(11);
    for (int round = 0; round < 40; ++round) {
        // A fan around a centre, with snapped corners: many edges pass through sample centres.
        TestScene scene;
        std::vector<glm::vec3> corners;
        const auto half = [](float v) { return std::round(2.0f * v) / 2.0f; };
        const glm::vec3 centre{half(rng.range(12, 20)), half(rng.range(12, 20)), 0.5f};
        constexpr int kCorners = 9;
        for (int i = 0; i < kCorners; ++i) {
            const float angle = 6.2831853f * static_cast<float>(i) / kCorners;
            const float radius = rng.range(6.0f, 11.0f);
            corners.push_back({half(centre.x + radius * std::cos(angle)),
                               half(centre.y + radius * std::sin(angle)), 0.5f});
        }
        for (int i = 0; i < kCorners; ++i) {
            scene.add_triangle(centre, corners[static_cast<size_t>(i)],
                               corners[static_cast<size_t>((i + 1) % kCorners)]);
        }
        CpuDevice device(scene);
        size_t total = 0;
        for (const ItemId item : scene.all()) {
            draw_frame(device, pixel_view({32, 32}), {item});
            total += covered(device);
        }
        draw_frame(device, pixel_view({32, 32}), scene.all());
        ASSERT_EQ(total, covered(device)) << "round " << round;
        ASSERT_GT(total, 50u);
        // No hole around the centre either.
        const auto middle = static_cast<size_t>(centre.y) * 32 + static_cast<size_t>(centre.x);
        EXPECT_LT(device.depth()[middle], 1.0f);
    }
}

TEST(CpuDeviceDraw, DegenerateAndBrokenTrianglesDrawNothing)
{
    TestScene scene;
    const float nan = std::nanf("");
    scene.add_triangle({1, 1, 0.5f}, {5, 5, 0.5f}, {3, 3, 0.5f});
    scene.add_triangle({1, 1, 0.5f}, {5, nan, 0.5f}, {3, 7, 0.5f});
    scene.add_triangle({1, 1, 0.5f}, {5, Aabb::kInfinity, 0.5f}, {3, 7, 0.5f});
    scene.add({{{1, 1, 0.5f}, {7, 1, 0.5f}, {1, 7, 0.5f}}, {0, 1, 3}});
    scene.add({{{1, 1, 0.5f}, {7, 1, 0.5f}, {1, 7, 0.5f}}, {0, 1}});
    scene.add({});
    CpuDevice device(scene);
    std::vector<ItemId> items = scene.all();
    items.push_back(ItemId{});
    draw_frame(device, pixel_view({8, 8}), items);
    EXPECT_EQ(covered(device), 0u);
}

TEST(CpuDeviceDraw, VerticesFarOutsideOfTheScreenAreClippedWithoutOverflow)
{
    TestScene scene;
    // Half planes: the whole left half of the screen, from triangles too large for the integers.
    scene.add_triangle({8.0f, -1e12f, 0.5f}, {8.0f, 1e12f, 0.5f}, {-1e12f, 0.0f, 0.5f});
    CpuDevice device(scene);
    draw_frame(device, pixel_view({16, 16}), scene.all());
    EXPECT_EQ(covered(device), 8u * 16u);
    EXPECT_EQ(device.depth()[7], 0.5f);
    EXPECT_EQ(device.depth()[8], 1.0f);
}

TEST(CpuDeviceDraw, MirroredTransformDrawsTheMirrorImage)
{
    TestScene scene;
    // No sample lies on an edge: the mirror image may differ for those.
    scene.add_triangle({1.0f, 1.125f, 0.25f}, {6.25f, 2.0f, 0.5f}, {2.125f, 7.0f, 0.75f});
    CpuDevice device(scene);
    draw_frame(device, pixel_view({8, 8}), scene.all());
    const std::vector<float> plain(device.depth().begin(), device.depth().end());
    scene.meshes[0].world_from_mesh =
        glm::scale(glm::translate(glm::mat4{1.0f}, {8.0f, 0.0f, 0.0f}), {-1.0f, 1.0f, 1.0f});
    draw_frame(device, pixel_view({8, 8}), scene.all());
    ASSERT_GT(covered(device), 5u);
    for (size_t y = 0; y < 8; ++y) {
        for (size_t x = 0; x < 8; ++x) {
            EXPECT_FLOAT_EQ(device.depth()[y * 8 + x], plain[y * 8 + 7 - x]);
        }
    }
}

// --------------------------------------------------------------------------------------- depth

TEST(CpuDeviceDraw, DepthIsLinearAcrossTheScreen)
{
    TestScene scene;
    // depth = x / 16 + y / 32
    scene.add_triangle({0, 0, 0}, {16, 0, 1.0f}, {0, 16, 0.5f});
    CpuDevice device(scene);
    draw_frame(device, pixel_view({16, 16}), scene.all());
    EXPECT_EQ(device.depth()[0], 0.5f / 16 + 0.5f / 32);
    EXPECT_EQ(device.depth()[3 * 16 + 7], 7.5f / 16 + 3.5f / 32);
}

TEST(CpuDeviceDraw, DepthIsZeroAtNearAndOneAtFarInEveryConvention)
{
    for (const ClipConvention& convention : kConventions) {
        const View view = perspective_view({0, 0, 0}, {0, 0, -1}, {64, 64}, convention, 1.0f, 9.0f);
        // Walls that face the camera at distance d have depth f (d - n) / (d (f - n)).
        for (const float distance : {1.5f, 2.0f, 5.0f, 8.5f}) {
            TestScene scene;
            const float r = 20.0f;
            scene.add(
                {{{-r, -r, -distance}, {r, -r, -distance}, {r, r, -distance}, {-r, r, -distance}},
                 {0, 1, 2, 0, 2, 3}});
            CpuDevice device(scene);
            draw_frame(device, view, scene.all());
            const float expected = 9.0f * (distance - 1.0f) / (distance * 8.0f);
            EXPECT_EQ(covered(device), 64u * 64u);
            EXPECT_NEAR(device.depth()[64 * 32 + 32], expected, 1e-6f);
            EXPECT_NEAR(device.depth()[0], expected, 1e-6f);
        }
        for (const float distance : {0.5f, 0.999f, 9.001f, 20.0f}) {
            TestScene scene;
            const float r = 20.0f;
            scene.add({{{-r, -r, -distance}, {r, -r, -distance}, {r, r, -distance}}, {0, 1, 2}});
            CpuDevice device(scene);
            draw_frame(device, view, scene.all());
            EXPECT_EQ(covered(device), 0u) << distance;
        }
    }
}

TEST(CpuDeviceDraw, FloorThroughTheEyePlaneIsClippedAtNearAndFar)
{
    for (const ClipConvention& convention : kConventions) {
        const View view =
            perspective_view({0, 1, 0}, {0, 1, -1}, {64, 64}, convention, 1.0f, 50.0f);
        TestScene scene;
        const float r = 1000.0f;
        scene.add({{{-r, 0, -r}, {r, 0, -r}, {r, 0, r}, {-r, 0, r}}, {0, 1, 2, 0, 2, 3}});
        CpuDevice device(scene);
        draw_frame(device, view, scene.all());
        const double tangent = std::tan(glm::radians(30.0));
        // The near cut lies on a snap, and depth changes by 0.018 per row.
        constexpr double kHalfSnapOfSlope = 0.018 / 512.0 + 1e-6;
        size_t wrong = 0;
        size_t seen = 0;
        for (int y = 0; y < 64; ++y) {
            // The ray of a row below the horizon meets the floor at distance 1 / slope.
            const double slope = -((y + 0.5) / 32.0 - 1.0) * tangent;
            const double distance = slope > 0.0 ? 1.0 / slope : 1e9;
            const bool expect_hit = distance >= 1.0 && distance <= 50.0;
            const double depth = 50.0 * (distance - 1.0) / (distance * 49.0);
            for (int x = 0; x < 64; ++x) {
                const float stored = device.depth()[static_cast<size_t>(y * 64 + x)];
                const bool right =
                    expect_hit ? std::abs(stored - depth) < kHalfSnapOfSlope : stored == 1.0f;
                wrong += right ? 0 : 1;
                seen += expect_hit ? 1 : 0;
            }
        }
        EXPECT_EQ(wrong, 0u);
        EXPECT_GT(seen, 1500u);
    }
}

TEST(CpuDeviceDraw, FragmentsAtTheFarPlaneFailLessAgainstTheClearedTarget)
{
    TestScene scene;
    scene.add_rectangle({0, 0}, {8, 8}, 1.0f);
    scene.add_rectangle({0, 0}, {8, 8}, 0.0f);
    CpuDevice device(scene);
    draw_frame(device, pixel_view({8, 8}), {ItemId{0u}});
    EXPECT_EQ(covered(device), 0u);
    EXPECT_FALSE(device.owner(0).item.valid());
    draw_frame(device, pixel_view({8, 8}), {ItemId{1u}});
    EXPECT_EQ(owned_by(device, ItemId{1u}), 64u);
}

TEST(CpuDeviceDraw, EqualDepthsGoToTheSmallerItemAndTriangleWhateverTheOrder)
{
    TestScene scene;
    scene.add_rectangle({0, 0}, {8, 8}, 0.5f);
    scene.add_rectangle({0, 0}, {8, 8}, 0.5f);
    scene.add_rectangle({4, 0}, {8, 8}, 0.25f);
    // The same triangle twice in one item.
    scene.add({{{0, 8, 0.5f}, {8, 8, 0.5f}, {0, 16, 0.5f}}, {0, 1, 2, 0, 1, 2}});
    CpuDevice device(scene);
    const std::vector<std::vector<ItemId>> orders = {
        {ItemId{0u}, ItemId{1u}, ItemId{2u}, ItemId{3u}},
        {ItemId{3u}, ItemId{2u}, ItemId{1u}, ItemId{0u}},
        {ItemId{1u}, ItemId{2u}, ItemId{0u}, ItemId{3u}},
    };
    for (const std::vector<ItemId>& order : orders) {
        draw_frame(device, pixel_view({8, 16}), order);
        EXPECT_EQ(owned_by(device, ItemId{0u}), 32u);
        EXPECT_EQ(owned_by(device, ItemId{1u}), 0u);
        EXPECT_EQ(owned_by(device, ItemId{2u}), 32u);
        EXPECT_EQ(device.owner(8 * 8).item, ItemId{3u});
        EXPECT_EQ(device.owner(8 * 8).triangle, 0u);
    }
}

TEST(CpuDeviceDraw, ItemBoxOutsideOfTheViewRejectsTheItemAndOnlyThen)
{
    struct BoxedScene : TestScene {
        CpuItem item(ItemId id) const override
        {
            CpuItem result = TestScene::item(id);
            result.box = box;
            return result;
        }
        Aabb box;
    };
    BoxedScene scene;
    scene.add_rectangle({2, 2}, {4, 4}, 0.5f);
    CpuDevice device(scene);
    scene.box = {{2, 2, 0.5f}, {4, 4, 0.5f}};
    draw_frame(device, pixel_view({8, 8}), scene.all());
    EXPECT_EQ(covered(device), 4u);
    scene.box = {{9, 2, 0.5f}, {12, 4, 0.5f}};
    draw_frame(device, pixel_view({8, 8}), scene.all());
    EXPECT_EQ(covered(device), 0u);
    scene.box = {{-1, -1, -1.0f}, {12, 12, 3.0f}};
    draw_frame(device, pixel_view({8, 8}), scene.all());
    EXPECT_EQ(covered(device), 4u);
}

} // namespace
} // namespace occlude
