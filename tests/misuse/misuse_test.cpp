// Every precondition of the public API that a caller can violate unnoticed: debug builds assert
// with a sentence; release builds have a safe result ("visible", or nothing done).
#include "misuse/misuse.h"

#include "support/box_scene.h"
#include "support/trees.h"

#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/cull/oracle_cullers.h>
#include <occlude/cull/registry.h>
#include <occlude/device/scripted_device.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>
#include <occlude/hierarchy/builders/two_level.h>
#include <occlude/scene/animated_bounds.h>
#include <occlude/scene/camera_path.h>
#include <occlude/scene/partition.h>
#include <occlude/scene/scene.h>
#include <occlude/scene/split.h>
#include <occlude/scene/tight_boxes.h>
#include <occlude/screen/depth_pyramid.h>
#include <occlude/screen/projection.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>

namespace occlude {
namespace {

using test::Mistakes;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// A wall before a row of boxes.
std::vector<ItemBounds> wall_and_boxes()
{
    std::vector<ItemBounds> items{{{{-40, -40, -6}, {40, 40, -5}}, 100}};
    for (int i = 0; i < 20; ++i) {
        const glm::vec3 at{static_cast<float>(i - 10), 0.0f, -20.0f - static_cast<float>(i)};
        items.push_back({{at - 0.4f, at + 0.4f}, 50});
    }
    return items;
}

// --- boxes and views, over every algorithm ---

class EveryAlgorithm : public testing::TestWithParam<std::string> {
protected:
    /// Culls three frames and returns how many of them drew `item`.
    static int times_drawn(const Hierarchy& tree, QueryDevice& device, const View& view,
                           ItemId item)
    {
        const std::array finish{OptionValue{"finish", "true"}};
        auto culler = make_culler(GetParam(), tree,
                                  std::span{finish}.first(GetParam() == "prioritized" ? 1 : 0));
        EXPECT_TRUE(culler);
        int times = 0;
        for (int frame = 0; frame < 3; ++frame) {
            if (auto* oracle = dynamic_cast<OracleCuller*>(culler->get())) {
                const std::array owners{item};
                oracle->record(view, device, owners);
            }
            (*culler)->cull(view, device);
            const auto drawn = (*culler)->drawn_items();
            times += std::find(drawn.begin(), drawn.end(), item) != drawn.end() ? 1 : 0;
        }
        return times;
    }
};

TEST_P(EveryAlgorithm, DrawsItemsWhoseBoxesAreNaNOrInfiniteInEveryFrame)
{
    for (const float bad : {kNaN, kInfinity}) {
        for (const HierarchyKind& kind : hierarchy_kinds()) {
            std::vector<ItemBounds> items = wall_and_boxes();
            const test::BoxCpuScene scene(items); // it is drawn where its box was
            items[7].box.max.x = bad;
            const Hierarchy tree = kind.build(items, 0);
            CpuDevice device(scene);
            EXPECT_EQ(times_drawn(tree, device, test::look_ahead(), ItemId{7u}), 3)
                << kind.name << ", " << bad;
        }
    }
}

TEST_P(EveryAlgorithm, CullsNothingInViewsOfWhichNothingIsKnown)
{
    const std::vector<ItemBounds> items = wall_and_boxes();
    const test::BoxCpuScene scene(items);
    const Hierarchy tree = build_bvh(items);
    glm::mat4 not_finite{1.0f};
    not_finite[2][1] = kNaN;
    const glm::mat4 singular{0.0f};
    for (const glm::mat4& matrix : {not_finite, singular}) {
        ScriptedDevice device({.boxes = [](auto) { return 0; }}); // it would hide everything
        const View view = View::from_clip(matrix, {64, 64});
        EXPECT_EQ(times_drawn(tree, device, view, ItemId{7u}), 3);
    }
}

TEST_P(EveryAlgorithm, SurvivesTargetsWithoutPixelsAndTreesWithoutItems)
{
    const std::vector<ItemBounds> items = wall_and_boxes();
    const test::BoxCpuScene scene(items);
    const Hierarchy tree = build_bvh(items);
    const Hierarchy nothing;
    const Hierarchy built_of_nothing = build_bvh({});
    for (const glm::ivec2 size : {glm::ivec2{0, 0}, {0, 64}, {64, 0}, {-5, 7}, {1, 1}}) {
        const glm::mat4 matrix = test::look_ahead().clip_from_world();
        const View view = View::from_clip(matrix, size);
        for (const Hierarchy* walked : {&tree, &nothing, &built_of_nothing}) {
            CpuDevice device(scene);
            times_drawn(*walked, device, view, ItemId{7u});
        }
    }
}

TEST_P(EveryAlgorithm, DrawsWhatRefitWasNotToldAbout)
{
    Mistakes mistakes;
    const std::vector<ItemBounds> items = wall_and_boxes();
    const test::BoxCpuScene scene(items);
    Hierarchy tree = build_bvh(items);
    tree.refit(std::span{items}.first(5));
    mistakes.expect("refit() needs the bounds of every item");
    CpuDevice device(scene);
    EXPECT_EQ(times_drawn(tree, device, test::look_ahead(), ItemId{7u}), 3);
    // The same for items that are not in the tree.
    const std::array strangers{ItemId{999u}, ItemId{}};
    tree.refit(strangers, items);
    mistakes.expect("a moved item must be in the hierarchy");
    EXPECT_EQ(validate(tree), "");
}

std::vector<std::string> algorithm_names()
{
    std::vector<std::string> names;
    for (const AlgorithmInfo& info : algorithms()) {
        if (info.exact && info.name != "ideal") {
            names.push_back(info.name);
        }
    }
    return names;
}
INSTANTIATE_TEST_SUITE_P(Misuse, EveryAlgorithm, testing::ValuesIn(algorithm_names()),
                         [](const auto& info) { return info.param; });

// --- the CPU device ---

TEST(CpuDeviceMisuse, VerbsOutsideOfAFrameDoNothingAndTestsAreLost)
{
    Mistakes mistakes;
    const test::BoxCpuScene scene(wall_and_boxes());
    CpuDevice device(scene);
    const std::array items{ItemId{0u}};
    const QueryBox box{{{-1, -1, -9}, {1, 1, -8}}, nullptr, NodeId{}};
    const uint32_t end = 1;
    Ticket ticket;
    device.draw(items, DrawPass::shade);
    mistakes.expect("draw outside of a frame (C1)");
    device.query({std::span{&box, 1}, std::span{&end, 1}}, std::span{&ticket, 1});
    mistakes.expect("query outside of a frame (C1)");
    EXPECT_EQ(device.wait(ticket).state, AnswerState::lost);
    ticket = device.draw_and_query(items, DrawPass::shade);
    mistakes.expect("draw_and_query outside of a frame (C1)");
    EXPECT_EQ(device.wait(ticket).state, AnswerState::lost);
    EXPECT_FALSE(device.owner(12345).item.valid());
}

TEST(CpuDeviceMisuse, WrongNumbersOfTicketsAndEndsLoseTestsAndNothingElse)
{
    for (const TestMethod method : {TestMethod::queries, TestMethod::pyramid}) {
        Mistakes mistakes;
        const test::BoxCpuScene scene(wall_and_boxes());
        CpuDevice device(scene);
        const QueryBox box{{{-1, -1, -9}, {1, 1, -8}}, nullptr, NodeId{}};
        const std::array boxes{box, box};
        const std::array ends{1u, 2u};
        device.begin_frame(test::look_ahead());
        std::array<Ticket, 1> few;
        device.query({boxes, ends, method}, few);
        mistakes.expect("one ticket per test");
        std::array<Ticket, 4> many;
        device.query({boxes, ends, method}, many);
        mistakes.expect("one ticket per test");
        EXPECT_EQ(device.wait(many[3]).state, AnswerState::lost);
        const std::array descending{2u, 1u, 700u};
        std::array<Ticket, 3> three;
        device.query({boxes, descending, method}, three);
        EXPECT_EQ(device.wait(three[1]).state, AnswerState::lost);
        EXPECT_NE(device.wait(three[2]).samples, 0u);
        device.end_frame();
    }
}

TEST(CpuDeviceMisuse, ReadDepthOutsideOfTheTargetFailsAndWritesNothing)
{
    Mistakes mistakes;
    const test::BoxCpuScene scene(wall_and_boxes());
    CpuDevice device(scene);
    device.begin_frame(test::look_ahead());
    constexpr int kMost = std::numeric_limits<int>::max();
    for (const PixelRect rect : {PixelRect{-1, 0, 2, 2},
                                 {63, 63, 2, 2},
                                 {0, 0, -2, -2},
                                 {kMost, 0, 2, 2},
                                 {1, 1, kMost, kMost}}) {
        std::array<float, 4> out{7, 7, 7, 7};
        EXPECT_FALSE(device.read_depth(rect, out));
        mistakes.expect("read_depth outside of the target");
        EXPECT_EQ(out, (std::array<float, 4>{7, 7, 7, 7}));
    }
    std::array<float, 3> wrong_size{};
    EXPECT_FALSE(device.read_depth({0, 0, 2, 2}, wrong_size));
    device.end_frame();
}

TEST(ScriptedDeviceMisuse, WrongNumbersOfTicketsAndEndsLoseTests)
{
    Mistakes mistakes;
    ScriptedDevice device;
    const QueryBox box{{{-1, -1, -9}, {1, 1, -8}}, nullptr, NodeId{1u}};
    const std::array descending{1u, 0u, 9u};
    std::array<Ticket, 4> tickets;
    device.begin_frame(test::look_ahead());
    device.query({std::span{&box, 1}, descending}, tickets);
    mistakes.expect("query needs one ticket per test");
    EXPECT_EQ(device.wait(tickets[0]).state, AnswerState::ready);
    EXPECT_EQ(device.wait(tickets[1]).state, AnswerState::lost);
    EXPECT_EQ(device.wait(tickets[2]).state, AnswerState::lost);
    EXPECT_EQ(device.wait(tickets[3]).state, AnswerState::lost);
    device.end_frame();
}

// --- trees and scenes ---

TEST(TwoLevelTreeMisuse, SlotsThatAreNotInUseAreLeftAlone)
{
    Mistakes mistakes;
    const std::vector<Aabb> parts{{{-1, -1, -1}, {1, 1, 1}}};
    const std::vector<ItemBounds> bounds{{parts[0], 10}};
    TwoLevelTree tree;
    const auto slot = tree.add({ItemId{0u}, glm::mat4{1.0f}, parts, nullptr});
    tree.update(bounds);
    tree.move(slot + 5, glm::mat4{1.0f});
    mistakes.expect("only an object that is in the tree can move");
    tree.remove(slot + 5);
    mistakes.expect("only an object that is in the tree can be removed");
    tree.remove(slot);
    mistakes.expect_none();
    tree.remove(slot);
    mistakes.expect("only an object that is in the tree can be removed");
    tree.move(slot, glm::mat4{1.0f});
    mistakes.expect("only an object that is in the tree can move");
    tree.move(tree.add({ItemId{0u}, glm::mat4{1.0f}, {}, nullptr}), glm::mat4{1.0f});
    mistakes.expect("an object needs the box of at least one item");
    tree.update(bounds);
    EXPECT_EQ(tree.check(), "");
}

TEST(SceneMisuse, StaleForeignAndEmptyObjectsAreRefused)
{
    Mistakes mistakes;
    Scene scene;
    EXPECT_FALSE(scene.add(glm::mat4{1.0f}, {}).valid());
    mistakes.expect("an object has at least one item");
    const std::array item{ItemDesc{{{-1, -1, -1}, {1, 1, 1}}, 10, ItemFlags::none}};
    const ObjectId old = scene.add(glm::mat4{1.0f}, item);
    EXPECT_TRUE(scene.remove(old));
    const ObjectId fresh = scene.add(glm::mat4{1.0f}, item); // takes the slot
    EXPECT_EQ(fresh.index, old.index);
    for (const ObjectId bad : {old, ObjectId{}, ObjectId{77, 1}}) {
        EXPECT_FALSE(scene.alive(bad));
        EXPECT_FALSE(scene.move(bad, glm::mat4{2.0f}));
        EXPECT_FALSE(scene.remove(bad));
        EXPECT_FALSE(scene.first_item(bad).valid());
        EXPECT_EQ(scene.item_count(bad), 0u);
        mistakes.expect_none(); // stale ids are no mistake here: their meaning is documented
        EXPECT_EQ(scene.world_from_object(bad), glm::mat4{1.0f});
        mistakes.expect("stale object id");
    }
    EXPECT_TRUE(scene.alive(fresh));
    EXPECT_FALSE(scene.object_of(ItemId{}).valid());
    EXPECT_FALSE(scene.object_of(ItemId{99u}).valid());
}

// --- meshes and paths ---

TEST(MeshMisuse, IndicesOutOfRangeOrNotInThreesGiveNothingOrEverything)
{
    Mistakes mistakes;
    const std::array<glm::vec3, 3> corners{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
    const std::array<uint32_t, 3> beyond{0, 1, 9};
    const std::array<uint32_t, 4> not_threes{0, 1, 2, 0};
    EXPECT_TRUE(partition_triangles(corners, beyond, 10).parts.empty());
    mistakes.expect("every index must be less than the number of positions");
    EXPECT_EQ(tight_boxes(corners, beyond, 4), Shape{Aabb::everything()});
    mistakes.expect("every index must be less than the number of positions");
    EXPECT_TRUE(split_triangles(corners, corners, beyond, 10).parts.empty());
    mistakes.expect("a position and a normal for each index");
    EXPECT_TRUE(
        split_triangles(corners, std::span{corners}.first(1), not_threes, 10).parts.empty());
    mistakes.expect("three indices for each triangle");
    EXPECT_EQ(partition_triangles(corners, not_threes, 10).indices.size(), 3u);
    mistakes.expect("there must be three indices per triangle");
    EXPECT_EQ(partition_triangles(corners, std::span{not_threes}.first(3), 0).parts.size(), 1u);
    mistakes.expect("partition_triangles() needs max_triangles > 0");
    EXPECT_EQ(split_triangles(corners, corners, not_threes, 0).parts.size(), 1u);
    mistakes.expect("three indices for each triangle");
}

TEST(PathMisuse, PathsWithoutKeysAndCamerasWithoutANearPlaneHideNothing)
{
    Mistakes mistakes;
    EXPECT_TRUE(interpolate({}, 10).empty());
    mistakes.expect("a path needs at least one key");
    Camera camera;
    for (const auto& [near, far] : {std::pair{0.0f, 10.0f},
                                    {-1.0f, 10.0f},
                                    {5.0f, 5.0f},
                                    {10.0f, 1.0f},
                                    {kNaN, 10.0f},
                                    {1.0f, kNaN}}) {
        camera.near = near;
        camera.far = far;
        const View view = make_view(camera, {64, 64});
        mistakes.expect("0 < near < far");
        const Aabb ahead{{-0.5f, -0.5f, -4.0f}, {0.5f, 0.5f, -3.0f}};
        const bool tested =
            view.frustum().classify(ahead) != Containment::outside && !view.touches_near(ahead);
        EXPECT_TRUE(!tested || near > far || near < 0.0f) << near << " " << far;
    }
}

TEST(AnimationMisuse, MissingRootTranslationsCountAsNone)
{
    Mistakes mistakes;
    const std::array<Aabb, 2> boxes{Aabb{{0, 0, 0}, {1, 1, 1}}, Aabb{{4, 0, 0}, {5, 1, 1}}};
    const std::array<glm::vec3, 1> roots{glm::vec3{0.0f}};
    const AnimationBounds bounds = make_animation_bounds(boxes, roots);
    mistakes.expect("one root translation per frame, or none");
    EXPECT_TRUE(contains(bounds.in_place, merge(boxes[0], boxes[1])));
}

// --- the screen ---

TEST(ScreenMisuse, WrongNumbersOfResultsHideNothing)
{
    Mistakes mistakes;
    const View view = test::look_ahead();
    const std::array<Aabb, 3> boxes{Aabb{{-1, -1, -9}, {1, 1, -8}},
                                    Aabb{{-1, -1, -19}, {1, 1, -18}},
                                    Aabb{{-1, -1, -29}, {1, 1, -28}}};
    DepthPyramid pyramid;
    for (float& depth : pyramid.resize(view.size_px())) {
        depth = 0.0f; // would hide everything
    }
    pyramid.build();
    for (const Kernel kernel : {Kernel::scalar, Kernel::simd}) {
        for (const size_t count : {size_t{1}, size_t{7}}) {
            std::vector<ScreenBounds> bounds(count);
            project_boxes(view, boxes, bounds, kernel);
            mistakes.expect("project_boxes needs one result per box");
            EXPECT_TRUE(count < 4 || !bounds[5].valid);
            std::vector<uint8_t> hidden(count, 1);
            pyramid.hides(view, boxes, DepthPyramid::Refinement::pixels, hidden, kernel);
            mistakes.expect("DepthPyramid::hides needs one result per box");
            EXPECT_EQ(hidden, std::vector<uint8_t>(count, 0));
            std::fill(hidden.begin(), hidden.end(), uint8_t{1});
            const std::array<ScreenBounds, 3> three{};
            pyramid.hides(three, DepthPyramid::Refinement::pixels, hidden, kernel);
            mistakes.expect("DepthPyramid::hides needs one result per box");
            EXPECT_EQ(hidden, std::vector<uint8_t>(count, 0));
        }
    }
    std::vector<ScreenBounds> few(1);
    const std::array<QueryBox, 2> query_boxes{QueryBox{boxes[0], nullptr, NodeId{}},
                                              QueryBox{boxes[1], nullptr, NodeId{}}};
    project_query_boxes(view, query_boxes, few);
    mistakes.expect("project_query_boxes needs one result per box");
}

} // namespace
} // namespace occlude
