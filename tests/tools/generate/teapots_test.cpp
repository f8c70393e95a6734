#include "generate/teapot.h"
#include "tools/scene_checks.h"

#include <map>
#include <tuple>

namespace occlude::tools {
namespace {

using namespace test;

constexpr uint32_t kWhole = 1000000;

TEST(Teapot, HasTheTrianglesOfItsTessellationLessTheFlatOnes)
{
    for (const auto& [asked, steps] :
         {std::pair{576u, 3u}, {2304u, 6u}, {6400u, 10u}, {1u, 1u}, {2000u, 6u}, {6000u, 10u}}) {
        EXPECT_EQ(teapot_steps(asked), steps) << asked;
        EXPECT_EQ(make_teapot(steps, kWhole).indices.size() / 3, 64 * steps * steps - 8 * steps);
    }
}

TEST(Teapot, FillsNewellsBox)
{
    const Mesh mesh = make_teapot(10, kWhole);
    const Aabb& box = mesh.parts.at(0).box;
    EXPECT_NEAR(box.min.x, -3.0f, 0.05f);
    EXPECT_NEAR(box.max.x, 3.43f, 0.05f);
    EXPECT_NEAR(box.min.y, 0.0f, 1e-5f);
    EXPECT_NEAR(box.max.y, 3.15f, 1e-5f);
    EXPECT_NEAR(box.min.z, -2.0f, 0.05f);
    EXPECT_NEAR(box.max.z, 2.0f, 0.05f);
}

TEST(Teapot, OnlyTheLidsSlitAndTheEndsOfHandleAndSpoutAreOpen)
{
    const uint32_t steps = 6;
    const Mesh mesh = make_teapot(steps, kWhole);
    using Point = std::tuple<float, float, float>;
    std::map<std::pair<Point, Point>, int> edges; // by direction: each edge needs its opposite
    const auto point = [&](size_t i) {
        const glm::vec3& p = mesh.positions[mesh.indices[i]];
        return Point{p.x + 0.0f, p.y + 0.0f, p.z + 0.0f};
    };
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        for (size_t k = 0; k < 3; ++k) {
            ++edges[{point(i + k), point(i + (k + 1) % 3)}];
        }
    }
    size_t open = 0;
    for (const auto& [edge, count] : edges) {
        EXPECT_EQ(count, 1) << "two triangles turn the same way around an edge";
        open += edges.count({edge.second, edge.first}) == 0;
    }
    // The rim's inner edge, the lid's outer edge, two ends of the handle and two of the spout.
    EXPECT_EQ(open, 2 * 4 * steps + 4 * 2 * steps);
}

TEST(Teapot, FacesOutward)
{
    const Mesh mesh = make_teapot(6, kWhole);
    size_t outward = 0;
    for (size_t i = 0; i < mesh.positions.size(); ++i) {
        const glm::vec3& p = mesh.positions[i];
        if (p.y > 0.5f && p.y < 2.3f && p.x * p.x + p.z * p.z < 4.1f &&
            std::abs(p.z) > 0.8f) { // the body
            EXPECT_GT(glm::dot(mesh.normals[i], glm::vec3{p.x, 0.0f, p.z}), 0.0f);
            ++outward;
        }
    }
    EXPECT_GT(outward, 50u);
}

TEST(Teapots, AreAsManyAsAskedFor)
{
    const SceneModel model = loaded("teapots");
    EXPECT_EQ(model.instances.size(), 5000u);
    EXPECT_EQ(model.meshes.size(), 1u);
    EXPECT_EQ(drawn_triangles(model), 5000u * 2256u);
    EXPECT_EQ(drawn_triangles(loaded("teapots:triangles=6400")), 5000u * 6320u);
}

TEST(Teapots, AreTheSameOnEveryMachineAndFollowTheirSeed)
{
    const uint64_t hash = hash_of(loaded("teapots:count=200,triangles=576,seed=3", kHashedOptions));
    EXPECT_EQ(hash, 5701875014445668753u);
    EXPECT_NE(hash, hash_of(loaded("teapots:count=200,triangles=576,seed=4")));
}

TEST(Teapots, AreSound)
{
    expect_sound(loaded("teapots:count=20,triangles=6400"));
}

TEST(Teapots, FlightIsFreeAndSmooth)
{
    for (const char* source : {"teapots:count=300,triangles=576", "teapots:count=1,triangles=64",
                               "teapots:count=1k,triangles=64,seed=2"}) {
        expect_free_and_smooth(loaded(source), "flight", 0.5f);
    }
}

TEST(Teapots, HideMostOfEachOther)
{
    const double hidden = hidden_share(loaded("teapots:count=2k,triangles=576"), "flight", 6);
    EXPECT_GT(hidden, 0.5);
    EXPECT_LT(hidden, 0.95);
}

} // namespace
} // namespace occlude::tools
