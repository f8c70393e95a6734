#include "generate/boxcity_generator.h"
#include "tools/scene_checks.h"

namespace occlude::tools {
namespace {

using namespace test;

TEST(BoxCity, HasExactlyTheObjectsAndTrianglesAskedFor)
{
    const SceneModel twelve = loaded("boxcity");
    EXPECT_EQ(twelve.instances.size(), 40000u);
    EXPECT_EQ(drawn_triangles(twelve), 480000u);
    const SceneModel more = loaded("boxcity:triangles=252");
    EXPECT_EQ(more.instances.size(), 40000u);
    EXPECT_EQ(drawn_triangles(more), 10080000u);
    EXPECT_EQ(more.meshes.size(), 1u);
    EXPECT_EQ(loaded("boxcity:count=101").instances.size(), 101u);
}

TEST(BoxCity, RoundsTrianglesToAnEvenGrid)
{
    for (const auto& [asked, made] :
         {std::pair{12u, 12u}, {13u, 12u}, {48u, 48u}, {100u, 104u}, {252u, 252u}, {300u, 300u}}) {
        EXPECT_EQ(make_subdivided_box(asked, 100000).indices.size(), 3 * made) << asked;
    }
}

TEST(BoxCity, SubdividedBoxesFillTheUnitBox)
{
    const Mesh mesh = make_subdivided_box(252, 100000);
    ASSERT_EQ(mesh.parts.size(), 1u);
    EXPECT_EQ(mesh.parts[0].box, (Aabb{{-0.5f, 0.0f, -0.5f}, {0.5f, 1.0f, 0.5f}}));
    double volume = 0.0; // faces point outward: the signed volume equals that of the box
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        const glm::dvec3 a{mesh.positions[mesh.indices[i]]};
        const glm::dvec3 b{mesh.positions[mesh.indices[i + 1]]};
        const glm::dvec3 c{mesh.positions[mesh.indices[i + 2]]};
        volume += glm::dot(a, glm::cross(b, c)) / 6.0;
    }
    EXPECT_NEAR(volume, 1.0, 1e-6);
}

TEST(BoxCity, IsTheSameOnEveryMachineAndFollowsItsSeed)
{
    const uint64_t hash = hash_of(loaded("boxcity:count=2k,seed=3"));
    EXPECT_EQ(hash, 1496516105782898309u);
    EXPECT_NE(hash, hash_of(loaded("boxcity:count=2k,seed=4")));
}

TEST(BoxCity, IsSound)
{
    expect_sound(loaded("boxcity:count=2k,triangles=252"));
}

TEST(BoxCity, PathsAreFreeAndSmooth)
{
    for (const char* source :
         {"boxcity:count=2k", "boxcity:count=100", "boxcity:count=2k,seed=9"}) {
        const SceneModel model = loaded(source);
        expect_free_and_smooth(model, "street", 1.0f);
        expect_free_and_smooth(model, "roofs", 1.0f);
        EXPECT_NEAR(keys_of(model, "street").back().camera.eye.y, 1.7f, 1e-4f);
        EXPECT_GT(keys_of(model, "roofs").back().camera.eye.y, world_bounds(model).max.y);
    }
}

TEST(BoxCity, HidesNearlyEverythingFromTheStreet)
{
    const double hidden = hidden_share(loaded("boxcity:count=4k"), "street", 6);
    EXPECT_GT(hidden, 0.9);
    EXPECT_LT(hidden, 0.995);
}

} // namespace
} // namespace occlude::tools
