#include "walk/paths.h"

#include "generate/scene_source.h"
#include "model/mesh_tools.h"
#include "support/source_dir.h"
#include "tools/temp_folder.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <cmath>

#include <sys/resource.h>

namespace occlude::tools {
namespace {

/// Two rooms of 10 m x 10 m x 3 m with a doorway of 2 m between them: x from 0 to 20, z 0 to 10.
SceneModel two_rooms()
{
    MeshBuilder builder;
    const auto wall = [&](const glm::vec3& low, const glm::vec3& high) { builder.box(low, high); };
    wall({-0.2f, -0.2f, -0.2f}, {20.2f, 0.0f, 10.2f}); // floor
    wall({-0.2f, 3.0f, -0.2f}, {20.2f, 3.2f, 10.2f});  // ceiling
    wall({-0.2f, 0.0f, -0.2f}, {0.0f, 3.0f, 10.2f});
    wall({20.0f, 0.0f, -0.2f}, {20.2f, 3.0f, 10.2f});
    wall({0.0f, 0.0f, -0.2f}, {20.0f, 3.0f, 0.0f});
    wall({0.0f, 0.0f, 10.0f}, {20.0f, 3.0f, 10.2f});
    wall({9.9f, 0.0f, 0.0f}, {10.1f, 3.0f, 4.0f}); // beside the doorway
    wall({9.9f, 0.0f, 6.0f}, {10.1f, 3.0f, 10.0f});
    SceneModel model;
    model.name = "two rooms";
    model.meshes.push_back(builder.take("rooms", 1000));
    model.instances.push_back({"rooms", 0, glm::mat4{1.0f}, glm::vec3{0.7f}});
    return model;
}

SceneModel small_object()
{
    MeshBuilder builder;
    builder.box(glm::vec3{-1.0f}, glm::vec3{1.0f});
    SceneModel model;
    model.name = "cube";
    model.meshes.push_back(builder.take("cube", 1000));
    model.instances.push_back({"cube", 0, glm::mat4{1.0f}, glm::vec3{0.7f}});
    return model;
}

std::vector<Camera> path(const std::string& name, const SceneModel& model, size_t frames)
{
    auto cameras = load_path(name, model, frames);
    EXPECT_TRUE(cameras) << (cameras ? "" : cameras.error().message);
    return cameras ? *cameras : std::vector<Camera>{};
}

void expect_inside_rooms(const std::vector<Camera>& cameras)
{
    for (const Camera& camera : cameras) {
        const glm::vec3& eye = camera.eye;
        EXPECT_NEAR(eye.y, 1.7f, 0.35f);
        EXPECT_GT(eye.x, 0.2f);
        EXPECT_LT(eye.x, 19.8f);
        EXPECT_GT(eye.z, 0.2f);
        EXPECT_LT(eye.z, 9.8f);
        const bool in_wall = eye.x > 9.8f && eye.x < 10.2f && (eye.z < 4.0f || eye.z > 6.0f);
        EXPECT_FALSE(in_wall) << eye.x << " " << eye.z;
    }
}

TEST(WalkPath, GoesThroughTheDoorwayAndNeverThroughAWall)
{
    const std::vector<Camera> walk = path("walk", two_rooms(), 400);
    ASSERT_EQ(walk.size(), 400u);
    expect_inside_rooms(walk);
    bool in_first = false;
    bool in_second = false;
    for (size_t i = 1; i < walk.size(); ++i) {
        in_first |= walk[i].eye.x < 8.0f;
        in_second |= walk[i].eye.x > 12.0f;
        EXPECT_LT(glm::distance(walk[i - 1].eye, walk[i].eye), 0.7f) << "frame " << i;
    }
    EXPECT_TRUE(in_first && in_second) << "it should have been in both rooms";
}

TEST(WalkPath, FewFramesWalkAShortWayAtAHumanPace)
{
    const std::vector<Camera> walk = path("walk", two_rooms(), 20);
    ASSERT_EQ(walk.size(), 20u);
    for (size_t i = 1; i < walk.size(); ++i) {
        EXPECT_LT(glm::distance(walk[i - 1].eye, walk[i].eye), 0.8f);
    }
}

TEST(WalkPath, IsTheSameEveryTime)
{
    const std::vector<Camera> first = path("auto", two_rooms(), 100);
    const std::vector<Camera> second = path("auto", two_rooms(), 100);
    for (size_t i = 0; i < first.size(); ++i) {
        EXPECT_EQ(first[i].eye, second[i].eye);
        EXPECT_EQ(first[i].target, second[i].target);
    }
}

// Runs with different --item-triangles must compare, so that their cameras must be equal.
TEST(WalkPath, DoesNotDependOnHowMeshesAreCutIntoItems)
{
    const std::string castle = source_dir() + "/assets/castle/castle.glb";
    const auto whole = load_scene(castle, {.item_triangles = 100000});
    const auto cut = load_scene(castle, {.item_triangles = 256});
    ASSERT_TRUE(whole && cut);
    const std::vector<Camera> first = path("walk", *whole, 20);
    const std::vector<Camera> second = path("walk", *cut, 20);
    ASSERT_EQ(first.size(), second.size());
    for (size_t i = 0; i < first.size(); ++i) {
        EXPECT_LT(glm::distance(first[i].eye, second[i].eye), 0.01f) << "frame " << i;
        EXPECT_LT(glm::distance(first[i].target, second[i].target), 0.01f) << "frame " << i;
    }
}

/// The most memory that this process ever had, in MiB.
long peak_memory_mib()
{
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss / 1024;
}

// Coarse cells for what there is to see were as many as cells once, and took 600 MiB.
TEST(WalkPath, OfASceneMuchLargerThanItsWalkersNeedsLittleMemory)
{
    SceneModel model = small_object();
    const glm::mat4 box = model.instances[0].world_from_mesh;
    for (int i = 0; i < 3000; ++i) { // in a cube of 20 km
        const glm::vec3 at{i % 15, (i / 15) % 15, i / 225};
        model.instances.push_back({"box", 0, box, glm::vec3{0.7f}});
        model.instances.back().world_from_mesh[3] = glm::vec4{1400.0f * at, 1.0f};
    }
    const long before = peak_memory_mib();
    path("walk", model, 4);
    EXPECT_LT(peak_memory_mib() - before, 150);
}

TEST(WalkPath, WorksInOtherUnits)
{
    SceneModel model = two_rooms();
    constexpr float kUnit = 40.0f;
    for (Instance& instance : model.instances) {
        instance.world_from_mesh = glm::mat4{kUnit};
        instance.world_from_mesh[3][3] = 1.0f;
    }
    model.unit = kUnit;
    std::vector<Camera> walk = path("walk", model, 100);
    for (Camera& camera : walk) {
        camera.eye /= kUnit;
    }
    expect_inside_rooms(walk);
}

TEST(WalkPath, WorksWithZUp)
{
    SceneModel model = two_rooms();
    model.up = {0.0f, 0.0f, 1.0f};
    for (Instance& instance : model.instances) { // y to z, z to -y
        instance.world_from_mesh[1] = {0.0f, 0.0f, 1.0f, 0.0f};
        instance.world_from_mesh[2] = {0.0f, -1.0f, 0.0f, 0.0f};
    }
    std::vector<Camera> walk = path("walk", model, 100);
    ASSERT_EQ(walk.size(), 100u);
    for (Camera& camera : walk) {
        EXPECT_EQ(camera.up, model.up);
        camera.eye = {camera.eye.x, camera.eye.z, -camera.eye.y};
    }
    expect_inside_rooms(walk);
}

TEST(AutoPath, OrbitsAnObjectWithoutFloorsAndKeepsAllOfItInView)
{
    const SceneModel model = small_object();
    const auto walk = load_path("walk", model, 10);
    ASSERT_FALSE(walk);
    EXPECT_NE(walk.error().message.find("no floors"), std::string::npos);

    std::vector<Camera> cameras = path("auto", model, 30);
    choose_depth_range(cameras, model);
    for (const Camera& camera : cameras) {
        const View view = make_view(camera, {640, 480});
        EXPECT_EQ(view.frustum().classify(world_bounds(model)), Containment::inside);
    }
}

TEST(AutoPath, WalksWhereThereAreFloors)
{
    expect_inside_rooms(path("auto", two_rooms(), 60));
}

TEST(OverviewPath, SeesTheWholeSceneFromAboveWithoutMoving)
{
    const SceneModel model = two_rooms();
    std::vector<Camera> cameras = path("overview", model, 5);
    choose_depth_range(cameras, model);
    for (const Camera& camera : cameras) {
        EXPECT_EQ(camera.eye, cameras[0].eye);
        EXPECT_GT(camera.eye.y, world_bounds(model).max.y);
        const View view = make_view(camera, {1280, 720});
        EXPECT_EQ(view.frustum().classify(world_bounds(model)), Containment::inside);
    }
}

TEST(SpinPath, TurnsOnceAroundOnTheSpot)
{
    const std::vector<Camera> cameras = path("spin", two_rooms(), 37);
    expect_inside_rooms(cameras);
    float turned = 0.0f;
    for (size_t i = 1; i < cameras.size(); ++i) {
        EXPECT_EQ(cameras[i].eye, cameras[0].eye);
        const glm::vec3 a = glm::normalize(cameras[i - 1].target - cameras[i - 1].eye);
        const glm::vec3 b = glm::normalize(cameras[i].target - cameras[i].eye);
        turned += std::acos(glm::clamp(glm::dot(a, b), -1.0f, 1.0f));
    }
    EXPECT_NEAR(turned, 6.2832f, 0.05f);
}

TEST(TeleportPath, CutsAndTurnsBy90Degrees)
{
    const std::vector<Camera> cameras = path("teleport", two_rooms(), 160);
    expect_inside_rooms(cameras);
    size_t jumps = 0;
    size_t turns = 0;
    for (size_t i = 1; i < cameras.size(); ++i) {
        const glm::vec3 a = glm::normalize(cameras[i - 1].target - cameras[i - 1].eye);
        const glm::vec3 b = glm::normalize(cameras[i].target - cameras[i].eye);
        const float moved = glm::distance(cameras[i - 1].eye, cameras[i].eye);
        jumps += moved > 1.5f;
        turns += moved < 1.0f && std::abs(glm::dot(a, b)) < 0.5f;
    }
    EXPECT_GE(jumps, 4u);
    EXPECT_GE(turns, 6u);
}

TEST(NamedPath, OfTheSceneComesFirst)
{
    const auto city = load_scene("city:blocks=3,triangles=200k");
    ASSERT_TRUE(city);
    const std::vector<Camera> street = path("street", *city, 10);
    const std::vector<Camera> by_default = path("auto", *city, 10);
    EXPECT_EQ(street[5].eye, by_default[5].eye);
    for (const PathInfo& info : path_names(*city)) {
        EXPECT_EQ(path(info.name, *city, 7).size(), 7u) << info.name;
        EXPECT_FALSE(info.description.empty());
    }
}

TEST(NamedPath, AnUnknownNameListsTheKnownOnes)
{
    const auto cameras = load_path("flight", two_rooms(), 10);
    ASSERT_FALSE(cameras);
    for (const char* part : {"flight", "auto", "walk", "orbit", "overview", "teleport", "spin"}) {
        EXPECT_NE(cameras.error().message.find(part), std::string::npos) << part;
    }
}

TEST(NamedPath, NoFramesAreAnError)
{
    EXPECT_FALSE(load_path("orbit", small_object(), 0));
}

TEST(DepthRange, HoldsTheWholeSceneAndLeavesWhatIsSetAlone)
{
    const SceneModel model = two_rooms();
    std::vector<Camera> cameras = path("walk", model, 20);
    cameras[3].near = 0.5f;
    cameras[4].far = 7.0f;
    choose_depth_range(cameras, model);
    EXPECT_EQ(cameras[3].near, 0.5f);
    EXPECT_EQ(cameras[4].far, 7.0f);
    for (const Camera& camera : cameras) {
        EXPECT_GT(camera.near, 0.0f);
        EXPECT_LT(camera.near, 0.6f);
        EXPECT_GT(camera.far, camera.near);
    }
    EXPECT_GT(cameras[0].far, glm::distance(cameras[0].eye, glm::vec3{20.2f, 3.2f, 10.2f}));
}

TEST(PathFile, WhatIsWrittenIsReadBack)
{
    const TempFolder folder;
    std::vector<Camera> cameras(3);
    cameras[1].eye = {1.25f, -2.5f, 3.75f};
    cameras[1].target = {4.0f, 0.1f, 0.2f};
    cameras[1].up = {0.0f, 0.0f, 1.0f};
    cameras[1].fov_y = 45.5f;
    cameras[2].near = 0.25f;
    cameras[2].far = 1234.5f;
    const auto written = write_path_file(folder.path("path.json"), cameras);
    ASSERT_TRUE(written) << written.error().message;
    const std::vector<Camera> read = path(folder.path("path.json"), small_object(), 100);
    ASSERT_EQ(read.size(), 3u);
    for (size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(read[i].eye, cameras[i].eye);
        EXPECT_EQ(read[i].target, cameras[i].target);
        EXPECT_EQ(read[i].up, cameras[i].up);
        EXPECT_EQ(read[i].fov_y, cameras[i].fov_y);
        EXPECT_EQ(read[i].near, cameras[i].near);
        EXPECT_EQ(read[i].far, cameras[i].far);
    }
    EXPECT_EQ(path(folder.path("path.json"), small_object(), 2).size(), 2u);
    EXPECT_FALSE(write_path_file("/nowhere/at/all/path.json", cameras));
}

TEST(PathFile, KeyframesAreInterpolated)
{
    const TempFolder folder;
    const std::string file = folder.write(
        "keys.json", R"({"version":1,"keyframes":[{"time":0,"eye":[0,0,0],"target":[0,0,-1]},
        {"time":2,"eye":[4,0,0],"target":[4,0,-1]},{"time":3,"eye":[9,9,9],"target":[9,9,8],"cut":true}]})");
    const std::vector<Camera> frames = path(file, small_object(), 4);
    ASSERT_EQ(frames.size(), 4u);
    EXPECT_NEAR(frames[1].eye.x, 2.0f, 1e-4f);
    EXPECT_NEAR(frames[2].eye.x, 4.0f, 1e-4f);
    EXPECT_EQ(frames[3].eye, glm::vec3(9.0f));
}

