// Triangles and objects that a file holds twice: which are drawn once, which twice, and the
// messages.
#include "generate/scene_source.h"
#include "tools/temp_folder.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstring>

namespace occlude::tools {
namespace {

using nlohmann::json;

bool is_noted(const SceneModel& model, const std::string& part)
{
    return std::any_of(
        model.load_notes.begin(), model.load_notes.end(),
        [&](const std::string& note) { return note.find(part) != std::string::npos; });
}

/// Four points; the triangle (0, 1, 2) twice with the same side out, once turned; and another one.
/// `nodes` place mesh 0 (opaque), 1 (the same in red) or 2 (blended).
SceneModel load_nodes(const TempFolder& folder, const json& nodes)
{
    const float points[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const uint16_t corners[12] = {0, 1, 2, 1, 2, 0, 0, 2, 1, 0, 1, 3};
    std::string bytes(sizeof points + sizeof corners, '\0');
    std::memcpy(bytes.data(), points, sizeof points);
    std::memcpy(bytes.data() + sizeof points, corners, sizeof corners);
    folder.write("data.bin", bytes);
    json root{{"asset", {{"version", "2.0"}}}, {"nodes", nodes}};
    for (int material = 0; material < 3; ++material) {
        root["meshes"].push_back(
            {{"primitives",
              {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}, {"material", material}}}}});
    }
    root["materials"] = {{{"pbrMetallicRoughness", {{"baseColorFactor", {0.2, 0.5, 0.2, 1.0}}}}},
                         {{"pbrMetallicRoughness", {{"baseColorFactor", {0.8, 0.1, 0.1, 1.0}}}}},
                         {{"alphaMode", "BLEND"},
                          {"pbrMetallicRoughness", {{"baseColorFactor", {0.2, 0.5, 0.2, 0.5}}}}}};
    root["accessors"] = {
        {{"bufferView", 0}, {"componentType", 5126}, {"count", 4}, {"type", "VEC3"}},
        {{"bufferView", 1}, {"componentType", 5123}, {"count", 12}, {"type", "SCALAR"}}};
    root["bufferViews"] = {
        {{"buffer", 0}, {"byteLength", sizeof points}},
        {{"buffer", 0}, {"byteOffset", sizeof points}, {"byteLength", sizeof corners}}};
    root["buffers"] = {{{"byteLength", bytes.size()}, {"uri", "data.bin"}}};
    auto model = load_scene(folder.write("scene.gltf", root.dump()));
    EXPECT_TRUE(model) << model.error().message;
    return model ? std::move(*model) : SceneModel{};
}

TEST(Duplicates, ATriangleOfAnOpaqueMeshIsDrawnOnceAndItsBackToo)
{
    const TempFolder folder;
    const SceneModel model = load_nodes(folder, {{{"mesh", 0}}});
    EXPECT_EQ(model.file_triangles, 4u);
    EXPECT_EQ(drawn_triangles(model), 3u);
    EXPECT_TRUE(
        is_noted(model, "1 triangles repeat another one of their mesh: each is drawn once"));
    EXPECT_TRUE(is_noted(model, "1 triangles are the back of another one"));
    EXPECT_TRUE(model.load_losses.empty()) << "nothing is lost";
}

TEST(Duplicates, WhatIsBlendedTwiceIsDrawnTwice)
{
    const TempFolder folder;
    const SceneModel model = load_nodes(folder, {{{"mesh", 2}}, {{"mesh", 2}}});
    EXPECT_EQ(model.instances.size(), 2u);
    EXPECT_EQ(drawn_triangles(model), 8u);
    EXPECT_TRUE(
        is_noted(model, "2 triangles are the back of another one of their mesh, or repeat"));
}

TEST(Duplicates, EqualObjectsInOnePlaceAreDrawnOnce)
{
    const TempFolder folder;
    const SceneModel model =
        load_nodes(folder, {{{"mesh", 0}, {"name", "first"}},
                            {{"mesh", 0}, {"name", "second"}},
                            {{"mesh", 0}, {"name", "moved"}, {"translation", {0.0, 0.0, 1e-9}}},
                            {{"mesh", 0}, {"name", "third"}, {"translation", {0.0, -0.0, 0.0}}}});
    ASSERT_EQ(model.instances.size(), 2u);
    EXPECT_EQ(model.instances[0].name, "first");
    EXPECT_EQ(model.instances[1].name, "moved");
    EXPECT_EQ(model.file_triangles, 16u) << "the file holds them all";
    EXPECT_TRUE(is_noted(model, "2 objects stand exactly where an equal one does"));
}

TEST(Duplicates, ObjectsThatDifferInTheSeventhDigitFarAwayAreTwo)
{
    const TempFolder folder;
    const SceneModel model =
        load_nodes(folder, {{{"mesh", 0}, {"translation", {1e7, 0.0, 0.0}}},
                            {{"mesh", 0}, {"translation", {1e7 + 0.125, 0.0, 0.0}}}});
    EXPECT_EQ(model.instances.size(), 2u);
    EXPECT_FALSE(is_noted(model, "stand exactly"));
}

TEST(Duplicates, AnotherColourInTheSamePlaceIsKeptAndSaid)
{
    const TempFolder folder;
    const SceneModel model = load_nodes(folder, {{{"mesh", 0}}, {{"mesh", 1}}});
    EXPECT_EQ(model.instances.size(), 2u);
    EXPECT_TRUE(is_noted(model, "1 objects stand exactly where an object of the same shape"));
}

} // namespace
} // namespace occlude::tools
