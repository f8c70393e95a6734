// One hierarchy, several views: two eyes, split screen, a shadow map and a reflection. They are
// interleaved on one device, and side by side on several threads, while objects appear, disappear
// and move.
#include "support/box_scene.h"
#include "support/trees.h"

#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/cull/oracle_cullers.h>
#include <occlude/cull/registry.h>
#include <occlude/device/delaying_device.h>
#include <occlude/device/validating_device.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <thread>

namespace occlude {
namespace {

constexpr int kFrames = 10;

View perspective(const glm::vec3& eye, const glm::vec3& target, glm::ivec2 size,
                 const glm::mat4& world = glm::mat4{1.0f})
{
    const float aspect = static_cast<float>(size.x) / static_cast<float>(size.y);
    return View::from_clip(glm::perspectiveRH_NO(1.2f, aspect, 0.1f, 300.0f) *
                               glm::lookAtRH(eye, target, glm::vec3{0.0f, 1.0f, 0.0f}) * world,
                           size);
}

/// Left eye, right eye, the other half of a split screen, the sun's shadow map, a mirror's image.
std::vector<View> views_of_frame(int frame)
{
    const float t = static_cast<float>(frame);
    const glm::vec3 eye{-40.0f + 3.0f * t, 2.0f, 30.0f};
    const glm::vec3 target{0.0f, 0.0f, -30.0f + t};
    const glm::vec3 apart{0.065f, 0.0f, 0.0f};
    const glm::mat4 sun =
        glm::orthoRH_NO(-70.0f, 70.0f, -70.0f, 70.0f, 1.0f, 300.0f) *
        glm::lookAtRH(glm::vec3{80.0f, 90.0f, 30.0f}, glm::vec3{0.0f}, glm::vec3{0.0f, 1.0f, 0.0f});
    const glm::mat4 mirror = glm::scale(glm::mat4{1.0f}, glm::vec3{1.0f, -1.0f, 1.0f});
    return {perspective(eye, target, {80, 60}), perspective(eye + apart, target + apart, {80, 60}),
            perspective({50.0f, -3.0f, -40.0f + t}, {-20.0f, 0.0f, 0.0f}, {40, 60}),
            View::from_clip(sun, {64, 64}), perspective(eye, target, {60, 40}, mirror)};
}

struct Picture {
    std::vector<float> depth;
    std::vector<uint32_t> owners;

