// Shapes: items whose bounding box is visible while the boxes of their shape are not.
#include <occlude/cull/adaptive.h>
#include <occlude/cull/parts/depth_tests.h>
#include <occlude/cull/registry.h>
#include <occlude/cull/two_phase.h>
#include <occlude/hierarchy/item_shapes.h>

#include "support/trees.h"

#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/cull/frustum_culler.h>
#include <occlude/device/scripted_device.h>
#include <occlude/scene/scene.h>

#include <gtest/gtest.h>

#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <optional>

namespace occlude {
namespace {

using test::look_ahead;

constexpr float kFree = 1.0f;

// An item and another one before it that is always visible. The depth is near to the left of a
// pixel column, and free from there on. The picture is 64 pixels wide and looks ahead: at distance
// 10, column 32 + 3.2 x is at x.
class Shapes : public ::testing::TestWithParam<const char*> {
protected:
    Shapes()
    {
        DeviceScript script;
        script.caps.read_depth = true;
        script.caps.us_per_triangle = 0.1f;
        script.depth = [this](const PixelRect& rect, std::span<float> out) {
            for (size_t i = 0; i < out.size(); ++i) {
                const auto width = static_cast<size_t>(rect.width);
                const bool covered = static_cast<int>(i % width) < wall_to_ ||
                                     static_cast<int>(i / width) < wall_up_to_;
                out[i] = covered ? 0.5f : kFree;
            }
            return true;
        };
        device_.emplace(script);
    }

    // An item at the place of item 0 of row_tree(0): its box is of size 2 around (0, 0, -10).
    void give_shape(const Shape& shape, const glm::mat4& world_from_shape = glm::mat4{1.0f})
    {
        Aabb world;
        for (const Aabb& box : shape) {
            world = merge(world, transformed(world_from_shape, box));
        }
        std::vector<Node> nodes(1);
        nodes[0].own_items = 2;
        tree_ = Hierarchy::from_arrays(std::move(nodes), {ItemId{0u}, ItemId{1u}},
                                       {{shape.empty() ? kBox : world, 100000}, {kNearby, 100000}});
        shapes_.place(ItemId{0u}, std::make_shared<const Shape>(shape), world_from_shape);
        tree_.set_shapes(&shapes_);
    }

    // True if the item is drawn after two frames.
    bool drawn(std::vector<OptionValue> options = {}, const View& view = look_ahead())
    {
        if (GetParam() == std::string_view{"adaptive"}) {
            options.push_back({"method", "pyramid"});
        }
        auto culler = std::move(make_culler(GetParam(), tree_, options).value());
        for (int frame = 0; frame < 3; ++frame) {
            culler->cull(view, *device_);
        }
        EXPECT_EQ(std::ranges::count(culler->drawn_items(), ItemId{1u}), 1);
        return std::ranges::count(culler->drawn_items(), ItemId{0u}) > 0;
    }

