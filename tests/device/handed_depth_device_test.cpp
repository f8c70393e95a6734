#include <occlude/device/handed_depth_device.h>

#include "support/box_scene.h"

#include <occlude/cull/chc_plus_plus.h>
#include <occlude/cull/stop_and_wait.h>
#include <occlude/cull/two_phase.h>
#include <occlude/device/validating_device.h>
#include <occlude/hierarchy/builders/bvh_builder.h>

#include <gtest/gtest.h>

#include <glm/ext/matrix_clip_space.hpp>

#include <algorithm>
#include <memory>
#include <set>

namespace occlude {
namespace {

// A wall, and behind it a row of boxes. The last box is partly visible at the right.
std::vector<ItemBounds> wall_and_boxes()
{
    std::vector<ItemBounds> items{{{{-6.0f, -4.0f, -6.0f}, {2.0f, 4.0f, -5.5f}}, 12}};
    for (int i = 0; i < 6; ++i) {
        const glm::vec3 low{-5.0f + 2.0f * static_cast<float>(i), -0.5f, -10.0f};
        items.push_back({{low, low + 1.0f}, 12});
    }
    return items;
}

const View& view()
{
    static const View kView = View::from_clip(glm::perspective(1.2f, 1.5f, 0.5f, 60.0f), {96, 64});
    return kView;
}

std::vector<std::unique_ptr<Culler>> cullers(const Hierarchy& hierarchy)
{
    std::vector<std::unique_ptr<Culler>> all;
    all.push_back(std::make_unique<StopAndWait>(hierarchy));
    all.push_back(std::make_unique<ChcPlusPlus>(hierarchy));
    all.push_back(std::make_unique<TwoPhase>(hierarchy));
    return all;
}

TEST(HandedDepthDevice, TheListHoldsEveryItemThatOwnsAPixelAndNotAll)
{
    const std::vector<ItemBounds> items = wall_and_boxes();
    const test::BoxCpuScene scene(items);
    CpuDevice cpu(scene);
    std::vector<ItemId> all;
    for (size_t i = 0; i < items.size(); ++i) {
        all.push_back(ItemId{i});
    }
    cpu.begin_frame(view());
    cpu.draw(all, DrawPass::shade);
    std::set<ItemId> owners;
    for (size_t pixel = 0; pixel < cpu.depth().size(); ++pixel) {
        if (cpu.owner(pixel).item.valid()) {
            owners.insert(cpu.owner(pixel).item);
        }
    }
    ASSERT_LT(owners.size(), items.size()) << "something is hidden";

    HandedDepthDevice handed;
    handed.hand_over(cpu.size_px(), cpu.depth());
    ValidatingDevice device{handed};
    const Hierarchy hierarchy = build_bvh(items, {.leaf_triangles = 12});
    for (const auto& culler : cullers(hierarchy)) {
        for (int frame = 0; frame < 3; ++frame) {
            culler->cull(view(), device);
        }
        const auto list = culler->drawn_items();
        for (const ItemId owner : owners) {
            EXPECT_TRUE(std::ranges::find(list, owner) != list.end()) << owner.value;
        }
        EXPECT_LT(list.size(), items.size());
    }
}

TEST(HandedDepthDevice, WithoutDepthOrWithDepthOfAnotherSizeNothingIsHidden)
{
    const std::vector<ItemBounds> items = wall_and_boxes();
    const Hierarchy hierarchy = build_bvh(items, {.leaf_triangles = 12});
    HandedDepthDevice device;
    const std::vector<float> near_everywhere(32 * 32, 0.0f);
    for (const bool handed : {false, true}) {
        if (handed) {
            device.hand_over({32, 32}, near_everywhere);
        }
        for (const auto& culler : cullers(hierarchy)) {
            culler->cull(view(), device);
            EXPECT_EQ(culler->drawn_items().size(), items.size());
        }
    }
}

} // namespace
} // namespace occlude
