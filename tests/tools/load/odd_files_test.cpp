// Unusual files and their correct scenes. See tests/data/scenes/README.md.
#include "generate/scene_source.h"
#include "load/assimp_files.h"
#include "model/focus.h"
#include "support/source_dir.h"
#include "tools/temp_folder.h"
#include "walk/paths.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <set>

namespace occlude::tools {
namespace {

std::string odd_file(const std::string& name)
{
    return source_dir() + "/tests/data/scenes/" + name;
}

SceneModel load_odd(const std::string& name, const SceneOptions& options = {})
{
    auto model = load_scene(odd_file(name), options);
    EXPECT_TRUE(model) << model.error().message;
    return model ? std::move(*model) : SceneModel{};
}

std::string all_of(const std::vector<std::string>& lines)
{
    std::string text;
    for (const std::string& line : lines) {
        text += line + "\n";
    }
    return text;
}

void expect_bounds(const Aabb& box, const glm::vec3& low, const glm::vec3& high, float tolerance)
{
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(box.min[axis], low[axis], tolerance) << "axis " << axis;
        EXPECT_NEAR(box.max[axis], high[axis], tolerance) << "axis " << axis;
    }
}

TEST(OddFiles, QuantisedPositionsAreThoseOfTheFloatFile)
{
    const Aabb right = world_bounds(load_odd("f01_quant_float.glb"));
    for (const char* name : {"f01_quant_i16.glb", "f01_quant_i8.glb", "f01_quant_u16.glb"}) {
        const SceneModel model = load_odd(name);
        EXPECT_EQ(drawn_triangles(model), 300u) << name;
        expect_bounds(world_bounds(model), right.min, right.max, 0.05f);
    }
}

TEST(OddFiles, InstancesOfAnExtensionAreObjects)
{
    for (const char* name : {"f04_instancing_required.glb", "f04_instancing_used.glb"}) {
        const SceneModel model = load_odd(name);
        EXPECT_EQ(model.instances.size(), 125u) << name;
        EXPECT_EQ(model.meshes.size(), 1u) << name;
    }
}

TEST(OddFiles, ABrokenCompressedBufferViewIsRefusedByTheNameOfItsExtension)
{
    const auto model = load_scene(odd_file("f05_meshopt.glb")); // its bytes are not compressed
    ASSERT_FALSE(model);
    EXPECT_NE(model.error().message.find("EXT_meshopt_compression"), std::string::npos)
        << model.error().message;
}

TEST(OddFiles, InvisibleNodesAreNotThere)
{
    const SceneModel model = load_odd("f07_invisible_wall.glb");
    EXPECT_EQ(model.instances.size(), 26u);
    EXPECT_LT(world_bounds(model).max.y, 13.0f);
}

TEST(OddFiles, AnUnknownExtensionThatIsRequiredIsRefusedByName)
{
    const auto model = load_scene(odd_file("f07_unknown_required.glb"));
    ASSERT_FALSE(model);
    EXPECT_NE(model.error().message.find("ACME_secret_geometry"), std::string::npos)
        << model.error().message;
}

TEST(OddFiles, SkinnedNodesStandWhereTheirJointsAre)
{
    const SceneModel model = load_odd("f15b_skin_ibm_scaled_node.glb");
    ASSERT_EQ(model.instances.size(), 6u);
    EXPECT_NEAR(world_bounds(model).extent().y, 1.8f, 1e-3f);
    EXPECT_NEAR(world_bounds(model).extent().x, 15.6f, 1e-3f) << "six people, 3 m apart";
}

TEST(OddFiles, TrianglesThatAreNotFiniteAreCounted)
{
    for (const char* name : {"f16_nan.glb", "f16_huge.glb"}) {
        const SceneModel model = load_odd(name);
        EXPECT_NE(all_of(model.load_losses).find("not a finite number"), std::string::npos) << name;
        EXPECT_GT(model.file_triangles, drawn_triangles(model)) << name;
    }
    const auto infinite = load_scene(odd_file("f34_infinite.glb"));
    ASSERT_FALSE(infinite);
    EXPECT_NE(infinite.error().message.find("not a finite number"), std::string::npos)
        << infinite.error().message;
    EXPECT_NE(infinite.error().message.find("with finite coordinates"), std::string::npos)
        << infinite.error().message;
}

TEST(OddFiles, PointsAndLinesAreCounted)
{
    const std::string losses = all_of(load_odd("f18_points_lines.glb").load_losses);
    EXPECT_NE(losses.find(" points"), std::string::npos) << losses;
    EXPECT_NE(losses.find(" lines"), std::string::npos) << losses;
}

TEST(OddFiles, EscapedNamesAndByteOrderMarksAreRead)
{
    EXPECT_GT(load_odd("f19 with spaces.gltf").instances.size(), 1u);
    EXPECT_GT(load_odd("f19_bom.gltf").instances.size(), 1u);
}

TEST(OddFiles, WhatLetsLightThroughHidesNothing)
{
    const auto hides_nothing = [](const SceneModel& model) {
        return std::count_if(model.instances.begin(), model.instances.end(),
                             [](const Instance& instance) { return instance.translucent(); });
    };
    EXPECT_EQ(hides_nothing(load_odd("f25_opaque_screen.glb")), 0);
    for (const char* name :
         {"f25_blend_alpha_one.glb", "f25_blend_alpha_zero.glb", "f25_transmission.glb"}) {
        const SceneModel model = load_odd(name);
        EXPECT_GE(hides_nothing(model), 1) << name;
        EXPECT_NE(all_of(model.load_notes).find("hide nothing"), std::string::npos) << name;
    }
}

TEST(OddFiles, CamerasAreOfferedAsPaths)
{
    const SceneModel model = load_odd("f30_cameras.glb");
    const auto cameras = load_path("camera:street view", model, 3);
    ASSERT_TRUE(cameras) << cameras.error().message;
    ASSERT_EQ(cameras->size(), 3u);
    EXPECT_EQ(cameras->front().eye, glm::vec3(5.0f, 1.7f, -10.0f));
    EXPECT_NEAR(cameras->front().fov_y, 40.107f, 1e-2f);
    EXPECT_NE(all_of(model.load_notes).find("orthographic"), std::string::npos);
    const auto automatic = load_path("auto", model, 20);
    ASSERT_TRUE(automatic);
    EXPECT_NE(automatic->front().eye, automatic->back().eye) << "a path, not a camera of the file";
    const auto unknown = load_path("camera:roof", model, 3);
    ASSERT_FALSE(unknown);
    EXPECT_NE(unknown.error().message.find("camera:street view"), std::string::npos);
}

TEST(OddFiles, AFileThatCrashedTheProgramIsReadOrRefusedWithASentence)
{
    const auto model = load_scene(odd_file("f32_two_groups.raw"));
    if (model) {
        EXPECT_EQ(drawn_triangles(*model), 2u);
    } else {
        EXPECT_NE(model.error().message.find("f32_two_groups.raw"), std::string::npos);
    }
}

TEST(OddFiles, IfcOfVersion4x3IsReadOrNamedAsWhatItIs)
{
    const auto model = load_scene(odd_file("f10_ifc4x3.ifc"));
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ(drawn_triangles(*model), 480u);
    EXPECT_EQ(model->instances.size(), 40u);
}

TEST(OddFiles, TheAxisThatIsUpIsGuessedByGroundAndFloors)
{
    EXPECT_EQ(load_odd("f33_yup_town.obj").up, glm::vec3(0.0f, 1.0f, 0.0f));
    EXPECT_EQ(load_odd("f33_zup_town.obj").up, glm::vec3(0.0f, 0.0f, 1.0f));
    const SceneModel told = load_odd("f33_zup_town.obj", {.up = glm::vec3{0.0f, 1.0f, 0.0f}});
    EXPECT_EQ(told.up, glm::vec3(0.0f, 1.0f, 0.0f));
}

TEST(OddFiles, AWalkInAZUpTownStaysOnItsStreets)
{
    const SceneModel model = load_odd("f33_zup_town.obj");
    const auto walk = load_path("walk", model, 30);
    ASSERT_TRUE(walk) << walk.error().message;
    for (const Camera& camera : *walk) {
        EXPECT_NEAR(camera.eye.z, 1.7f, 0.4f);
    }
}

TEST(OddFiles, UnitsAreGuessedFromSizesAndCanBeTold)
{
    EXPECT_EQ(load_odd("f35_mm_town.obj").unit, 1000.0f);
    EXPECT_EQ(load_odd("f33_yup_town.obj").unit, 1.0f);
    EXPECT_EQ(load_odd("f35_mm_town.obj", {.units_per_metre = 100.0f}).unit, 100.0f);
}

TEST(OddFiles, BuiltInPathsLookAtTheBulkOfTheScene)
{
    for (const char* name : {"f14_stray_marker.glb", "f36_two_towns_mm.glb"}) {
        const SceneModel model = load_odd(name);
        const Focus focus = find_focus(model);
        EXPECT_GT(focus.left_out, 0u) << name;
        EXPECT_NE(all_of(model.load_notes).find("stand far away"), std::string::npos) << name;
        const auto path = load_path("auto", model, 4);
        ASSERT_TRUE(path) << path.error().message;
        for (const Camera& camera : *path) {
            EXPECT_LT(glm::distance(camera.eye, focus.box.center()),
                      4.0f * glm::length(focus.box.extent()))
                << name;
        }
    }
}

TEST(OddFiles, TheSameTownFarAwayIsTheSameTown)
{
    const SceneModel near = load_odd("g_near.glb");
    EXPECT_EQ(near.origin, glm::dvec3{0.0});
    for (const char* name : {"g_far16k.glb", "g_far100k.glb", "g_far8m.glb"}) {
        const SceneModel far = load_odd(name);
        EXPECT_NE(far.origin, glm::dvec3{0.0}) << name;
        ASSERT_EQ(far.instances.size(), near.instances.size()) << name;
        // Places are relative to the first object, so that the position of the origin does not
        // matter.
        for (size_t i = 1; i < near.instances.size(); ++i) {
            const glm::vec4 right =
                near.instances[i].world_from_mesh[3] - near.instances[0].world_from_mesh[3];
            const glm::vec4 read =
                far.instances[i].world_from_mesh[3] - far.instances[0].world_from_mesh[3];
            EXPECT_LT(glm::distance(right, read), 1e-4f) << name << ", object " << i;
        }
    }
}

TEST(OddFiles, PathFilesAreInTheCoordinatesOfTheFile)
{
    const SceneModel far = load_odd("g_far8m.glb");
    const auto cameras = load_path(odd_file("g_far8m.json"), far, 2);
    ASSERT_TRUE(cameras) << cameras.error().message;
    const glm::dvec3 eye = glm::dvec3{cameras->front().eye} + far.origin;
    EXPECT_NEAR(eye.x, 1661270.0, 1e-3);
    EXPECT_NEAR(eye.z, -8178676.0, 1e-3);
    EXPECT_LT(glm::length(cameras->front().eye), 1000.0f);
}

TEST(OddFiles, ScenesOfAnySizeAreInViewOfTheBuiltInPaths)
{
    for (const char* name : {"f20_tiny_1e-6.glb", "f20_big_1e9.glb"}) {
        const SceneModel model = load_odd(name);
        for (const char* path : {"orbit", "overview"}) {
            auto cameras = load_path(path, model, 4);
            ASSERT_TRUE(cameras) << name;
            choose_depth_range(*cameras, model);
            const Aabb box = world_bounds(model);
            for (const Camera& camera : *cameras) {
                const float distance = glm::distance(camera.eye, box.center());
                const float size = glm::length(box.extent());
                EXPECT_LT(distance, 4.0f * size) << name;
                EXPECT_GT(distance, 0.3f * size) << name;
                EXPECT_LT(camera.near, 0.1f * size) << name;
                EXPECT_GT(camera.far, distance) << name;
            }
        }
    }
}

TEST(OddFiles, UnknownKeysOfPathFilesAreRefusedWithTheNearestKnownOne)
{
    const SceneModel model = load_odd("f30_cameras.glb");
    const auto fov = load_path(odd_file("typo_fov.json"), model, 2);
    ASSERT_FALSE(fov);
    EXPECT_NE(fov.error().message.find("unknown key \"fov\"; did you mean \"fov_y\""),
              std::string::npos)
        << fov.error().message;
    const auto mover = load_path(odd_file("top_typo.json"), model, 2);
    ASSERT_FALSE(mover);
    EXPECT_NE(mover.error().message.find("did you mean \"movers\""), std::string::npos)
        << mover.error().message;
}

std::string utf16(const std::string& ascii, bool little)
{
    std::string text = little ? "\xFF\xFE" : "\xFE\xFF";
    for (const char c : ascii) {
        text += little ? std::string{c, '\0'} : std::string{'\0', c};
    }
    return text;
}

TEST(OddFiles, TextInUtf16IsReadWhicheverWayItsBytesGo)
{
    const std::string quad = "o quad\nv 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nf 1 2 3 4\n";
    const TempFolder folder;
    for (const bool little : {true, false}) {
        const auto model = load_scene(folder.write("quad.obj", utf16(quad, little)));
        ASSERT_TRUE(model) << model.error().message;
        EXPECT_EQ(drawn_triangles(*model), 2u);
        expect_bounds(world_bounds(*model), {0, 0, 0}, {4, 4, 0}, 1e-5f);
    }
    EXPECT_EQ(utf8_of_utf16({"\xFF\xFE\xE9\x00\x3D\xD8\x00\xDE", 8}), "\xC3\xA9\xF0\x9F\x98\x80");
    EXPECT_EQ(utf8_of_utf16({"\xFF\xFE\x3D\xD8\x41\x00", 6}), "") << "half a pair is no text";
    EXPECT_EQ(utf8_of_utf16("plain"), "");
}

TEST(OddFiles, NodesInACircleAreToldFromNodesThatAreDeep)
{
    const TempFolder folder;
    const auto ring =
        load_scene(folder.write("ring.gltf", R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],
                         "nodes":[{"children":[1]},{"children":[0,2]},{}]})"));
    ASSERT_FALSE(ring);
    EXPECT_NE(ring.error().message.find("in a circle"), std::string::npos) << ring.error().message;
}

TEST(OddFiles, PrimitivesThatAreNoListAreNamed)
{
    const TempFolder folder;
    const auto scene = load_scene(folder.write(
        "bad.gltf", R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
                        "meshes":[{"primitives":{"a":1}}]})"));
    ASSERT_FALSE(scene);
    EXPECT_NE(scene.error().message.find("mesh 0 has no primitives"), std::string::npos)
        << scene.error().message;
}

TEST(OddFiles, WhatAssimpFindsNothingInIsNotCalledEmpty)
{
    const TempFolder folder;
    const auto scene = load_scene(folder.write(
        "cube.irr", "<?xml version=\"1.0\"?><irr_scene><node type=\"cube\"></node></irr_scene>"));
    ASSERT_FALSE(scene);
    EXPECT_NE(scene.error().message.find("Assimp"), std::string::npos) << scene.error().message;
    const auto unknown = load_scene(folder.write("cube.m3d", "3DMO"));
    ASSERT_FALSE(unknown);
    EXPECT_NE(unknown.error().message.find("no reader for files that end in '.m3d'"),
              std::string::npos)
        << unknown.error().message;
}

} // namespace
} // namespace occlude::tools
