#include "generate/moving_generators.h"
#include "measure/measure.h"
#include "measure/motion_player.h"
#include "measure/verify.h"

#include "generate/scene_source.h"
#include "tools/tiny_scenes.h"
#include "walk/paths.h"

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/trigonometric.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace occlude::tools {

using namespace test;

namespace {

constexpr glm::ivec2 kSize{64, 48};

/// A model that moves, with everything needed to run algorithms on it.
struct MovingStage {
    explicit MovingStage(SceneModel model)
        : tiny(std::move(model), kSize)
    {
    }
    /// Uses `other` as the renderer, if it is given.
    Stage stage(SceneRenderer* other = nullptr)
    {
        SceneRenderer& renderer = other != nullptr ? *other : *tiny.renderer;
        tiny.scene = make_cull_scene(tiny.model);
        tiny.hierarchy = build(tiny.scene.scene.item_bounds());
        tree = std::make_unique<RefittedTree>(tiny.hierarchy, tiny.scene.scene, build);
        player = std::make_unique<MotionPlayer>(tiny.model, tiny.scene, *tree, renderer);
        Stage stage{tiny.hierarchy, tiny.scene.scene.item_bounds(), renderer};
        stage.go_to = [this](size_t frame) { player->go_to(frame); };
        return stage;
    }

    static Hierarchy build(std::span<const ItemBounds> items)
    {
        return build_bvh(items, {.leaf_triangles = 0});
    }

    TinyStage tiny;
    std::unique_ptr<RefittedTree> tree;
    std::unique_ptr<MotionPlayer> player;
};

/// Small, but dense enough to hide much, and fast enough to change much.
SceneModel crowd()
{
    SceneModel model = generate_movers({.count = 300, .seed = 3, .triangles = 8000});
    for (Instance& instance : model.instances) {
        instance.world_from_mesh[3] *= glm::vec4{glm::vec3{0.42f}, 1.0f};
    }
    for (size_t i = 0; i < model.instances.size(); i += 7) {
        model.instances[i].opacity = 0.5f;
    }
    model.motion.box = {glm::vec3{-15.0f}, glm::vec3{15.0f}};
    for (InstanceMotion& motion : model.motion.instances) {
        motion.velocity *= 3.0f;
        motion.period /= 6;
        motion.present /= 6;
    }
    return model;
}

std::vector<View> path_views(const SceneModel& model, const std::string& path, size_t frames)
{
    auto cameras = load_path(path, model, frames);
    EXPECT_TRUE(cameras) << path;
    choose_depth_range(*cameras, model);
    std::vector<View> views;
    for (const Camera& camera : *cameras) {
        views.push_back(make_view(camera, kSize));
    }
    return views;
}

std::vector<Contender> exact_testers()
{
    return {registered("stop_and_wait"), registered("chc"), registered("chc_plus_plus"),
            registered("two_level")};
}

std::vector<Contender> all_registered()
{
    std::vector<Contender> contenders;
    for (const AlgorithmInfo& info : algorithms()) {
        contenders.push_back(registered(info.name));
    }
    return contenders;
}

void expect_exact(const Stage& stage, const std::vector<View>& views)
{
    const auto runs = verify(stage, all_registered(), views);
    ASSERT_TRUE(runs);
    uint64_t frustum_items = 0;
    for (const AlgorithmRun& run : *runs) {
        const Summary summary = summarise(run);
        EXPECT_TRUE(summary.verified) << run.algorithm;
        if (run.algorithm == "frustum") {
            frustum_items = summary.total.items_drawn;
        }
        if (run.algorithm == "ideal") { // otherwise the scene is no evidence
            EXPECT_LT(summary.total.items_drawn, frustum_items * 9 / 10);
        }
    }
    EXPECT_TRUE(promises_kept(*runs));
    for (const AlgorithmRun& run : *runs) {
        const bool exact = run.guarantee.kind == Guarantee::Kind::exact;
        for (const std::string& line : describe_differences(run, exact ? 2 : 0)) {
            EXPECT_FALSE(exact) << line;
        }
    }
}

} // namespace

TEST(Motion, FliesStraightAndBouncesOffTheWalls)
{
    const Aabb box{glm::vec3{0.0f}, glm::vec3{10.0f}};
    glm::mat4 start{1.0f};
    start[3] = {9.0f, 5.0f, 1.0f, 1.0f};
    InstanceMotion motion;
    motion.velocity = {3.0f, 0.0f, -1.5f};
    EXPECT_EQ(moved(motion, box, start, 0), start);
    EXPECT_EQ(glm::vec3(moved(motion, box, start, 1)[3]), glm::vec3(8.0f, 5.0f, 0.5f));
    EXPECT_EQ(glm::vec3(moved(motion, box, start, 2)[3]), glm::vec3(5.0f, 5.0f, 2.0f));
    EXPECT_EQ(glm::vec3(moved(motion, box, start, 20)[3]), glm::vec3(9.0f, 5.0f, 9.0f));
}

TEST(Motion, TurnsByTheAngleTimesTheFrameWithoutDrift)
{
    InstanceMotion motion;
    const glm::vec3 axis = glm::normalize(glm::vec3{1.0f, 2.0f, -0.5f});
    motion.spin = std::tan(0.5f * glm::radians(7.0f)) * axis;
    glm::mat4 start{1.0f};
    start[0] *= 3.0f; // a scaled object keeps its size
    for (const size_t frame : {1u, 2u, 3u, 100u, 9999u}) {
        const float angle = glm::radians(std::fmod(7.0f * static_cast<float>(frame), 360.0f));
        const glm::mat3 expected = glm::mat3_cast(glm::angleAxis(angle, axis)) * glm::mat3{start};
        const glm::mat3 turned{moved(motion, {}, start, frame)};
        for (int column = 0; column < 3; ++column) {
            EXPECT_LT(glm::distance(turned[column], expected[column]), 1e-3f) << frame;
            EXPECT_NEAR(glm::length(turned[column]), glm::length(start[column]), 1e-5f) << frame;
        }
    }
}

TEST(Motion, ExistsInTheFirstFramesOfEveryPeriod)
{
    InstanceMotion motion;
    EXPECT_TRUE(exists(motion, 12345));
    motion.period = 5;
    motion.present = 2;
    motion.phase = 1;
    std::string frames;
    for (size_t frame = 0; frame < 11; ++frame) {
        frames += exists(motion, frame) ? '#' : '.';
    }
    EXPECT_EQ(frames, "#...##...##");
}

TEST(Motion, BoundsOfTheSceneHoldEveryFrame)
{
    const SceneModel model = crowd();
    const Aabb bounds = world_bounds(model);
    MovingStage moving{crowd()};
    const Stage stage = moving.stage();
    for (const size_t frame : {0u, 1u, 17u, 500u}) {
        set_frame(stage, frame);
        for (const ItemBounds& item : stage.item_bounds) {
            EXPECT_TRUE(contains(inflated(bounds, 1e-3f), item.box)) << frame;
        }
    }
}

TEST(MotionPlayer, TheSameFramesGiveTheSameIdsBoxesAndTreesAgain)
{
    MovingStage moving{crowd()};
    const Stage stage = moving.stage();
    const ItemBounds* const place = stage.item_bounds.data();
    struct State {
        std::vector<Aabb> boxes;
        std::vector<uint32_t> instances;
        std::vector<ItemId> order;
    };
    const auto play = [&] {
        std::vector<State> states;
        for (size_t frame = 0; frame < 60; ++frame) {
            set_frame(stage, frame);
            State& state = states.emplace_back();
            for (const ItemBounds& item : stage.item_bounds) {
                state.boxes.push_back(item.box);
            }
            for (const SceneModel::Item& item : moving.tiny.scene.items) {
                state.instances.push_back(item.instance);
            }
            state.order.assign(stage.hierarchy.items().begin(), stage.hierarchy.items().end());
            EXPECT_EQ(validate(stage.hierarchy), "") << frame;
        }
        return states;
    };
    const std::vector<State> first = play();
    EXPECT_GT(moving.tree->rebuild_count(), 0u) << "the case of a new tree was not met";
    EXPECT_NE(first.front().instances, first.back().instances) << "no id was used again";
    const std::vector<State> second = play();
    for (size_t frame = 0; frame < first.size(); ++frame) {
        EXPECT_EQ(first[frame].boxes, second[frame].boxes) << frame;
        EXPECT_EQ(first[frame].instances, second[frame].instances) << frame;
        EXPECT_EQ(first[frame].order, second[frame].order) << frame;
    }
    EXPECT_EQ(stage.item_bounds.data(), place);
    EXPECT_EQ(stage.item_bounds.data(), moving.tiny.scene.scene.item_bounds().data());
}

TEST(MotionPlayer, EveryLivingObjectOwnsItsItemsAndFreeSlotsAreEmpty)
{
    MovingStage moving{crowd()};
    const Stage stage = moving.stage();
    const SceneModel& model = moving.tiny.model;
    const CullScene& scene = moving.tiny.scene;
    for (size_t frame = 0; frame < 40; ++frame) {
        set_frame(stage, frame);
        std::set<uint32_t> taken;
        for (uint32_t i = 0; i < model.instances.size(); ++i) {
            const InstanceMotion& motion = model.motion.instances[i];
            ASSERT_EQ(scene.scene.alive(scene.objects[i]), exists(motion, frame));
            const std::vector<ItemDesc> parts = item_descriptions(model, i);
            for (uint32_t part = 0; exists(motion, frame) && part < parts.size(); ++part) {
                const uint32_t item = scene.scene.first_item(scene.objects[i]).value + part;
                EXPECT_TRUE(taken.insert(item).second);
                EXPECT_EQ(scene.items[item].instance, i);
                EXPECT_EQ(scene.items[item].part, part);
                EXPECT_EQ(stage.item_bounds[item].triangles, parts[part].triangles);
                EXPECT_EQ(stage.item_bounds[item].box,
                          transformed(moved(motion, model.motion.box,
                                            model.instances[i].world_from_mesh, frame),
                                      parts[part].local_box));
            }
        }
        for (uint32_t item = 0; item < stage.item_bounds.size(); ++item) {
            EXPECT_EQ(stage.item_bounds[item].box.is_empty(), !taken.contains(item));
        }
        EXPECT_EQ(stage.hierarchy.node(stage.hierarchy.root()).subtree_triangles,
                  scene.scene.triangle_count());
    }
}

TEST(MotionPlayer, ExactAlgorithmsStayExactOnTheCpuWhileEverythingMoves)
{
    MovingStage moving{crowd()};
    expect_exact(moving.stage(), path_views(moving.tiny.model, "inside", 40));
}

TEST(MotionPlayer, ExactAlgorithmsStayExactWithOpenGlWhileEverythingMoves)
{
    MovingStage moving{crowd()};
    const auto renderer = make_gl_renderer(moving.tiny.model, moving.tiny.scene.items, kSize, 1);
    ASSERT_TRUE(renderer) << renderer.error().message;
    expect_exact(moving.stage(&**renderer), path_views(moving.tiny.model, "orbit", 24));
}

TEST(MotionPlayer, ExactAlgorithmsStayExactOnTheRelinkedTreeAndReplayIt)
{
    MovingStage moving{crowd()};
    Stage refitted = moving.stage();
    TwoLevelScene two_level;
    RelinkedTree tree{two_level, {}};
    MotionPlayer player{moving.tiny.model, moving.tiny.scene, tree, refitted.renderer};
    Stage stage{two_level.hierarchy(), refitted.item_bounds, refitted.renderer};
    stage.go_to = [&](size_t frame) { player.go_to(frame); };
    const std::vector<View> views = path_views(moving.tiny.model, "inside", 30);
    set_frame(stage, 0);
    expect_exact(stage, views);
    const auto first = verify(stage, exact_testers(), views);
    const auto second = verify(stage, exact_testers(), views);
    ASSERT_TRUE(first && second);
    for (size_t i = 0; i < first->size(); ++i) {
        EXPECT_EQ(summarise((*first)[i]).decision_hash, summarise((*second)[i]).decision_hash)
            << (*first)[i].algorithm;
    }
}

TEST(MotionPlayer, BothRenderersShowTheSameObjectsAfterIdsWereUsedAgain)
{
    MovingStage moving{crowd()};
    const auto gl = make_gl_renderer(moving.tiny.model, moving.tiny.scene.items, kSize, 1);
    ASSERT_TRUE(gl) << gl.error().message;
    const std::vector<View> views = path_views(moving.tiny.model, "orbit", 30);
    const Stage on_cpu = moving.stage();
    for (size_t frame = 0; frame < views.size(); ++frame) {
        set_frame(on_cpu, frame);
    }
    const std::vector<ItemId> items = items_in_frustum(views.back(), on_cpu.item_bounds);
    const std::vector<uint32_t> cpu_ids = on_cpu.renderer.render_ids(views.back(), items);
    const Stage on_gl = moving.stage(&**gl);
    for (size_t frame = 0; frame < views.size(); ++frame) {
        set_frame(on_gl, frame);
    }
    const std::vector<uint32_t> gl_ids = on_gl.renderer.render_ids(views.back(), items);
    size_t different = 0; // edges may round differently
    for (size_t i = 0; i < cpu_ids.size(); ++i) {
        different += cpu_ids[i] != gl_ids[i] ? 1 : 0;
    }
    EXPECT_LT(different, cpu_ids.size() / 50);
}

TEST(MotionPlayer, AMissingRefitIsCaught)
{
    SceneModel model = crowd();
    for (InstanceMotion& motion : model.motion.instances) {
        motion.period = 0;
    }
    MovingStage moving{std::move(model)};
    Stage stage = moving.stage();
    // The objects move, and the tree stays as it is: another tree is refitted.
    Hierarchy refitted = moving.tiny.hierarchy;
    RefittedTree tree{refitted, moving.tiny.scene.scene, MovingStage::build};
    MotionPlayer forgetful{moving.tiny.model, moving.tiny.scene, tree, stage.renderer};
    stage.go_to = [&](size_t frame) { forgetful.go_to(frame); };
    const auto runs = verify(stage, exact_testers(), path_views(moving.tiny.model, "inside", 12));
    ASSERT_TRUE(runs);
    for (const AlgorithmRun& run : *runs) {
        EXPECT_GT(summarise(run).differing_pixels, 0u) << run.algorithm;
        EXPECT_EQ(run.frames[0].verdict->differing_pixels, 0u) << "nothing has moved yet";
    }
    EXPECT_FALSE(promises_kept(*runs));
}

TEST(Measure, RepeatsReplayTheMotion)
{
    MovingStage moving{crowd()};
    const Stage stage = moving.stage();
    const std::vector<View> views = path_views(moving.tiny.model, "inside", 20);
    const auto once = measure(stage, all_registered(), views);
    const auto twice = measure(stage, all_registered(), views, {.repeat = 2});
    const auto verified = verify(stage, all_registered(), views);
    ASSERT_TRUE(once && twice && verified);
    for (size_t i = 0; i < once->size(); ++i) {
        const std::string& name = (*once)[i].algorithm;
        EXPECT_EQ(summarise((*once)[i]).decision_hash, summarise((*twice)[i]).decision_hash)
            << name;
        EXPECT_EQ(summarise((*once)[i]).decision_hash, summarise((*verified)[i]).decision_hash)
            << name;
        EXPECT_EQ(summarise((*once)[i]).total.triangles_drawn,
                  summarise((*verified)[i]).total.triangles_drawn)
            << name;
    }
}
} // namespace occlude::tools
