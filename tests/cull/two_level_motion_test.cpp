// `two_level` over the trees that it is made for: objects with parts, in motion.
#include <occlude/cull/two_level.h>

#include "support/trees.h"

#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/cull/frustum_culler.h>
#include <occlude/cull/registry.h>
#include <occlude/device/scripted_device.h>
#include <occlude/device/validating_device.h>
#include <occlude/hierarchy/builders/two_level.h>

#include <glm/ext/matrix_transform.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace occlude {
namespace {

using test::look;
using test::look_ahead;

/// A scene of objects that stand anywhere, turned and scaled. Object i has `parts` items. Each item
/// is a pyramid or a box that fills its local box.
class Objects final : public CpuScene {
public:
    struct Object {
        glm::mat4 place{1.0f};
        uint32_t first = 0;
        std::vector<Aabb> local;
        TwoLevelTree::Slot slot = 0;
        bool alive = true;
    };

    explicit Objects(const TwoLevelOptions& options)
        : tree(options)
    {
    }

    void add(const glm::mat4& place, uint32_t parts)
    {
        Object object{place, static_cast<uint32_t>(bounds.size()), {}, 0, true};
        for (uint32_t i = 0; i < parts; ++i) {
            const glm::vec3 low{2.0f * static_cast<float>(i % 3), 2.0f * static_cast<float>(i / 3),
                                0.0f};
            object.local.push_back({low, low + glm::vec3{2.0f, 2.0f, 1.0f}});
            meshes_.push_back(corners_of(object.local.back(), i % 2 == 0));
            places_.push_back(place);
        }
        bounds.resize(bounds.size() + parts, {Aabb{}, 12});
        object.slot = tree.add({.first_item = ItemId{object.first},
                                .world_from_object = place,
                                .local_boxes = object.local});
        objects.push_back(object);
        put(objects.back());
    }
    void move(Object& object, const glm::mat4& place)
    {
        object.place = place;
        tree.move(object.slot, place);
        put(object);
    }
    void remove(Object& object)
    {
        object.alive = false;
        tree.remove(object.slot);
        for (size_t i = 0; i < object.local.size(); ++i) {
            bounds[object.first + i].box = Aabb{};
        }
    }

    CpuItem item(ItemId item) const override
    {
        static const std::vector<uint32_t> kIndices{0, 1, 2, 2, 1, 3, 4, 6, 5, 5, 6, 7,
                                                    0, 4, 1, 1, 4, 5, 2, 3, 6, 6, 3, 7,
                                                    0, 2, 4, 4, 2, 6, 1, 5, 3, 3, 5, 7};
        return {.positions = meshes_[item.value],
                .indices = kIndices,
                .world_from_mesh = places_[item.value]};
    }

    TwoLevelTree tree;
    std::vector<Object> objects;
    std::vector<ItemBounds> bounds;

private:
    static std::vector<glm::vec3> corners_of(const Aabb& box, bool pyramid)
    {
        std::vector<glm::vec3> corners;
        for (int c = 0; c < 8; ++c) {
            glm::vec3 p{(c & 1) != 0 ? box.max.x : box.min.x, (c & 2) != 0 ? box.max.y : box.min.y,
                        (c & 4) != 0 ? box.max.z : box.min.z};
            if (pyramid && (c & 2) != 0) {
                p = {box.center().x, box.max.y, box.center().z};
            }
            corners.push_back(p);
        }
        return corners;
    }
    void put(const Object& object)
    {
        for (uint32_t i = 0; i < object.local.size(); ++i) {
            bounds[object.first + i].box = transformed(object.place, object.local[i]);
            places_[object.first + i] = object.place;
        }
    }

    std::vector<std::vector<glm::vec3>> meshes_;
    std::vector<glm::mat4> places_;
};

struct Motion {
    glm::vec3 at{0.0f};
    glm::vec3 step{0.0f};
    glm::vec3 axis{0.0f, 1.0f, 0.0f};
    float turn = 0.0f;
    glm::vec3 scale{1.0f};

