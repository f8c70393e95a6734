// Findings about properties of a scene that make culling useless: each with its names, and when it
// is not reported.
#include "model/mesh_tools.h"
#include "model/scene_advice.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <algorithm>

namespace occlude::tools {
namespace {

constexpr uint32_t kItem = 64;

/// A closed box cut into `rows` strips on two of its faces: 8 + 4 rows triangles.
Mesh box_of(const std::string& name, const glm::vec3& size, int rows = 1)
{
    MeshBuilder builder;
    builder.box(glm::vec3{0.0f}, size,
                MeshBuilder::kAllFaces & ~(MeshBuilder::kPosZ | MeshBuilder::kNegZ));
    for (int i = 0; i < rows; ++i) {
        const float low = size.y * static_cast<float>(i) / static_cast<float>(rows);
        const float high = size.y * static_cast<float>(i + 1) / static_cast<float>(rows);
        builder.quad({0, low, size.z}, {size.x, low, size.z}, {size.x, high, size.z},
                     {0, high, size.z});
        builder.quad({size.x, low, 0}, {0, low, 0}, {0, high, 0}, {size.x, high, 0});
    }
    return builder.take(name, kItem);
}

void place(SceneModel& model, uint32_t mesh, const std::string& name, const glm::vec3& at)
{
    model.instances.push_back(
        {.name = name, .mesh = mesh, .world_from_mesh = glm::translate(glm::mat4{1.0f}, at)});
}

/// A grid of 8 x 8 houses, each an object of 72 triangles.
SceneModel town()
{
    SceneModel model;
    model.meshes.push_back(box_of("house", {4.0f, 6.0f, 4.0f}, 16));
    for (int i = 0; i < 64; ++i) {
        place(model, 0, "house " + std::to_string(i),
              {10.0f * static_cast<float>(i % 8), 0.0f, 10.0f * static_cast<float>(i / 8)});
    }
    return model;
}

const Advice* find(const std::vector<Advice>& advice, const std::string& kind)
{
    const auto found = std::ranges::find(advice, kind, &Advice::kind);
    return found == advice.end() ? nullptr : &*found;
}

TEST(SceneAdvice, ATownOfHousesNeedsNone)
{
    EXPECT_TRUE(advise(town(), kItem).empty());
}

TEST(SceneAdvice, NamesTheOneMeshThatHoldsNearlyEverything)
{
    SceneModel model = town();
    model.meshes.push_back(box_of("streets", {80.0f, 1.0f, 80.0f}, 4000));
    place(model, 1, "all streets", glm::vec3{0.0f});
    const auto advice = advise(model, kItem);
    const Advice* one = find(advice, "one_mesh");
    ASSERT_NE(one, nullptr);
    EXPECT_EQ(one->objects, std::vector<std::string>{"all streets"});
    EXPECT_NE(one->sentence.find("'all streets' holds 78% of the triangles"), std::string::npos)
        << one->sentence;
    EXPECT_EQ(find(advice, "large_objects"), nullptr) << "it is said once";
}

TEST(SceneAdvice, NamesLargeObjectsThatAreHeavyAndLong)
{
    SceneModel model = town();
    model.meshes.push_back(box_of("wall", {80.0f, 6.0f, 1.0f}, 200));
    model.meshes.push_back(box_of("statue", {2.0f, 3.0f, 2.0f}, 200));
    model.meshes.push_back(box_of("fence", {80.0f, 1.0f, 1.0f}, 10));
    place(model, 1, "north wall", glm::vec3{0.0f});
    place(model, 2, "statue", glm::vec3{5.0f});
    place(model, 3, "fence", glm::vec3{7.0f});
    const auto advice = advise(model, kItem);
    const Advice* large = find(advice, "large_objects");
    ASSERT_NE(large, nullptr);
    EXPECT_EQ(large->objects, std::vector<std::string>{"north wall"})
        << "the statue is short, the fence light";
}

TEST(SceneAdvice, NamesTheObjectsOfASceneThatHasFew)
{
    SceneModel model;
    model.meshes.push_back(box_of("house", {4.0f, 6.0f, 4.0f}, 400));
    for (int i = 0; i < 3; ++i) {
        place(model, 0, "house " + std::to_string(i), {10.0f * static_cast<float>(i), 0.0f, 0.0f});
    }
    EXPECT_NE(find(advise(model, kItem), "few_objects"), nullptr);
    for (int i = 3; i < 20; ++i) {
        place(model, 0, "house " + std::to_string(i), {10.0f * static_cast<float>(i), 0.0f, 0.0f});
    }
    EXPECT_EQ(find(advise(model, kItem), "few_objects"), nullptr);
}

TEST(SceneAdvice, CountsSmallObjectsWhereTheyAreMostOfMany)
{
    SceneModel model = town();
    model.meshes.push_back(box_of("bolt", glm::vec3{0.1f}));
    for (int i = 0; i < 999; ++i) {
        place(model, 1, "bolt", {static_cast<float>(i % 70), 1.0f, static_cast<float>(i / 70)});
    }
    EXPECT_EQ(find(advise(model, kItem), "small_objects"), nullptr) << "999 are not many";
    place(model, 1, "bolt", glm::vec3{3.0f});
    const auto advice = advise(model, kItem);
    const Advice* tiny = find(advice, "small_objects");
    ASSERT_NE(tiny, nullptr);
    EXPECT_EQ(tiny->count, 1000u);
    EXPECT_NE(tiny->sentence.find("1000 of 1064 objects"), std::string::npos) << tiny->sentence;
}

TEST(SceneAdvice, NamesObjectsWhoseBoxesAreMostlyEmpty)
{
    SceneModel model = town();
    MeshBuilder builder; // a cable from corner to corner
    builder.quad({0, 0, 0}, {0.5f, 0, 0}, {70.5f, 20, 70}, {70, 20, 70});
    builder.quad({0, 0, 0}, {0, 0.5f, 0}, {70, 20.5f, 70}, {70, 20, 70});
    model.meshes.push_back(builder.take("cable", kItem));
    place(model, 1, "power line", glm::vec3{0.0f});
    const auto advice = advise(model, kItem);
    const Advice* empty = find(advice, "empty_boxes");
    ASSERT_NE(empty, nullptr);
    EXPECT_EQ(empty->objects, std::vector<std::string>{"power line"});
}

TEST(SceneAdvice, SaysWhichObjectsLetLightThroughWhereTheyAreManyTriangles)
{
    SceneModel model = town();
    for (uint32_t i = 0; i < 12; ++i) {
        model.instances[i].see_through = true;
    }
    EXPECT_EQ(find(advise(model, kItem), "see_through"), nullptr) << "12 of 64 are below a fifth";
    model.instances[12].see_through = true;
    const auto advice = advise(model, kItem);
    const Advice* clear = find(advice, "see_through");
    ASSERT_NE(clear, nullptr);
    EXPECT_EQ(clear->count, 13u);
    EXPECT_NE(clear->sentence.find("and 10 more. Give those"), std::string::npos)
        << clear->sentence;
}

TEST(BoxFill, IsOneForABoxAHalfForASheetAndLittleForADiagonal)
{
    EXPECT_NEAR(box_fill(box_of("box", {1.0f, 2.0f, 3.0f})), 1.0f, 1e-5f);
    MeshBuilder sheet;
    sheet.quad({0, 0, 0}, {4, 0, 0}, {4, 3, 0}, {0, 3, 0});
    EXPECT_NEAR(box_fill(sheet.take("sheet", kItem)), 0.5f, 1e-5f);
    MeshBuilder pole;
    pole.quad({0, 0, 0}, {0.1f, 0, 0}, {10.1f, 10, 10}, {10, 10, 10});
    EXPECT_LT(box_fill(pole.take("pole", kItem)), 0.02f);
}

} // namespace
} // namespace occlude::tools
