// The unit that a scene is estimated to have, by its storeys and its doors.
#include "load/scene_measures.h"
#include "model/mesh_tools.h"

#include <gtest/gtest.h>

namespace occlude::tools {
namespace {

/// A tower of floors of 4 by 3 m, at these heights in metres, with two walls between them.
SceneModel tower(const std::vector<float>& floors, float units_per_metre)
{
    const auto box = [&](MeshBuilder& builder, const glm::vec3& low, const glm::vec3& high) {
        builder.box(low * units_per_metre, high * units_per_metre);
    };
    MeshBuilder builder;
    for (const float floor : floors) {
        box(builder, {0.0f, floor - 0.3f, 0.0f}, {4.0f, floor, 3.0f});
    }
    box(builder, {0.0f, floors.front(), 0.0f}, {4.0f, floors.back(), 0.2f});
    box(builder, {0.0f, floors.front(), 2.8f}, {4.0f, floors.back(), 3.0f});
    SceneModel model;
    model.meshes.push_back(builder.take("tower", 2048));
    model.instances.push_back({.name = "tower", .mesh = 0});
    return model;
}

TEST(StoreyHeight, IsTheDistanceOfFloorsNotTheThicknessOfSlabs)
{
    const auto height = storey_height(tower({0.0f, 3.1f, 6.2f, 9.3f, 12.4f}, 1.0f));
    ASSERT_TRUE(height);
    EXPECT_NEAR(*height, 3.1f, 0.05f);
}

TEST(StoreyHeight, NeedsFourEvenlySpacedFloors)
{
    EXPECT_FALSE(storey_height(tower({0.0f, 3.0f, 6.0f}, 1.0f)));
    EXPECT_TRUE(storey_height(tower({0.0f, 3.0f, 6.2f, 9.0f}, 1.0f)));
    EXPECT_FALSE(storey_height(tower({0.0f, 3.0f, 8.0f, 11.0f}, 1.0f)));
}

TEST(GuessUnit, ByStoreysIsTheUnitThatMakesThemThreeMetresHigh)
{
    const std::vector<float> floors{0.0f, 3.0f, 6.0f, 9.0f, 12.0f};
    for (const float unit : {3.28084f, 39.3701f, 100.0f, 1000.0f}) {
        const UnitGuess guess = guess_unit(tower(floors, unit), UnitSource::unknown);
        EXPECT_EQ(guess.units_per_metre, unit) << guess.reason;
        EXPECT_NE(guess.reason.find("its storeys are"), std::string::npos) << guess.reason;
    }
    EXPECT_EQ(guess_unit(tower(floors, 1.0f), UnitSource::unknown).units_per_metre, 1.0f);
}

TEST(GuessUnit, AFileThatSaysMetresIsBelievedUntilStoreysAreHigherThanHalls)
{
    const std::vector<float> floors{0.0f, 3.0f, 6.0f, 9.0f, 12.0f};
    EXPECT_EQ(guess_unit(tower(floors, 3.28084f), UnitSource::metres).units_per_metre, 1.0f);
    EXPECT_EQ(guess_unit(tower(floors, 100.0f), UnitSource::metres).units_per_metre, 100.0f);
}

TEST(GuessUnit, ADoorDecidesBeforeStoreysDo)
{
    SceneModel model = tower({0.0f, 8.0f, 16.0f, 24.0f}, 1.0f); // a silo
    EXPECT_NE(guess_unit(model, UnitSource::unknown).units_per_metre, 1.0f);
    MeshBuilder builder;
    builder.box({0.0f, 0.0f, 0.0f}, {1.0f, 2.1f, 0.1f});
    model.meshes.push_back(builder.take("leaf", 2048));
    model.instances.push_back({.name = "Front Door", .mesh = 1});
    EXPECT_EQ(guess_unit(model, UnitSource::unknown).units_per_metre, 1.0f);
}

} // namespace
} // namespace occlude::tools
