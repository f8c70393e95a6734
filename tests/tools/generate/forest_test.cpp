#include "tools/scene_checks.h"

namespace occlude::tools {
namespace {

using namespace test;

TEST(Forest, HasTheTreesAndAboutTheTrianglesAskedFor)
{
    const SceneModel model = loaded("forest");
    EXPECT_EQ(model.instances.size(), 10001u); // and the ground
    EXPECT_EQ(model.meshes.size(), 13u);
    EXPECT_NEAR(static_cast<double>(drawn_triangles(model)), 1.7e6, 0.02 * 1.7e6);
    EXPECT_NEAR(static_cast<double>(drawn_triangles(loaded("forest:triangles=200k,trees=100"))),
                2e5, 0.02 * 2e5);
}

TEST(Forest, IsTheSameOnEveryMachineAndFollowsItsSeed)
{
    const uint64_t hash = hash_of(loaded("forest:triangles=50k,trees=50,seed=3", kHashedOptions));
    EXPECT_EQ(hash, 17484425099099278585u);
    EXPECT_NE(hash, hash_of(loaded("forest:triangles=50k,trees=50,seed=4")));
}

TEST(Forest, IsSound)
{
    expect_sound(loaded("forest:triangles=100k,trees=60"));
    expect_sound(loaded("forest:triangles=1k,trees=10"));
}

TEST(Forest, WalkIsFreeAndSmooth)
{
    for (const char* source :
         {"forest:triangles=200k,trees=400", "forest:triangles=100k,trees=50,seed=2"}) {
        expect_free_and_smooth(loaded(source), "walk", 0.3f);
    }
}

TEST(Forest, HidesMostOfItself)
{
    EXPECT_GT(hidden_share(loaded("forest:triangles=200k,trees=1200"), "walk", 6), 0.7);
}

} // namespace
} // namespace occlude::tools