void expect_error(const std::string& content, const std::string& part)
{
    const TempFolder folder;
    const std::string file = folder.write("path.json", content);
    const auto cameras = load_path(file, small_object(), 10);
    ASSERT_FALSE(cameras) << content;
    EXPECT_NE(cameras.error().message.find(file), std::string::npos) << cameras.error().message;
    EXPECT_NE(cameras.error().message.find(part), std::string::npos) << cameras.error().message;
}

TEST(PathFile, ErrorsNameTheFileAndThePlace)
{
    expect_error("", "not JSON");
    expect_error("{\"version\":1,", "not JSON");
    expect_error("[]", "must hold");
    expect_error(R"({"frames":[]})", "version");
    expect_error(R"({"version":2,"frames":[]})", "version");
    expect_error(R"({"version":1})", "neither");
    expect_error(R"({"version":1,"frames":[]})", "needs frames");
    expect_error(R"({"version":1,"frames":7})", "needs frames");
    expect_error(R"({"version":1,"keyframes":[]})", "needs frames");
    expect_error(R"({"version":1,"frames":[3]})", "frames[0]");
    expect_error(R"({"version":1,"frames":[{"target":[0,0,0]}]})", "\"eye\"");
    expect_error(R"({"version":1,"frames":[{"eye":[0,0],"target":[0,0,0]}]})", "frames[0].eye");
    expect_error(R"({"version":1,"frames":[{"eye":[0,0,1],"target":["a",0,0]}]})",
                 "frames[0].target");
    expect_error(R"({"version":1,"frames":[{"eye":[0,0,1e99],"target":[0,0,0]}]})",
                 "frames[0].eye");
    expect_error(R"({"version":1,"frames":[{"eye":[0,0,0],"target":[0,0,0]}]})", "same point");
    expect_error(R"({"version":1,"frames":[{"eye":[0,0,1],"target":[0,0,0],"fov_y":200}]})",
                 "fov_y");
    expect_error(R"({"version":1,"frames":[{"eye":[0,0,1],"target":[0,0,0],"near":3,"far":2}]})",
                 "far");
    expect_error(R"({"version":1,"frames":[{"eye":[0,0,1],"target":[0,0,0],"up":[0,0,0]}]})", "up");
    expect_error(R"({"version":1,"keyframes":[{"eye":[0,0,1],"target":[0,0,0]}]})", "\"time\"");
    expect_error(R"({"version":1,"keyframes":[{"time":1,"eye":[0,0,1],"target":[0,0,0]},
                     {"time":1,"eye":[0,0,1],"target":[0,0,0]}]})",
                 "keyframes[1].time");
    EXPECT_FALSE(load_path("/nowhere/path.json", small_object(), 10));
}

} // namespace
} // namespace occlude::tools
