// Like misuse_test.cpp, for the small parts: numbers, boxes, lattices, shapes, lights and results.
#include "misuse/misuse.h"

#include "support/trees.h"

#include <occlude/core/aabb.h>
#include <occlude/core/bounding_sphere.h>
#include <occlude/core/result.h>
#include <occlude/device/cost_model_device.h>
#include <occlude/device/faulty_device.h>
#include <occlude/device/handed_depth_device.h>
#include <occlude/device/scripted_device.h>
#include <occlude/effects/flare_visibility.h>
#include <occlude/effects/level_of_detail.h>
#include <occlude/hierarchy/builders/two_level.h>
#include <occlude/hierarchy/hierarchy.h>
#include <occlude/hierarchy/item_shapes.h>
#include <occlude/hierarchy/lattice.h>
#include <occlude/scene/animated_bounds.h>
#include <occlude/scene/camera_path.h>
#include <occlude/scene/scene.h>
#include <occlude/scene/two_level_scene.h>
#include <occlude/screen/projection.h>
#include <occlude/screen/screen_box.h>

#include <gtest/gtest.h>

#include <array>
#include <limits>

namespace occlude {
namespace {

using test::Mistakes;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr Aabb kBox{{-1, -1, -9}, {1, 1, -8}};

// --- core ---

TEST(CoreMisuse, ANegativeMarginShrinksNoBox)
{
    Mistakes mistakes;
    EXPECT_EQ(inflated(kBox, -1.0f), kBox);
    mistakes.expect("inflated() cannot shrink a box");
}

TEST(ResultMisuse, AValueThatIsNotThereIsAnExceptionNotGarbage)
{
    Mistakes mistakes;
    const Result<int> failed{Error{ErrorCode::bad_data, "broken"}};
    EXPECT_THROW(failed.value(), std::bad_variant_access);
    mistakes.expect("value() of a failed Result");
    const Result<int> fine{3};
    EXPECT_THROW(fine.error(), std::bad_variant_access);
    mistakes.expect("error() of a Result that succeeded");
}

TEST(CoreMisuse, ARatioBelowOneIsARatioAllTheSame)
{
    Mistakes mistakes;
    EXPECT_TRUE(is_elongated({{0, 0, 0}, {1, 1, 1}}, 0.5f));
    mistakes.expect("is_elongated() needs a ratio");
}

// --- trees and scenes ---

TEST(LatticeMisuse, CellsAndPointsThatAreNoneStayInTheLattice)
{
    Mistakes mistakes;
    EXPECT_EQ(Lattice::over(Aabb::everything(), 8).cell_count(), 1u);
    mistakes.expect("a lattice needs a bounded box");
    EXPECT_EQ(Lattice::over(kBox, 0).cell_count(), 1u);
    mistakes.expect("a lattice needs at least one cell");
    const Lattice lattice = Lattice::over(kBox, 8);
    EXPECT_EQ(lattice.cell({kNaN, 0.5f, -8.0f}).x, 0u);
    mistakes.expect("a coordinate of the point is NaN");
    lattice.index(lattice.count);
    mistakes.expect("a cell lies in its lattice");
    lattice.at(lattice.cell_count());
    mistakes.expect("the index is beyond the cells of the lattice");
}

TEST(ShapeMisuse, AnInvalidItemHasNoShape)
{
    Mistakes mistakes;
    ItemShapes shapes;
    shapes.place(ItemId{}, std::make_shared<Shape>(Shape{kBox}), glm::mat4{1.0f});
    mistakes.expect("the id of the item with the shape");
    EXPECT_TRUE(shapes.empty());
    shapes.place(ItemId{0u}, std::make_shared<Shape>(Shape{Aabb::everything()}), glm::mat4{1.0f});
    mistakes.expect("the boxes of a shape are bounded");
}

TEST(HierarchyMisuse, ItemsWithoutBoundsAreUnbounded)
{
    Mistakes mistakes;
    std::vector<Node> nodes(1);
    nodes[0].own_items = 2;
    const Hierarchy tree = Hierarchy::from_arrays(nodes, {ItemId{0u}, ItemId{1u}}, {{kBox, 10}});
    mistakes.expect("Hierarchy::from_arrays needs the bounds of each item");
    EXPECT_EQ(tree.item_bounds(ItemPosition{1u}).box, Aabb::everything());
}

TEST(TwoLevelTreeMisuse, AnObjectWithoutAFirstItemIsNotAdded)
{
    Mistakes mistakes;
    TwoLevelTree tree;
    const std::array boxes{kBox};
    const TwoLevelTree::Slot slot = tree.add({.first_item = ItemId{}, .local_boxes = boxes});
    mistakes.expect("an object needs the id of its first item");
    tree.move(slot, glm::mat4{1.0f});
    mistakes.expect("only an object that is in the tree can move");
}

TEST(SceneMisuse, OffsetsThatAreNotFiniteMoveNothing)
{
    Mistakes mistakes;
    Scene scene;
    scene.add(glm::mat4{1.0f}, std::array{ItemDesc{kBox, 10, ItemFlags::none}});
    const Aabb before = scene.item_bounds()[0].box;
    scene.shift({double{kNaN}, 0.0, 0.0});
    mistakes.expect("Scene::shift needs a finite offset");
    EXPECT_EQ(scene.item_bounds()[0].box, before);
}

TEST(SceneMisuse, ATreeThatFollowsAnotherSceneHoldsThatOneAlone)
{
    Mistakes mistakes;
    Scene first;
    Scene second;
    const std::array item{ItemDesc{kBox, 10, ItemFlags::none}};
    const glm::mat4 elsewhere{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {50, 0, 0, 1}};
    first.add(glm::mat4{1.0f}, item);
    second.add(elsewhere, item); // the same id, another place
    TwoLevelScene tree;
    tree.sync(first);
    mistakes.expect_none();
    tree.sync(second);
    mistakes.expect("TwoLevelScene::sync is always called with the same scene");
    ASSERT_EQ(tree.hierarchy().items().size(), 1u);
    EXPECT_TRUE(contains(tree.hierarchy().node(NodeId{0u}).box, second.item_bounds()[0].box));
    EXPECT_EQ(tree.hierarchy().item_bounds()[0].box, second.item_bounds()[0].box);
}

TEST(PathMisuse, KeysOutOfOrderAndFieldsOfViewOfNothingHideNothing)
{
    Mistakes mistakes;
    const std::array keys{Keyframe{2.0f, Camera{}, false}, Keyframe{1.0f, Camera{}, false}};
    EXPECT_EQ(interpolate(keys, 5).size(), 5u);
    mistakes.expect("the times of a path's keys ascend");
    const View view = make_view({.fov_y = 0.0f, .near = 0.1f, .far = 10.0f}, {64, 64});
    mistakes.expect("a camera's field of view is between 0 and 180 degrees");
    EXPECT_TRUE(view.touches_near(kBox)); // no test hides it
}

TEST(AnimationMisuse, AWeightThatIsNoNumberMakesTheBoxUnbounded)
{
    Mistakes mistakes;
    const std::array playing{PlayingAnimation{.bounds = {kBox}, .weight = kNaN}};
    const Aabb box = blended_bounds(playing);
    mistakes.expect("the weight of an animation is a number");
    EXPECT_FALSE(box.is_bounded());
    EXPECT_FALSE(box.is_empty());
}

// --- effects ---

TEST(LightMisuse, LightsThatDoNotExistAreDark)
{
    Mistakes mistakes;
    const FlareVisibility impatient({.fade_time = -1.0});
    mistakes.expect("the fade_time of flares must not be negative");
    FlareVisibility flares;
    flares.set_lights(std::array{FlareLight{}});
    EXPECT_EQ(flares.fraction(1), 0.0);
    mistakes.expect("FlareVisibility has no light of this number");
    EXPECT_EQ(flares.brightness(7), 0.0);
    mistakes.expect("FlareVisibility has no light of this number");
    ScriptedDevice device;
    flares.end_frame(device);
    mistakes.expect("FlareVisibility::end_frame follows its begin_frame");
    EXPECT_TRUE(device.trace().empty());
    EXPECT_EQ(flare_radius_px(test::look_ahead(), {0, 0, -10}, -1.0f, 2.0f, 9.0f), 2.0f);
    mistakes.expect("the radius of a light's ball must not be negative");
    make_flare_disc(test::look_ahead(), {.position_world = {0, 0, 10, -1}});
    mistakes.expect("the w of a light is 1, or 0 at infinity");
    EXPECT_EQ(flare_radius_px(test::look_ahead(), {0, 0, -10}, 1.0f, 9.0f, 2.0f), 9.0f);
    mistakes.expect("the smallest radius of a flare is above its largest");
}

TEST(LevelOfDetailMisuse, ThresholdsThatAscendStillGiveALevel)
{
    Mistakes mistakes;
    const std::array<uint64_t, 3> ascending{10, 100, 1000};
    EXPECT_LE(choose_level_of_detail(50, ascending, 0, 0.1f), 3u);
    mistakes.expect("the thresholds of levels of detail descend");
    const std::array<uint64_t, 2> descending{100, 10};
    EXPECT_LE(choose_level_of_detail(50, descending, 0, 1.5f), 2u);
    mistakes.expect("the hysteresis of levels of detail");
}

// --- screen ---

TEST(ScreenMisuse, RectanglesAndBlocksWithoutPixelsProveNothing)
{
    Mistakes mistakes;
    const View view = test::look_ahead();
    const glm::ivec2 size = view.size_px();
    for (const PixelRect& rect : {PixelRect{0, 0, 0, 4}, PixelRect{-1, 0, 4, 4},
                                  PixelRect{size.x - 2, 0, 4, 4}, PixelRect{0, 0, 4, size.y + 1}}) {
        EXPECT_FALSE(world_from_rectangle(view, rect, 0.9f).has_value());
        mistakes.expect("world_from_rectangle needs a rectangle with pixels, in the target");
    }
    const ScreenSpace screen(view);
    const ScreenBox box(screen, kBox);
    EXPECT_EQ(box.nearest_over({8, 8}, {4, 4}), -std::numeric_limits<double>::infinity());
    mistakes.expect("ScreenBox::nearest_over needs the lower left pixel first");
    const ScreenSpace nowhere = screen.in(glm::mat4{0.0f}, view.inflation());
    mistakes.expect("ScreenSpace::in needs a map with an inverse");
    EXPECT_FALSE(ScreenBox(nowhere, kBox).beyond(0.0, {0, 0}, {size.x - 1, size.y - 1}));
}

// --- devices ---

TEST(DeviceMisuse, DecoratorsLoseTestsThatHaveNoTicketOrTooMany)
{
    Mistakes mistakes;
    const View view = test::look_ahead();
    const QueryBox box{kBox, nullptr, NodeId{1u}};
    const std::array one_end{1u};
    std::array<Ticket, 3> tickets;
    HandedDepthDevice handed;
    handed.begin_frame(view);
    handed.query({std::span{&box, 1}, one_end}, tickets);
    mistakes.expect("HandedDepthDevice::query needs one ticket per test");
    EXPECT_EQ(handed.wait(tickets[2]).state, AnswerState::lost);
    handed.end_frame();

    ScriptedDevice scripted;
    const CostModelDevice negative(scripted, {.per_test = -1.0}, {});
    mistakes.expect("CostModelDevice needs costs that are not negative");
    CostModelDevice modelled(scripted, {}, {});
    modelled.begin_frame(view);
    modelled.query({std::span{&box, 1}, one_end}, tickets);
    mistakes.expect("query needs one ticket per test");
    EXPECT_EQ(modelled.wait(tickets[0]).state, AnswerState::ready);
    EXPECT_EQ(modelled.wait(tickets[2]).state, AnswerState::lost);
    modelled.end_frame();

    const FaultyDevice too_faulty(scripted, {.lost = 1001});
    mistakes.expect("FaultyDevice needs chances of at most 1000 per thousand");
    const FaultyDevice too_late(scripted, {.max_polls = ~0u});
    mistakes.expect("FaultyDevice needs delays below");
}

} // namespace
} // namespace occlude