    bool operator==(const Picture&) const = default;
};

Picture picture_of(const CpuDevice& device)
{
    return {{device.depth().begin(), device.depth().end()}, test::owners(device)};
}

Picture everything(const test::BoxCpuScene& scene, size_t items, const View& view)
{
    CpuDevice device(scene);
    test::draw_everything(device, items, view);
    return picture_of(device);
}

/// A few walls and many boxes.
std::vector<ItemBounds> city()
{
    std::vector<ItemBounds> items = test::random_boxes(500, 11, 45.0f, 6.0f);
    Rng rng{4};
    for (int i = 0; i < 12; ++i) {
        const glm::vec3 at{rng.range(-40, 40), rng.range(-10, 10), rng.range(-40, 40)};
        glm::vec3 half{12.0f, 12.0f, 0.5f};
        if (i % 2 == 0) {
            std::swap(half.x, half.z);
        }
        items.push_back({{at - half, at + half}, 12});
    }
    return items;
}

class ManyViews : public testing::TestWithParam<std::string> {
protected:
    static std::unique_ptr<Culler> culler_of(const Hierarchy& tree)
    {
        const std::array finish{OptionValue{"finish", "true"}};
        auto made = make_culler(GetParam(), tree,
                                std::span{finish}.first(GetParam() == "prioritized" ? 1 : 0));
        EXPECT_TRUE(made);
        return std::move(*made);
    }
};

// Moves one item in twenty, and makes one in four of these disappear. Returns them.
std::vector<ItemId> move_some(std::vector<ItemBounds>& items, Rng& rng)
{
    std::vector<ItemId> moved;
    for (uint32_t i = 0; i < items.size(); ++i) {
        if (rng.below(20) == 0) {
            moved.push_back(ItemId{i});
            const glm::vec3 at{rng.range(-45, 45), rng.range(-20, 20), rng.range(-45, 45)};
            const float half = rng.range(0.2f, 4.0f);
            items[i].box = rng.below(4) == 0 ? Aabb{} : Aabb{at - half, at + half};
        }
    }
    return moved;
}

// Five cullers take turns on one device, whose answers come late and sometimes never. The objects
// move and disappear, and their numbers go to others.
TEST_P(ManyViews, TakeTurnsOnOneDeviceWhileObjectsComeAndGo)
{
    for (const char* kind : {"bvh", "octree", "two_level"}) {
        std::vector<ItemBounds> items = city();
        Hierarchy tree = find_hierarchy_kind(kind)->build(items, 24);
        auto scene = std::make_unique<test::BoxCpuScene>(items);
        std::vector<std::unique_ptr<Culler>> cullers;
        for (size_t i = 0; i < views_of_frame(0).size(); ++i) {
            cullers.push_back(culler_of(tree));
        }
        // The device outlives changes of the scene, and reads triangles through this.
        struct Current final : CpuScene {
            std::unique_ptr<test::BoxCpuScene>& scene;
            explicit Current(std::unique_ptr<test::BoxCpuScene>& s)
                : scene(s)
            {
            }
            CpuItem item(ItemId item) const override { return scene->item(item); }
        } current{scene};
        CpuDevice cpu(current, {.max_outstanding = 300});
        DelayingDevice late(cpu, {.seed = 8, .max_polls = 4, .max_frames = 2, .lose_every = 11});
        std::string violation;
        ValidatingDevice device(
            late, {.on_violation = [&](std::string_view rule, std::string_view message) {
                if (rule != "C11") { // five cullers share 300 tickets; further tests are lost
                    violation = std::string{rule} + ": " + std::string{message};
                }
            }});
        Rng rng{hash64(17)};
        uint64_t drawn = 0;
        for (int frame = 0; frame < kFrames; ++frame) {
            tree.refit(move_some(items, rng), items);
            std::vector<ItemBounds> drawable = items;
            scene = std::make_unique<test::BoxCpuScene>(drawable);
            const std::vector<View> views = views_of_frame(frame);
            for (size_t v = 0; v < views.size(); ++v) {
                if (frame == 6 && v == 2) {
                    cullers[v]->reset(); // a cut in one view does not affect the others
                }
                if (auto* oracle = dynamic_cast<OracleCuller*>(cullers[v].get())) {
                    oracle->record(views[v], device, {});
                }
                const FrameReport report = cullers[v]->cull(views[v], device);
                ASSERT_EQ(violation, "");
                drawn += cullers[v]->drawn_items().size();
                if (report.guarantee == Guarantee::exact()) {
                    ASSERT_EQ(picture_of(cpu), everything(*scene, items.size(), views[v]))
                        << kind << ", frame " << frame << ", view " << v;
                }
            }
        }
        EXPECT_GT(drawn, items.size()); // the views are not empty
        EXPECT_LT(drawn, items.size() * kFrames * 5);
    }
}

// Each view has its own thread and device, over one tree that is const meanwhile. The pictures
// equal those of one view after the other. ThreadSanitizer runs this, too.
TEST_P(ManyViews, RunOnSeveralThreadsOverOneTree)
{
    std::vector<ItemBounds> items = city();
    const Hierarchy tree = find_hierarchy_kind("bvh")->build(items, 24);
    const test::BoxCpuScene scene(items);
    const size_t count = views_of_frame(0).size();
    const auto walk = [&](size_t view, std::vector<Picture>& pictures) {
        CpuDevice device(scene);
        const std::unique_ptr<Culler> culler = culler_of(tree);
        for (int frame = 0; frame < kFrames; ++frame) {
            const View seen = views_of_frame(frame)[view];
            if (auto* oracle = dynamic_cast<OracleCuller*>(culler.get())) {
                oracle->record(seen, device, {});
            }
            culler->cull(seen, device);
            pictures.push_back(picture_of(device));
        }
    };
    std::vector<std::vector<Picture>> alone(count);
    std::vector<std::vector<Picture>> together(count);
    for (size_t view = 0; view < count; ++view) {
        walk(view, alone[view]);
    }
    std::vector<std::thread> threads;
    for (size_t view = 0; view < count; ++view) {
        threads.emplace_back([&, view] { walk(view, together[view]); });
    }
    for (std::thread& thread : threads) {
        thread.join();
    }
    EXPECT_EQ(alone, together);
}

// The caller does not report the camera's cut. The image is right in the same frame, and one frame
// later the culler draws hardly more than one that was reset.
TEST_P(ManyViews, FindACameraCutByThemselves)
{
    const std::vector<ItemBounds> items = city();
    const Hierarchy tree = find_hierarchy_kind("bvh")->build(items, 24);
    const test::BoxCpuScene scene(items);
    CpuDevice device(scene);
    CpuDevice fresh_device(scene);
    const std::unique_ptr<Culler> culler = culler_of(tree);
    const View before = perspective({-60.0f, 3.0f, 0.0f}, {60.0f, 0.0f, 0.0f}, {80, 60});
    const View after = perspective({60.0f, -5.0f, 40.0f}, {-60.0f, 0.0f, 0.0f}, {80, 60});
    const auto cull = [](Culler& c, CpuDevice& d, const View& view) {
        if (auto* oracle = dynamic_cast<OracleCuller*>(&c)) {
            oracle->record(view, d, {});
        }
        return c.cull(view, d).guarantee;
    };
    for (int frame = 0; frame < 6; ++frame) {
        cull(*culler, device, before);
    }
    const std::unique_ptr<Culler> fresh = culler_of(tree);
    for (int frame = 0; frame < 3; ++frame) {
        const bool exact = cull(*culler, device, after) == Guarantee::exact();
        cull(*fresh, fresh_device, after);
        if (exact) {
            EXPECT_EQ(picture_of(device), everything(scene, items.size(), after)) << frame;
        }
    }
    EXPECT_LE(culler->drawn_items().size(), 2 * fresh->drawn_items().size() + 50);
}

std::vector<std::string> names()
{
    std::vector<std::string> all;
    for (const AlgorithmInfo& info : algorithms()) {
        if (info.name != "ideal") { // it needs the owner of each pixel
            all.push_back(info.name);
        }
    }
    return all;
}
INSTANTIATE_TEST_SUITE_P(Every, ManyViews, testing::ValuesIn(names()),
                         [](const auto& info) { return info.param; });

} // namespace
} // namespace occlude