    glm::mat4 place(float time) const
    {
        const glm::mat4 moved = glm::translate(glm::mat4{1.0f}, at + time * step);
        return glm::scale(glm::rotate(moved, turn * time, axis), scale);
    }
};

Motion random_motion(Rng& rng, float spread)
{
    const auto vector = [&](float size) {
        return glm::vec3{rng.range(-size, size), rng.range(-size, size), rng.range(-size, size)};
    };
    Motion motion;
    motion.at = vector(spread);
    motion.step = vector(0.6f);
    motion.axis = glm::normalize(vector(1.0f) + glm::vec3{0.0f, 2.0f, 0.0f});
    motion.turn = rng.range(-0.2f, 0.2f);
    motion.scale = glm::vec3{1.5f} + vector(1.0f);
    return motion;
}

// 150 objects fly, turn and pass through each other; some appear and disappear. Every picture is
// compared.
void expect_exact_in_motion(const TwoLevelOptions& tree_options,
                            const std::vector<OptionValue>& options, const glm::vec3& center)
{
    Objects scene(tree_options);
    Rng rng{77};
    std::vector<Motion> motions;
    const auto add = [&] {
        motions.push_back(random_motion(rng, 16.0f));
        motions.back().at += center;
        scene.add(motions.back().place(0.0f), 1 + rng.below(9));
    };
    for (int i = 0; i < 150; ++i) {
        add();
    }
    scene.tree.update(scene.bounds);
    CpuDevice device(scene);
    CpuDevice reference_device(scene);
    std::vector<std::string> violations;
    ValidatingDevice checked(device,
                             {.on_violation = [&](std::string_view rule, std::string_view text) {
                                 violations.push_back(std::string{rule} + " " + std::string{text});
                             }});
    FrustumCuller reference{scene.tree.hierarchy()};
    const auto culler =
        std::move(make_culler("two_level", scene.tree.hierarchy(), options).value());
    uint64_t drawn = 0;
    uint64_t in_frustum = 0;
    for (uint64_t frame = 0; frame < 16; ++frame) {
        if (frame % 4 == 3) {
            scene.remove(scene.objects[5 * frame]);
            add();
        }
        for (size_t i = 0; i < scene.objects.size(); ++i) {
            if (scene.objects[i].alive) {
                scene.move(scene.objects[i], motions[i].place(static_cast<float>(frame)));
            }
        }
        scene.tree.update(scene.bounds);
        ASSERT_EQ(scene.tree.check(), "");
        const float t = 0.15f * static_cast<float>(frame);
        const glm::vec3 eye = center + glm::vec3{26.0f * std::sin(t), 4.0f, 26.0f * std::cos(t)};
        const View view = look(eye, center, {129, 83});
        reference.cull(view, reference_device);
        const FrameReport report = culler->cull(view, checked);
        ASSERT_EQ(report.frame, frame); // it remembers over a relinking
        ASSERT_TRUE(std::ranges::equal(device.depth(), reference_device.depth()))
            << "frame " << frame;
        for (size_t i = 0; i < device.depth().size(); ++i) {
            ASSERT_EQ(device.owner(i), reference_device.owner(i)) << "frame " << frame;
        }
        drawn += culler->drawn_items().size();
        in_frustum += reference.drawn_items().size();
    }
    EXPECT_EQ(violations, std::vector<std::string>{});
    EXPECT_GT(scene.tree.relink_count(), 100u);
    EXPECT_LT(drawn, in_frustum * 9 / 10);
    EXPECT_GT(drawn, in_frustum / 20);
}

TEST(TwoLevel, IsExactWhileEverythingMovesTurnsComesAndGoes)
{
    expect_exact_in_motion({.leaf_triangles = 24}, {}, {});
}
TEST(TwoLevel, IsExactInMotionWithEachPartSwitched)
{
    expect_exact_in_motion({.leaf_triangles = 24}, {{"disjoint", "false"}}, {});
    expect_exact_in_motion({.leaf_triangles = 24}, {{"multiqueries", "false"}}, {});
    expect_exact_in_motion({.leaf_triangles = 24}, {{"max_postponed", "0"}}, {});
    expect_exact_in_motion({.leaf_triangles = 0, .rebuild_period = 1, .quiet_frames = 4}, {}, {});
    expect_exact_in_motion({.complex_triangles = 0, .leaf_objects = 8, .leaf_triangles = 100}, {},
                           {});
}
TEST(TwoLevel, IsExactInMotionFarFromTheOrigin)
{
    expect_exact_in_motion({.leaf_triangles = 24}, {}, {20000.0f, -3000.0f, 9000.0f});
}

TEST(TwoLevel, ATurnedBoxIsTestedAsTightAsItIs)
{
    // A thin board, turned by 45 degrees, beside a wall that hides just its world box's near half.
    TwoLevelTree tree({.leaf_triangles = 0});
    const std::vector<Aabb> board{{{-4, -0.1f, -4}, {4, 0.1f, 4}}};
    const glm::mat4 place = glm::rotate(glm::translate(glm::mat4{1.0f}, glm::vec3{0, 0, -20}),
                                        glm::radians(45.0f), glm::vec3{0, 0, 1});
    tree.add({.first_item = ItemId{0u}, .world_from_object = place, .local_boxes = board});
    const std::vector<ItemBounds> bounds{{transformed(place, board[0]), 1000}};
    tree.update(bounds);
    Aabb tested;
    glm::mat4 space{0.0f};
    ScriptedDevice device({.boxes = [&](std::span<const QueryBox> boxes) {
        tested = boxes[0].box;
        if (boxes[0].world_from_box != nullptr) {
            space = *boxes[0].world_from_box;
            return uint64_t{0};
        }
        return uint64_t{5};
    }});
    TwoLevel culler{tree.hierarchy()};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(space, place);
    EXPECT_TRUE(contains(tested, board[0]));
    EXPECT_LT(tested.extent().y, 0.5f); // the world box is more than 5 high
}

TEST(TwoLevel, ObjectsComeBetweenTheNearAndTheFarHalfByTheDistanceOfTheirMiddles)
{
    // Two clusters along the line of sight, and two objects that straddle the plane between them.
    TwoLevelTree tree({.complex_triangles = 0, .leaf_triangles = 0});
    std::vector<ItemBounds> bounds;
    const auto add = [&](const Aabb& box) {
        const glm::mat4 here{1.0f};
        tree.add({.first_item = ItemId{bounds.size()},
                  .world_from_object = here,
                  .local_boxes = {&box, 1}});
        bounds.push_back({box, 100});
    };
    for (const float z : {-10.0f, -11.5f, -40.0f, -41.5f}) {
        add({{-1, -1, z - 1}, {1, 1, z}});
    }
    add({{-2, -1, -41}, {-1.5f, 1, -11}});     // 4: middle at -26
    add({{1.5f, -1, -40.5f}, {2, 1, -10.4f}}); // 5: middle at -25.45, nearer
    tree.update(bounds);
    ScriptedDevice device; // all is visible
    TwoLevel culler{tree.hierarchy()};
    culler.cull(look_ahead(), device);
    std::map<uint32_t, size_t> place;
    for (size_t i = 0; i < culler.drawn_items().size(); ++i) {
        place[culler.drawn_items()[i].value] = i;
    }
    ASSERT_EQ(place.size(), 6u);
    EXPECT_LT(place[0], place[5]);
    EXPECT_LT(place[5], place[4]);
    EXPECT_LT(place[4], place[2]);
}

} // namespace
} // namespace occlude
