#include <occlude/integration/verify_frame.h>

#include "support/box_scene.h"

#include <occlude/cull/chc_plus_plus.h>
#include <occlude/cull/frustum_culler.h>
#include <occlude/cull/two_phase.h>
#include <occlude/device/forwarding_device.h>
#include <occlude/device/scripted_device.h>
#include <occlude/hierarchy/builders/bvh_builder.h>

#include <gtest/gtest.h>

#include <glm/ext/matrix_clip_space.hpp>

namespace occlude {
namespace {

// A wall, and behind it a row of boxes. The last box is partly visible at the right.
std::vector<ItemBounds> wall_and_boxes()
{
    std::vector<ItemBounds> items{{{{-6.0f, -4.0f, -6.0f}, {2.0f, 4.0f, -5.5f}}, 12}};
    for (int i = 0; i < 4; ++i) {
        const glm::vec3 low{-3.0f + 2.0f * static_cast<float>(i), -0.5f, -10.0f};
        items.push_back({{low, low + 1.0f}, 12});
    }
    return items;
}

const View& view()
{
    static const View kView = View::from_clip(glm::perspective(1.2f, 1.5f, 0.5f, 60.0f), {96, 64});
    return kView;
}

TEST(VerifyFrame, AnExactFrameLacksNothing)
{
    const std::vector<ItemBounds> items = wall_and_boxes();
    const test::BoxCpuScene scene(items);
    CpuDevice device(scene);
    const Hierarchy hierarchy = build_bvh(items, {.max_leaf_items = 1, .leaf_triangles = 12});
    ChcPlusPlus culler{hierarchy};
    for (int frame = 0; frame < 3; ++frame) {
        const auto check = verify_frame(culler, view(), device);
        ASSERT_TRUE(check);
        EXPECT_TRUE(check->missing.empty());
        EXPECT_GT(check->items_checked, 0u) << "something is hidden";
    }
}

TEST(VerifyFrame, AnItemHiddenByABoxThatIsTooSmallIsNamedWithItsNode)
{
    std::vector<ItemBounds> items = wall_and_boxes();
    items[2].box.max = {6.0f, 0.5f, -9.0f}; // reaches out from behind the wall ...
    const test::BoxCpuScene scene(items);
    items[2].box.max.x = 0.0f; // ... and its box does not
    const Hierarchy hierarchy = build_bvh(items, {.max_leaf_items = 1, .leaf_triangles = 12});
    // With the device's queries, and with its depth.
    for (const bool counts : {true, false}) {
        CpuDevice cpu(scene);
        class NoCounts final : public ForwardingDevice {
        public:
            NoCounts(QueryDevice& inner, bool can_count)
                : ForwardingDevice(inner)
                , caps_(inner.caps())
            {
                caps_.draw_and_query = can_count;
            }
            const DeviceCaps& caps() const override { return caps_; }

        private:
            DeviceCaps caps_;
        } device(cpu, counts);
        ChcPlusPlus culler{hierarchy};
        verify_frame(culler, view(), device);
        const auto check = verify_frame(culler, view(), device);
        ASSERT_TRUE(check);
        ASSERT_EQ(check->missing.size(), 1u) << counts;
        const MissedItem& missed = check->missing[0];
        EXPECT_EQ(missed.item, ItemId{2u});
        EXPECT_GT(missed.samples, 0u);
        ASSERT_TRUE(missed.node.valid());
        EXPECT_FALSE(is_drawn(missed.decision));
        EXPECT_NE(missed.text.find("item 2 is missing"), std::string::npos) << missed.text;
    }
}

TEST(VerifyFrame, ABoxOutsideOfTheFrustumWhoseItemIsNotIsFound)
{
    std::vector<ItemBounds> items = wall_and_boxes();
    const test::BoxCpuScene scene(items);
    items[4].box = {{100.0f, 0.0f, 0.0f}, {101.0f, 1.0f, 1.0f}};
    CpuDevice device(scene);
    const Hierarchy hierarchy = build_bvh(items, {.max_leaf_items = 1, .leaf_triangles = 12});
    FrustumCuller culler{hierarchy};
    const auto check = verify_frame(culler, view(), device);
    ASSERT_TRUE(check);
    ASSERT_EQ(check->missing.size(), 1u);
    EXPECT_EQ(check->missing[0].item, ItemId{4u});
    EXPECT_EQ(check->missing[0].decision, Decision::outside);
}

TEST(VerifyFrame, ADeviceThatCanNeitherCountNorReadIsRefused)
{
    const Hierarchy hierarchy = build_bvh(wall_and_boxes());
    FrustumCuller culler{hierarchy};
    ScriptedDevice device;
    EXPECT_FALSE(verify_frame(culler, view(), device));
}

} // namespace
} // namespace occlude
