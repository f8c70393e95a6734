// CpuFastDevice culls exactly what may be culled while another device draws.
#include "cpu_fast/box_occluders.h"
#include "support/box_scene.h"

#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/backends/cpu_fast/cpu_fast_device.h>
#include <occlude/core/rng.h>
#include <occlude/cull/registry.h>
#include <occlude/hierarchy/builders/bvh_builder.h>

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include <memory>
#include <string>
#include <vector>

namespace occlude {
namespace {

struct Walk {
    std::vector<ItemBounds> bounds;
    test::BoxOccluders occluders;
    Hierarchy hierarchy;

    explicit Walk(uint64_t seed, size_t count)
    {
        Rng rng(seed);
        std::vector<Aabb> boxes;
        for (size_t i = 0; i < count; ++i) {
            const auto at = [&] { return (uniform01(rng.next()) - 0.5f) * 40.0f; };
            const float x = at();
            const glm::vec3 low{x, at() * 0.2f, at()};
            const float size = 0.3f + 3.0f * uniform01(rng.next());
            boxes.push_back({low, low + glm::vec3{size, 2.0f * size, size}});
            bounds.push_back({boxes.back(), 12});
        }
        occluders.set(boxes);
        hierarchy = build_bvh(bounds);
    }
    static View view(int frame, glm::ivec2 size)
    {
        const float angle = 0.13f * static_cast<float>(frame);
        const glm::vec3 eye{12.0f * std::sin(angle), 1.0f, 24.0f * std::cos(0.7f * angle)};
        const glm::vec3 target = frame % 7 == 6 ? -eye : glm::vec3{0.0f}; // teleports
        return View::from_clip(
            glm::perspective(1.0f, 1.6f, 0.1f, 200.0f) *
                glm::lookAt(eye, target + glm::vec3{0.1f, 0.0f, 0.2f}, glm::vec3{0.0f, 1.0f, 0.0f}),
            size);
    }
};

TEST(CpuFastDevice, EveryExactAlgorithmShowsThePixelsOfAllItemsAndCulls)
{
    constexpr glm::ivec2 kSize{161, 101};
    Walk walk(5, 400);
    const test::BoxCpuScene drawn(walk.bounds);
    std::vector<ItemId> all;
    for (size_t i = 0; i < walk.bounds.size(); ++i) {
        all.push_back(ItemId{i});
    }
    for (const std::string name :
         {"two_phase", "lazy_grid", "chc_plus_plus", "adaptive", "stop_and_wait", "statistical"}) {
        SCOPED_TRACE(name);
        CpuDevice renderer(drawn);
        CpuDevice reference(drawn);
        CpuFastDevice device(&renderer, walk.occluders,
                             {.buffer = {.cell_px = 1}, .min_px_per_triangle = 0.0f});
        const auto culler = make_culler(name, walk.hierarchy);
        ASSERT_TRUE(culler);
        uint64_t items = 0;
        uint64_t in_frustum = 0;
        for (int frame = 0; frame < 28; ++frame) {
            const View view = Walk::view(frame, kSize);
            items += (*culler)->cull(view, device).counters.items_drawn;
            reference.begin_frame(view);
            reference.draw(all, DrawPass::shade);
            reference.end_frame();
            for (const ItemBounds& item : walk.bounds) {
                in_frustum += view.frustum().classify(item.box) != Containment::outside ? 1 : 0;
            }
            ASSERT_TRUE(std::ranges::equal(renderer.depth(), reference.depth()))
                << "frame " << frame;
        }
        if (name != "statistical") { // its pauses between tests are longer than this walk
            EXPECT_LT(items, in_frustum * 8 / 10) << "of " << in_frustum;
        }
    }
}

double fake_us = 0.0;

double fake_clock()
{
    return fake_us += 7.0; // so long takes everything between two looks at it
}

TEST(CpuFastDevice, ABudgetOfTimeEndsInTimeAndTakesTheBestOccludersFirst)
{
    Walk walk(5, 400);
    const View view = Walk::view(1, {641, 401});
    std::vector<ItemId> all;
    for (size_t i = 0; i < walk.bounds.size(); ++i) {
        all.push_back(ItemId{i});
    }
    const auto run = [&](float budget_us) {
        CpuFastDevice device(nullptr, walk.occluders,
                             {.budget_us = budget_us, .clock_us = &fake_clock});
        uint64_t triangles = 0;
        for (int frame = 0; frame < 5; ++frame) {
            device.begin_frame(view);
            device.draw(all, DrawPass::shade);
            std::vector<float> depth(641 * 401);
            EXPECT_TRUE(device.read_depth({0, 0, 641, 401}, depth));
            device.end_frame();
            EXPECT_LE(device.spent_us(), budget_us + 14.0f) << "a look at the clock or two";
            triangles = device.occluders().statistics().triangles;
        }
        return triangles;
    };
    const uint64_t little = run(60.0f);
    const uint64_t much = run(3000.0f);
    EXPECT_GT(little, 0u);
    EXPECT_GT(much, little);
}

TEST(CpuFastDevice, ABudgetKeepsTheOccludersThatHideMostPerTriangle)
{
    test::BoxOccluders scene;
    const Aabb wall{{-3.0f, -3.0f, -6.0f}, {3.0f, 3.0f, -5.0f}};
    const Aabb pebble{{-0.2f, -0.2f, -4.0f}, {0.2f, 0.2f, -3.5f}};
    scene.set(std::vector{pebble, wall});
    const View view =
        View::from_clip(glm::perspective(1.0f, 1.0f, 0.1f, 100.0f), glm::ivec2{128, 128});
    const auto hidden = [&](const CpuFastDeviceOptions& options) {
        CpuFastDevice device(nullptr, scene, options);
        device.begin_frame(view);
        const std::vector<ItemId> items{ItemId{size_t{0}}, ItemId{size_t{1}}};
        device.draw(items, DrawPass::shade);
        const QueryBox box{{{1.0f, 1.0f, -9.0f}, {2.0f, 2.0f, -8.0f}}, nullptr, {}};
        const uint32_t end = 1;
        Ticket ticket;
        device.query({std::span{&box, 1}, std::span{&end, 1}}, std::span{&ticket, 1});
        device.end_frame();
        EXPECT_LE(device.occluders().statistics().triangles,
                  options.max_triangles != 0 ? options.max_triangles : 24u);
        return device.wait(ticket).samples == 0;
    };
    EXPECT_TRUE(hidden({}));
    EXPECT_TRUE(hidden({.max_triangles = 12})) << "the wall fits";
    EXPECT_FALSE(hidden({.max_triangles = 11})) << "nothing fits: visible, never wrong";
    EXPECT_FALSE(hidden({.min_px_per_triangle = 1e6f}));
}

} // namespace
} // namespace occlude
