#include "generate/scene_source.h"
#include "tools/scene_checks.h"

namespace occlude::tools {
namespace {

using namespace test;

TEST(Vienna, HasAboutTheTrianglesAskedForAndInstancesItsMeshes)
{
    for (const auto& [source, triangles] : {std::pair{"vienna", 8e6},
                                            {"vienna:blocks=4,triangles=300k", 3e5},
                                            {"vienna:blocks=8,triangles=3m,seed=2", 3e6}}) {
        const SceneModel model = loaded(source);
        EXPECT_NEAR(static_cast<double>(drawn_triangles(model)), triangles, 0.1 * triangles)
            << source;
        EXPECT_GT(model.instances.size(), 5 * model.meshes.size()) << source;
    }
}

TEST(Vienna, SaysHowManyTrianglesWouldDo)
{
    const auto model = load_scene("vienna:blocks=16,triangles=10k");
    ASSERT_FALSE(model);
    EXPECT_NE(model.error().message.find("at least"), std::string::npos) << model.error().message;
}

TEST(Vienna, IsTheSameOnEveryMachineAndFollowsItsSeed)
{
    const uint64_t hash = hash_of(loaded("vienna:blocks=2,triangles=60k,seed=3", kHashedOptions));
    EXPECT_EQ(hash, 16861246380801667264u);
    EXPECT_NE(hash, hash_of(loaded("vienna:blocks=2,triangles=60k,seed=4")));
}

TEST(Vienna, IsSound)
{
    expect_sound(loaded("vienna:blocks=3,triangles=400k"));
}

TEST(Vienna, PathsAreFreeAndSmooth)
{
    for (const char* source :
         {"vienna:blocks=6,triangles=500k", "vienna:blocks=4,triangles=200k,seed=5",
          "vienna:blocks=1,triangles=20k"}) {
        const SceneModel model = loaded(source);
        expect_free_and_smooth(model, "street", 0.8f, 20.0f);
        expect_free_and_smooth(model, "rise", 0.8f);
        expect_free_and_smooth(model, "roofs", 0.8f);
        EXPECT_GT(keys_of(model, "rise").back().camera.eye.y, 55.0f);
    }
}

TEST(Vienna, HidesNearlyEverythingFromTheStreet)
{
    const SceneModel model = loaded("vienna:blocks=8,triangles=600k");
    EXPECT_GT(hidden_share(model, "street", 6), 0.85);
    EXPECT_LT(hidden_share(model, "roofs", 3), 0.85);
}

} // namespace
} // namespace occlude::tools
