#include "generate/city_generator.h"
#include "generate/scene_source.h"
#include "tools/scene_checks.h"

#include <occlude/core/rng.h>

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <set>

namespace occlude::tools {
namespace {

using test::hash_of;
using test::SegmentTester;

SceneModel city(const std::string& source)
{
    return test::loaded(source);
}

const std::vector<Keyframe>& path_of(const SceneModel& model, const std::string& name)
{
    const auto found = std::find_if(model.paths.begin(), model.paths.end(),
                                    [&](const auto& path) { return path.name == name; });
    EXPECT_NE(found, model.paths.end()) << name;
    return found->keys;
}

TEST(City, HasAboutTheTrianglesAskedForFromOneToThirtyMillion)
{
    for (const auto& [text, count] : {std::pair{"1m", 1.0e6}, {"10m", 1.0e7}, {"30m", 3.0e7}}) {
        const SceneModel model = city(std::string("city:blocks=16,seed=1,triangles=") + text);
        const auto drawn = static_cast<double>(drawn_triangles(model));
        EXPECT_GT(drawn, 0.96 * count);
        EXPECT_LT(drawn, 1.01 * count);
    }
}

TEST(City, InstancesAFewMeshesManyTimes)
{
    const SceneModel model = city("city:blocks=8,triangles=2m");
    EXPECT_GT(model.meshes.size(), 40u);
    EXPECT_LT(model.meshes.size(), 200u);
    EXPECT_GT(model.instances.size(), 20 * model.meshes.size());
    size_t stored = 0;
    for (const Mesh& mesh : model.meshes) {
        stored += mesh.indices.size() / 3;
    }
    EXPECT_LT(stored, drawn_triangles(model) / 10);
}

TEST(City, PartitionsItsHouses)
{
    const auto model =
        generate_city({.blocks = 4, .seed = 1, .triangles = 2000000}, {.item_triangles = 500});
    ASSERT_TRUE(model);
    size_t parts = 0;
    for (const Mesh& mesh : model->meshes) {
        parts += mesh.parts.size();
        for (const MeshPart& part : mesh.parts) {
            ASSERT_LE(part.index_count, 1500u);
        }
    }
    EXPECT_GT(parts, 3 * model->meshes.size());
}

TEST(City, IsTheSameOnEveryMachine)
{
    // Changes only with the generator: the result must not differ between compilers and libraries.
    EXPECT_EQ(hash_of(test::loaded("city:blocks=3,seed=7,triangles=300k", test::kHashedOptions)),
              1063263254794902263u);
}

TEST(City, FollowsItsSeed)
{
    const uint64_t first = hash_of(city("city:blocks=3,seed=7,triangles=300k"));
    EXPECT_EQ(first, hash_of(city("city:blocks=3,seed=7,triangles=300k")));
    EXPECT_NE(first, hash_of(city("city:blocks=3,seed=8,triangles=300k")));
}

TEST(City, MeshesAreSound)
{
    const SceneModel model = city("city:blocks=4,seed=3,triangles=3m");
    for (const Mesh& mesh : model.meshes) {
        ASSERT_EQ(mesh.positions.size(), mesh.normals.size());
        for (size_t i = 0; i < mesh.positions.size(); ++i) {
            ASSERT_TRUE(glm::dot(mesh.positions[i], mesh.positions[i]) < 1e8f) << mesh.name;
            ASSERT_NEAR(glm::length(mesh.normals[i]), 1.0f, 1e-3f) << mesh.name;
        }
    }
    const Aabb bounds = world_bounds(model);
    EXPECT_LT(bounds.max.y, 90.0f);
    EXPECT_GT(bounds.min.y, -1.0f);
}

TEST(City, TheWalkStaysInTheStreetsAtEyeHeight)
{
    const SceneModel model = city("city:blocks=6,seed=2,triangles=1m");
    const std::vector<Keyframe>& walk = path_of(model, "street");
    ASSERT_GT(walk.size(), 50u);
    const SegmentTester tester(model);
    float length = 0.0f;
    for (size_t i = 1; i < walk.size(); ++i) {
        const glm::vec3& from = walk[i - 1].camera.eye;
        const glm::vec3& to = walk[i].camera.eye;
        EXPECT_NEAR(to.y, 1.7f, 0.05f);
        EXPECT_FALSE(tester.hits(from, to)) << "between keys " << i - 1 << " and " << i;
        length += glm::distance(from, to);
    }
    EXPECT_GT(length, 100.0f);
    EXPECT_LT(length, 400.0f);
}

TEST(City, StreetsAreClosedInByFacades)
{
    const SceneModel model = city("city:blocks=6,seed=2,triangles=1m");
    const std::vector<Keyframe>& walk = path_of(model, "street");
    const SegmentTester tester(model);
    // From the middle of a block's side, a look across the street ends at a facade.
    const glm::vec3 eye = walk.front().camera.eye;
    size_t closed = 0;
    for (int i = -4; i <= 4; ++i) {
        const glm::vec3 aside{0.4f * static_cast<float>(i), 0.6f, 1.0f};
        closed += tester.hits(eye, eye + 30.0f * aside);
        closed += tester.hits(eye, eye - 30.0f * aside * glm::vec3{1.0f, -1.0f, 1.0f});
    }
    EXPECT_EQ(closed, 18u);
}

TEST(City, PathsHaveTheNamesAndShapesPromised)
{
    const SceneModel model = city("city:blocks=6,seed=2,triangles=500k");
    const Aabb bounds = world_bounds(model);
    for (const Keyframe& key : path_of(model, "roofs")) {
        EXPECT_GT(key.camera.eye.y, bounds.max.y);
        EXPECT_LT(key.camera.target.y, key.camera.eye.y);
    }
    const std::vector<Keyframe>& rise = path_of(model, "rise");
    EXPECT_LT(rise.front().camera.eye.y, 2.0f);
    EXPECT_GT(rise.back().camera.eye.y, 80.0f);
    size_t cuts = 0;
    for (const Keyframe& key : path_of(model, "teleport")) {
        cuts += key.cut;
    }
    EXPECT_GE(cuts, 8u);
}

void expect_error(const std::string& source, const std::vector<std::string>& parts)
{
    const auto model = load_scene(source);
    ASSERT_FALSE(model) << source;
    EXPECT_EQ(model.error().code, ErrorCode::invalid_argument);
    for (const std::string& part : parts) {
        EXPECT_NE(model.error().message.find(part), std::string::npos)
            << model.error().message << " should say " << part;
    }
}

TEST(Generators, NameWrongParametersAndTheGoodOnes)
{
    expect_error("city:height=3", {"height", "blocks", "seed", "triangles"});
    expect_error("city:blocks=many", {"many", "blocks", "1 to 64"});
    expect_error("city:blocks=0", {"blocks"});
    expect_error("city:blocks", {"blocks"});
    expect_error("city:blocks=-4", {"-4"});
    expect_error("city:blocks=4x", {"4x"});
    expect_error("city:seed=", {"seed"});
    expect_error("city:triangles=1.m", {"1.m"});
    expect_error("boxes:n=4", {"n", "count", "seed"});
    expect_error("city:blocks=16,triangles=1000", {"triangles", "at least"});
    expect_error("city:blocks=1,triangles=100m", {"triangles", "at most"});
}

TEST(Generators, UnderstandThousandsAndMillions)
{
    const SceneModel whole = city("city:blocks=4,triangles=1500000");
    const SceneModel suffix = city("city:blocks=4,triangles=1.5m");
    EXPECT_EQ(drawn_triangles(whole), drawn_triangles(suffix));
    EXPECT_EQ(city("boxes:count=2k").instances.size(), 2000u);
}

TEST(Generators, AreListedWithTheirParameters)
{
    std::set<std::string> names;
    for (const GeneratorInfo& info : generators()) {
        names.insert(info.name);
        EXPECT_FALSE(info.description.empty());
        const auto model =
            load_scene(info.name == "city" ? "city:blocks=2,triangles=100k" : info.name);
        EXPECT_TRUE(model) << info.name;
    }
    EXPECT_EQ(names, (std::set<std::string>{"blobs", "boxcity", "boxes", "bunnies", "city",
                                            "forest", "library", "movers", "plant", "pyramids",
                                            "rings", "teapots", "vienna"}));
}

TEST(Boxes, AreAsManyAsAskedForAndFollowTheirSeed)
{
    const SceneModel model = city("boxes:count=250,seed=4");
    EXPECT_EQ(model.instances.size(), 250u);
    EXPECT_EQ(drawn_triangles(model), 3000u);
    EXPECT_EQ(hash_of(model), hash_of(city("boxes:count=250,seed=4")));
    EXPECT_NE(hash_of(model), hash_of(city("boxes:count=250,seed=5")));
}

} // namespace
} // namespace occlude::tools
