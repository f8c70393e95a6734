// Item flags work with every algorithm, because CullFrame handles them.
#include <occlude/cull/oracle_cullers.h>
#include <occlude/cull/registry.h>

#include "support/trees.h"

#include <occlude/device/counting_device.h>
#include <occlude/device/scripted_device.h>
#include <occlude/device/validating_device.h>
#include <occlude/scene/scene.h>

#include <gtest/gtest.h>

#include <map>

namespace occlude {
namespace {

using test::look_ahead;

// row_tree(2) with flags: items 0 to 3 one behind the other, in nodes 3 to 6.
Hierarchy flagged_row(const std::map<uint32_t, ItemFlags>& flags)
{
    const Hierarchy plain = test::row_tree(2);
    std::vector<ItemBounds> bounds(plain.item_bounds().begin(), plain.item_bounds().end());
    for (const auto& [item, flag] : flags) {
        bounds[item].flags = flag;
    }
    return Hierarchy::from_arrays({plain.nodes().begin(), plain.nodes().end()},
                                  {plain.items().begin(), plain.items().end()}, bounds);
}

std::unique_ptr<Culler> make(const std::string& name, const Hierarchy& tree)
{
    return std::move(make_culler(name, tree).value());
}

TEST(ItemFlags, AHierarchyListsTheItemsDrawnOutOfTurn)
{
    const Hierarchy tree = flagged_row({{1, ItemFlags::never_cull}, {3, ItemFlags::alpha_tested}});
    ASSERT_EQ(tree.flagged_items().size(), 1u); // alpha-tested items are drawn like others
    EXPECT_EQ(tree.flagged_items()[0].item, ItemId{1u});
    EXPECT_FALSE(test::row_tree(2).has_flags());
}

TEST(ItemFlags, ASceneAndABvhHandThemOn)
{
    Scene scene;
    const std::array items{ItemDesc{{glm::vec3{0.0f}, glm::vec3{1.0f}}, 1, ItemFlags::none},
                           ItemDesc{{glm::vec3{2.0f}, glm::vec3{3.0f}}, 1, ItemFlags::translucent}};
    const ObjectId object = scene.add(glm::mat4{1.0f}, items);
    const Hierarchy tree = build_bvh(scene.item_bounds(), {.leaf_triangles = 1});
    ASSERT_EQ(tree.flagged_items().size(), 1u);
    EXPECT_EQ(tree.flagged_items()[0].item, ItemId{1u});
    EXPECT_EQ(tree.item(tree.flagged_items()[0].position), ItemId{1u});
    scene.remove(object);
    EXPECT_EQ(scene.item_flags(ItemId{1u}), ItemFlags::none);
}

TEST(ItemFlags, TranslucentItemsAreDrawnAfterAllOthersBackToFront)
{
    const Hierarchy tree = flagged_row({{0, ItemFlags::translucent}, {2, ItemFlags::translucent}});
    ScriptedDevice device;
    make("frustum", tree)->cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0), "draw 1 3\ndraw 2 0\n");
}

TEST(ItemFlags, ATranslucentItemOfAHiddenNodeIsNotDrawn)
{
    const Hierarchy tree = flagged_row({{0, ItemFlags::translucent}, {3, ItemFlags::translucent}});
    ScriptedDevice device({.boxes = visible_subjects({NodeId{0u}, NodeId{1u}, NodeId{3u}})});
    const auto culler = make("stop_and_wait", tree);
    culler->cull(look_ahead(), device);
    EXPECT_EQ(std::vector<ItemId>(culler->drawn_items().begin(), culler->drawn_items().end()),
              std::vector<ItemId>{ItemId{0u}});
}

TEST(ItemFlags, AnItemThatNeverOccludesIsDrawnAfterAllTests)
{
    const Hierarchy tree = flagged_row({{0, ItemFlags::never_occlude}});
    ScriptedDevice device;
    make("stop_and_wait", tree)->cull(look_ahead(), device);
    const std::string text = device.frame_text(0);
    EXPECT_GT(text.find("draw 3 0\n"), text.rfind("query"));
}

TEST(ItemFlags, AnItemThatIsNeverCulledIsDrawnFirstInHiddenNodesAndBehindTheCamera)
{
    const Hierarchy tree = flagged_row({{3, ItemFlags::never_cull}});
    ScriptedDevice device({.boxes = visible_subjects({})});
    const auto culler = make("stop_and_wait", tree);
    culler->cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0), "draw 3\nquery [0]\nflush\nwait 0 -> 0\n");
    culler->cull(test::look({0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}), device);
    EXPECT_EQ(device.frame_text(1), "draw 3\n");
}

TEST(ItemFlags, ARemovedItemIsNotDrawnAlthoughItIsNeverCulled)
{
    Hierarchy tree = flagged_row({{3, ItemFlags::never_cull}});
    std::vector<ItemBounds> bounds(tree.item_bounds().begin(), tree.item_bounds().end());
    bounds[3].box = Aabb::empty();
    tree.refit(bounds);
    ScriptedDevice device;
    make("frustum", tree)->cull(look_ahead(), device);
    EXPECT_EQ(device.frame_text(0), "draw 0 1 2\n");
}

TEST(ItemFlags, AfterADepthOnlyPassTranslucentItemsAreShadedLast)
{
    const Hierarchy tree = flagged_row({{1, ItemFlags::translucent}});
    ScriptedDevice device;
    const OptionValue depth_only{"depth_only_pass", "true"};
    const auto culler = std::move(make_culler("chc_plus_plus", tree, {&depth_only, 1}).value());
    culler->cull(look_ahead(), device);
    const std::string text = device.frame_text(0);
    EXPECT_NE(text.find("draw shade_equal 0 2 3\ndraw 1\n"), std::string::npos) << text;
}

TEST(ItemFlags, EveryAlgorithmCountsAndDrawsEachItemOnce)
{
    std::vector<ItemBounds> boxes = test::random_boxes(300, 77);
    std::vector<uint32_t> triangles;
    for (size_t i = 0; i < boxes.size(); ++i) {
        boxes[i].flags = static_cast<ItemFlags>(i % 7 == 0 ? (i / 7) % 8 : 0);
        triangles.push_back(boxes[i].triangles);
    }
    const Hierarchy tree = build_bvh(boxes, {.leaf_triangles = 300});
    for (const AlgorithmInfo& info : algorithms()) {
        SCOPED_TRACE(info.name);
        DeviceScript script;
        script.caps.draw_and_query = true;
        ScriptedDevice scripted(script);
        std::vector<std::string> violations;
        ValidatingDevice valid(scripted,
                               {.on_violation = [&](std::string_view rule, std::string_view text) {
                                   violations.push_back(std::string{rule} + std::string{text});
                               }});
        CountingDevice device(valid, {.triangles_by_item = triangles});
        const auto culler = make(info.name, tree);
        for (int frame = 0; frame < 4; ++frame) {
            const View view = test::look({0.0f, 0.0f, 60.0f}, {0.0f, 0.0f, 0.0f});
            if (auto* oracle = dynamic_cast<OracleCuller*>(culler.get())) {
                oracle->record(view, device, {});
            }
            const FrameReport report = culler->cull(view, device);
            EXPECT_EQ(report.counters.items_drawn, device.frame().items_drawn);
            EXPECT_EQ(report.counters.triangles_drawn, device.frame().triangles_drawn);
            EXPECT_EQ(report.counters.items_drawn, culler->drawn_items().size());
        }
        EXPECT_EQ(violations, std::vector<std::string>{});
    }
}

} // namespace
} // namespace occlude
