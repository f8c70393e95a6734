// CpuFastDevice keeps the contract of devices, and culls exactly what may be culled while another
// device draws.
#include "support/box_scene.h"

#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/backends/cpu_fast/cpu_fast_device.h>
#include <occlude/conformance/conformance.h>
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

OccluderMesh box_mesh(const Aabb& box)
{
    std::vector<glm::vec3> corners;
    for (int i = 0; i < 8; ++i) {
        corners.emplace_back((i & 1) != 0 ? box.max.x : box.min.x,
                             (i & 2) != 0 ? box.max.y : box.min.y,
                             (i & 4) != 0 ? box.max.z : box.min.z);
    }
    const std::vector<uint16_t> indices{0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                        2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    return OccluderMesh::prepare(PositionStream(corners), indices);
}

class BoxOccluders final : public CpuFastScene {
public:
    void set(std::span<const Aabb> boxes)
    {
        meshes_.clear();
        for (const Aabb& box : boxes) {
            meshes_.push_back(box_mesh(box));
        }
    }
    CpuFastItem item(ItemId item) const override
    {
        return item.value < meshes_.size() ? CpuFastItem{&meshes_[item.value]} : CpuFastItem{};
    }

private:
    std::vector<OccluderMesh> meshes_;
};

class CpuFastHost final : public conformance::Host {
public:
    CpuFastHost(ClipConvention convention, int cell_px)
        : convention_(convention)
        , device_(
              nullptr, scene_,
              {.buffer = {.cell_px = cell_px}, .min_px_per_triangle = 0.0f, .max_outstanding = 200})
    {
    }
    QueryDevice& device() override { return device_; }
    void set_items(std::span<const Aabb> boxes) override { scene_.set(boxes); }
    ClipConvention convention() const override { return convention_; }

private:
    ClipConvention convention_;
    BoxOccluders scene_;
    CpuFastDevice device_;
};

TEST(CpuFastDevice, KeepsTheContractInEveryConventionAndResolution)
{
    for (const DepthRange range : {DepthRange::minus_one_to_one, DepthRange::zero_to_one}) {
        for (const DepthOrder order : {DepthOrder::near_is_small, DepthOrder::near_is_large}) {
            for (const int cell_px : {1, 2}) {
                CpuFastHost host({range, order}, cell_px);
                const conformance::Report report =
                    conformance::check_device(host, {.worlds = 2, .depth_may_be_farther = true});
                EXPECT_TRUE(report.passed()) << to_string(report);
                EXPECT_GT(report.hidden, 5u);
            }
        }
    }
}

struct Walk {
    std::vector<ItemBounds> bounds;
    BoxOccluders occluders;
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
        CpuFastDevice device(&renderer, walk.occluders, {.min_px_per_triangle = 0.0f});
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

TEST(CpuFastDevice, ABudgetKeepsTheOccludersThatHideMostPerTriangle)
{
    BoxOccluders scene;
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