    static constexpr Aabb kBox{glm::vec3{-1.0f, -1.0f, -11.0f}, glm::vec3{1.0f, 1.0f, -9.0f}};
    // Before everything, so that there is depth to read in every frame.
    static constexpr Aabb kNearby{glm::vec3{-0.01f, -0.01f, -0.16f},
                                  glm::vec3{0.01f, 0.01f, -0.15f}};
    int wall_to_ = 0;    ///< columns below this are covered ...
    int wall_up_to_ = 0; ///< ... and rows below this
    ItemShapes shapes_;
    Hierarchy tree_;
    std::optional<ScriptedDevice> device_;
};

// An upright bar to the left and a horizontal one at the bottom. The box is visible only above the
// horizontal bar and beside the upright one, where the item has no part.
const Shape kL{{{-1.0f, -1.0f, -10.5f}, {-0.6f, 1.0f, -10.0f}},
               {{-1.0f, -1.0f, -10.5f}, {1.0f, -0.6f, -10.0f}}};

TEST_P(Shapes, AnLWhoseBarsAreHiddenIsNotDrawnAlthoughItsBoxIsSeen)
{
    give_shape(kL);
    wall_to_ = 31;    // x < -0.3 at distance 10; the inner edge of the upright bar is at -0.6
    wall_up_to_ = 31; // y < -0.3
    EXPECT_FALSE(drawn());
    EXPECT_TRUE(drawn({{"shapes", "false"}}));
}

TEST_P(Shapes, AnLOfWhichOneBarShowsIsDrawn)
{
    give_shape(kL);
    wall_up_to_ = 31;
    wall_to_ = 29; // the upright bar reaches from 28.8 to 30.1 px
    EXPECT_TRUE(drawn());
    wall_to_ = 31;
    wall_up_to_ = 29; // and so does the lying one
    EXPECT_TRUE(drawn());
}

TEST_P(Shapes, TheyStandWhereTheirItemStands)
{
    const glm::mat4 half_turn =
        glm::rotate(glm::translate(glm::mat4{1.0f}, glm::vec3{0.0f, 0.0f, -10.0f}),
                    glm::radians(180.0f), glm::vec3{0.0f, 0.0f, 1.0f});
    Shape own = kL;
    for (Aabb& box : own) {
        box.min.z += 10.0f;
        box.max.z += 10.0f;
    }
    give_shape(own, half_turn); // an upright bar to the right, a horizontal one at the top
    wall_to_ = 31;
    wall_up_to_ = 31;
    EXPECT_TRUE(drawn());
    const glm::mat4 ahead = glm::translate(glm::mat4{1.0f}, glm::vec3{0.0f, 0.0f, -10.0f});
    shapes_.move(ItemId{0u}, ahead);
    EXPECT_FALSE(drawn());
    shapes_.move(ItemId{0u}, half_turn);
    EXPECT_TRUE(drawn());
}

// A bar that lies diagonally in its box: the box in its own space is thin where the world's is
// wide.
TEST_P(Shapes, AreTestedAsBoxesThatAreTurned)
{
    const Shape bar{{{-1.2f, -0.05f, -0.05f}, {1.2f, 0.05f, 0.05f}}};
    const glm::mat4 across =
        glm::rotate(glm::translate(glm::mat4{1.0f}, glm::vec3{0.0f, 0.0f, -10.0f}),
                    glm::radians(45.0f), glm::vec3{0.0f, 0.0f, 1.0f});
    give_shape(bar, across); // from the lower left to the upper right
    wall_to_ = 64;
    EXPECT_FALSE(drawn());
    wall_to_ = 0;
    EXPECT_TRUE(drawn());
    // Of the lower right of its box nothing is covered; the bar's pixels are.
    device_->script().depth = [](const PixelRect& rect, std::span<float> out) {
        for (int y = 0; y < rect.height; ++y) {
            for (int x = 0; x < rect.width; ++x) {
                out[static_cast<size_t>(y * rect.width + x)] = x > y + 2 ? kFree : 0.5f;
            }
        }
        return true;
    };
    EXPECT_FALSE(drawn());
    EXPECT_TRUE(drawn({{"shapes", "false"}}));
}

TEST_P(Shapes, AnEmptyShapeSaysNoMoreThanTheBox)
{
    give_shape({});
    wall_to_ = 31;
    EXPECT_TRUE(drawn());
    wall_to_ = 64;
    EXPECT_FALSE(drawn());
}

TEST_P(Shapes, APartAtTheEyeIsSeenWhateverTheDepth)
{
    wall_to_ = 64;
    const Aabb around_eye{glm::vec3{-0.5f}, glm::vec3{0.5f}};
    give_shape({kL[0], around_eye});
    EXPECT_TRUE(drawn());
    give_shape(
        {{glm::vec3{-5.0f, -5.0f, -11.0f}, glm::vec3{5.0f, -4.0f, 5.0f}}}); // also behind the eye
    EXPECT_TRUE(drawn());
    give_shape({Aabb::everything()});
    EXPECT_TRUE(drawn());
}

// The eye stands in the box of a ring, but not in the ring.
TEST_P(Shapes, ARingAroundTheEyeIsHiddenByWhatIsBeforeIt)
{
    const Shape ring{{{-12.0f, -1.0f, -12.0f}, {12.0f, 1.0f, -10.0f}},
                     {{-12.0f, -1.0f, 10.0f}, {12.0f, 1.0f, 12.0f}}};
    give_shape({ring[0]});
    wall_to_ = 64;
    EXPECT_FALSE(drawn());
    give_shape(ring); // of which a part is behind the eye: rule R1
    EXPECT_TRUE(drawn());
}

TEST_P(Shapes, UnderAMapWithoutAnInverseTheyAreSeen)
{
    glm::mat4 flat = glm::scale(glm::mat4{1.0f}, glm::vec3{1.0f, 1.0f, 0.0f});
    flat[3][2] = -10.0f;
    give_shape(kL, flat);
    wall_to_ = 31;
    wall_up_to_ = 31;
    EXPECT_TRUE(drawn());
    give_shape(kL, glm::scale(glm::mat4{1.0f}, glm::vec3{1.0f, 1e-9f, 1.0f}));
    EXPECT_TRUE(drawn());
}

// --- on the CPU device: the picture --------------------------------------------------------------

// Objects that are open frames: four bars around a hole, each a box of twelve triangles, turned and
// stretched at random. They turn in every frame, and some of them are replaced by others.
class Frames final : public CpuScene {
public:
    explicit Frames(uint32_t count)
        : shape_(std::make_shared<const Shape>(Shape{{{-1.0f, -1.0f, -0.2f}, {1.0f, -0.7f, 0.2f}},
                                                     {{-1.0f, 0.7f, -0.2f}, {1.0f, 1.0f, 0.2f}},
                                                     {{-1.0f, -0.7f, -0.2f}, {-0.7f, 0.7f, 0.2f}},
                                                     {{0.7f, -0.7f, -0.2f}, {1.0f, 0.7f, 0.2f}}}))
    {
        static constexpr uint32_t kBox[] = {0, 1, 2, 2, 1, 3, 4, 6, 5, 5, 6, 7, 0, 4, 1, 1, 4, 5,
                                            2, 3, 6, 6, 3, 7, 0, 2, 4, 4, 2, 6, 1, 5, 3, 3, 5, 7};
        for (uint32_t bar = 0; bar < shape_->size(); ++bar) {
            for (const uint32_t corner : kBox) {
                indices_.push_back(8 * bar + corner);
            }
        }
        for (uint32_t i = 0; i < count; ++i) {
            maps_.push_back(random_map());
            objects_.push_back(add(maps_.back()));
        }
        positions_.resize(scene.item_bounds().size());
        rebuild();
    }

