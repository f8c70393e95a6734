#include "files/assets.h"
#include "generate/bunnies_generator.h"
#include "tools/scene_checks.h"

namespace occlude::tools {
namespace {

using namespace test;

TEST(Bunnies, AreTheWholeScanThreeHundredTimes)
{
    const SceneModel model = loaded("bunnies");
    EXPECT_EQ(model.instances.size(), 300u);
    ASSERT_EQ(model.meshes.size(), 1u);
    EXPECT_EQ(drawn_triangles(model), 300u * 69451u);
    EXPECT_EQ(model.motion.instances.size(), 300u);
    for (const glm::vec3& p : model.meshes[0].positions) {
        ASSERT_LT(glm::length(p), 1.0001f);
    }
}

TEST(Bunnies, AreSimplifiedToWhatIsAskedFor)
{
    for (const uint64_t most : {500u, 3000u, 20000u}) {
        const SceneModel model = loaded("bunnies:count=2,triangles=" + std::to_string(most));
        EXPECT_LE(drawn_triangles(model), 2 * most);
        EXPECT_GT(drawn_triangles(model), 2 * most * 8 / 10);
        expect_sound(model);
    }
}

TEST(Bunnies, AreTheSameEachTimeAndFollowTheirSeed)
{
    const uint64_t hash = hash_of(loaded("bunnies:count=20,triangles=1k,seed=3"));
    EXPECT_EQ(hash, hash_of(loaded("bunnies:count=20,triangles=1k,seed=3")));
    EXPECT_NE(hash, hash_of(loaded("bunnies:count=20,triangles=1k,seed=4")));
}

TEST(Bunnies, MoveWithinTheirCube)
{
    const SceneModel model = loaded("bunnies:count=30,triangles=500");
    for (const size_t frame : {1u, 100u, 5000u}) {
        for (size_t i = 0; i < model.instances.size(); ++i) {
            const glm::mat4& first = model.instances[i].world_from_mesh;
            const glm::mat4 now = moved(model.motion.instances[i], model.motion.box, first, frame);
            const glm::vec3 at{now[3]};
            EXPECT_NE(at, glm::vec3{first[3]});
            EXPECT_TRUE(contains(model.motion.box, {at, at}));
        }
    }
}

TEST(Assets, ThatAreMissingAreNamedWithTheRemedy)
{
    EXPECT_TRUE(find_asset("bunny/bunny.glb"));
    const auto missing = find_asset("bunny/hare.glb");
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().code, ErrorCode::not_found);
    for (const char* part : {"bunny/hare.glb", "OCCLUDE_ASSETS"}) {
        EXPECT_NE(missing.error().message.find(part), std::string::npos) << part;
    }
}

} // namespace
} // namespace occlude::tools
