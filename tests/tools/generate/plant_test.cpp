#include "generate/plant_parts.h"
#include "generate/scene_source.h"
#include "tools/scene_checks.h"

namespace occlude::tools {
namespace {

using namespace test;

TEST(Plant, HasTheObjectsAndAboutTheTrianglesAskedFor)
{
    for (const auto& [source, objects, triangles] :
         {std::tuple{"plant", 1185u, 2.0e6},
          {"plant:triangles=13m", 1185u, 1.3e7},
          {"plant:triangles=100k,objects=60", 60u, 1.0e5},
          {"plant:triangles=1m,objects=400,seed=2", 400u, 1.0e6}}) {
        const SceneModel model = loaded(source);
        EXPECT_EQ(model.instances.size(), objects) << source;
        EXPECT_NEAR(static_cast<double>(drawn_triangles(model)), triangles, 0.1 * triangles)
            << source;
    }
}

TEST(Plant, HasComplexObjectsThatAreInstancedAndSomeThatAreNot)
{
    const SceneModel model = loaded("plant:triangles=13m");
    size_t complex = 0;
    size_t stored = 0;
    std::vector<size_t> uses(model.meshes.size());
    for (const Instance& instance : model.instances) {
        complex += model.meshes[instance.mesh].indices.size() > 3 * 4096;
        ++uses[instance.mesh];
    }
    for (const Mesh& mesh : model.meshes) {
        stored += mesh.indices.size() / 3;
    }
    EXPECT_GT(complex, model.instances.size() / 2);
    EXPECT_GT(std::count(uses.begin(), uses.end(), 1), 100);
    EXPECT_GT(*std::max_element(uses.begin(), uses.end()), 50u);
    EXPECT_LT(stored, drawn_triangles(model) / 2);
}

TEST(Plant, IsTheSameOnEveryMachineAndFollowsItsSeed)
{
    const uint64_t hash = hash_of(loaded("plant:triangles=100k,objects=60,seed=3", kHashedOptions));
    EXPECT_EQ(hash, 8720880420492621566u);
    EXPECT_NE(hash, hash_of(loaded("plant:triangles=100k,objects=60,seed=4")));
}

TEST(Plant, PartsAreSoundAtAnyDetail)
{
    for (uint32_t part = 0; part < static_cast<uint32_t>(PlantPart::count); ++part) {
        for (const uint32_t elements : {1u, 7u, 40u, 300u}) {
            SceneModel model;
            model.meshes.push_back(make_plant_part(static_cast<PlantPart>(part), elements, 5));
            expect_sound(model);
        }
    }
    expect_sound(loaded("plant:triangles=300k,objects=200"));
}

TEST(Plant, SaysHowManyTrianglesWouldDo)
{
    const auto model = load_scene("plant:triangles=10k,objects=1185");
    ASSERT_FALSE(model);
    EXPECT_NE(model.error().message.find("at least"), std::string::npos) << model.error().message;
}

TEST(Plant, WalkIsFreeAndSmooth)
{
    for (const char* source :
         {"plant:triangles=300k,objects=200", "plant:triangles=100k,objects=50,seed=7",
          "plant:triangles=2m,objects=1185"}) {
        expect_free_and_smooth(loaded(source), "walk", 0.4f, 20.0f);
    }
}

TEST(Plant, TheCoreHidesWhatTheYardShows)
{
    const SceneModel model = loaded("plant:triangles=500k,objects=400");
    const double hidden = hidden_share(model, "walk", 8);
    EXPECT_GT(hidden, 0.35);
    EXPECT_LT(hidden, 0.9);
}

} // namespace
} // namespace occlude::tools