    void step()
    {
        for (size_t i = 0; i < objects_.size(); ++i) {
            maps_[i] = glm::rotate(maps_[i], 0.05f, glm::vec3{0.6f, 0.8f, 0.0f});
            if (rng_.below(20) == 0) {
                scene.remove(objects_[i]);
                maps_[i] = random_map();
                objects_[i] = add(maps_[i]);
            }
            scene.move(objects_[i], maps_[i]);
        }
        rebuild();
    }

    CpuItem item(ItemId item) const override
    {
        return {.positions = positions_[item.value], .indices = indices_};
    }

    Scene scene;

private:
    ObjectId add(const glm::mat4& map)
    {
        Aabb box;
        for (const Aabb& bar : *shape_) {
            box = merge(box, bar);
        }
        const ItemDesc item{.local_box = box, .triangles = 5000, .shape = shape_};
        return scene.add(map, {&item, 1});
    }
    glm::mat4 random_map()
    {
        const auto vector = [&](float low, float high) {
            return glm::vec3{rng_.range(low, high), rng_.range(low, high), rng_.range(low, high)};
        };
        const glm::mat4 place = glm::translate(glm::mat4{1.0f}, vector(-24.0f, 24.0f));
        const glm::mat4 turned =
            glm::rotate(place, rng_.range(0.0f, 6.0f), glm::normalize(vector(0.1f, 1.0f)));
        return glm::scale(turned, vector(1.0f, 5.0f));
    }
    void rebuild()
    {
        for (size_t i = 0; i < objects_.size(); ++i) {
            auto& positions = positions_[scene.first_item(objects_[i]).value];
            positions.clear();
            for (const Aabb& bar : *shape_) {
                for (int c = 0; c < 8; ++c) {
                    const glm::vec4 p{(c & 1) != 0 ? bar.max.x : bar.min.x,
                                      (c & 2) != 0 ? bar.max.y : bar.min.y,
                                      (c & 4) != 0 ? bar.max.z : bar.min.z, 1.0f};
                    positions.emplace_back(maps_[i] * p);
                }
            }
        }
    }

    std::shared_ptr<const Shape> shape_;
    Rng rng_{5};
    std::vector<uint32_t> indices_;
    std::vector<glm::mat4> maps_;
    std::vector<ObjectId> objects_;
    std::vector<std::vector<glm::vec3>> positions_;
};

struct Total {
    uint64_t drawn = 0;
    uint64_t in_frustum = 0;
};

Total expect_exact(const std::string& algorithm, const std::vector<OptionValue>& options)
{
    Frames frames{400};
    Hierarchy tree = build_bvh(frames.scene.item_bounds(), {.leaf_triangles = 20000});
    tree.set_shapes(&frames.scene.shapes());
    CpuDevice device(frames);
    CpuDevice reference_device(frames);
    FrustumCuller reference{tree};
    auto culler = std::move(make_culler(algorithm, tree, options).value());
    Total run;
    for (uint64_t frame = 0; frame < 24; ++frame) {
        const float t = static_cast<float>(frame);
        const View view =
            frame % 8 == 5
                ? test::look({-30.0f, 3.0f, 8.0f}, {30.0f, 0.0f, 0.0f}, {161, 89})
                : test::look({1.0f, 0.5f, 26.0f - t}, {0.4f * t, 0.0f, -60.0f}, {161, 89});
        reference.cull(view, reference_device);
        culler->cull(view, device);
        EXPECT_TRUE(std::ranges::equal(device.depth(), reference_device.depth()))
            << algorithm << ", frame " << frame;
        size_t different = 0;
        for (size_t i = 0; i < device.depth().size(); ++i) {
            different += device.owner(i) == reference_device.owner(i) ? 0 : 1;
        }
        EXPECT_EQ(different, 0u) << algorithm << ", frame " << frame;
        run.drawn += culler->drawn_items().size();
        run.in_frustum += reference.drawn_items().size();
        frames.step();
        tree.refit(frames.scene.item_bounds());
    }
    return run;
}

TEST(ShapesOnTheCpuDevice, HideMoreThanBoxesDoAndTheImageIsTheSame)
{
    using Options = std::vector<OptionValue>;
    const Total boxes = expect_exact("two_phase", {{"shapes", "false"}});
    const Total shapes = expect_exact("two_phase", {});
    EXPECT_LT(shapes.drawn * 10, boxes.drawn * 9);
    EXPECT_GT(shapes.drawn, shapes.in_frustum / 20);
    for (const Options& options :
         {Options{{"refine", "false"}}, Options{{"final_depth", "true"}},
          Options{{"reread_triangles", "20000"}}, Options{{"virtual_leaves", "true"}}}) {
        expect_exact("two_phase", options);
    }
    const Total adaptive_boxes =
        expect_exact("adaptive", {{"method", "pyramid"}, {"shapes", "false"}});
    const Total adaptive = expect_exact("adaptive", {{"method", "pyramid"}});
    EXPECT_LT(adaptive.drawn * 10, adaptive_boxes.drawn * 9);
    expect_exact("adaptive", {});
}

INSTANTIATE_TEST_SUITE_P(Cull, Shapes, ::testing::Values("two_phase", "adaptive"),
                         [](const auto& param) { return std::string{param.param}; });

} // namespace
} // namespace occlude
