#include "generate/moving_generators.h"

#include "generate/scene_source.h"
#include "walk/paths.h"

#include <glm/geometric.hpp>

#include <gtest/gtest.h>

#include <algorithm>

namespace occlude::tools {

TEST(MovingGenerators, BlobsAreClosedMeshesOfAboutTheTrianglesAskedFor)
{
    const Mesh blob = make_blob(5, 7000, 512);
    const size_t triangles = blob.indices.size() / 3;
    EXPECT_GT(triangles, 6500u);
    EXPECT_LE(triangles, 7000u);
    EXPECT_GT(blob.parts.size(), 7000u / 512u);
    double volume = 0.0; // positive: triangles face outward
    float farthest = 0.0f;
    for (size_t i = 0; i < blob.indices.size(); i += 3) {
        const glm::vec3& a = blob.positions[blob.indices[i]];
        volume += glm::dot(a, glm::cross(blob.positions[blob.indices[i + 1]],
                                         blob.positions[blob.indices[i + 2]])) /
                  6.0;
        farthest = std::max(farthest, glm::length(a));
    }
    EXPECT_NEAR(farthest, 1.0f, 1e-5f);
    EXPECT_GT(volume, 0.5); // cubic metres
    EXPECT_LT(volume, 4.19);
}

TEST(MovingGenerators, EveryObjectMovesAndSomeMoversComeAndGo)
{
    for (const char* source : {"movers:count=100,triangles=5k", "blobs:count=20,triangles=200"}) {
        const auto model = load_scene(source);
        ASSERT_TRUE(model) << source;
        ASSERT_EQ(model->motion.instances.size(), model->instances.size());
        size_t passing = 0;
        for (size_t i = 0; i < model->instances.size(); ++i) {
            EXPECT_GT(glm::length(model->motion.instances[i].velocity), 0.0f);
            passing += model->motion.instances[i].period > 0 ? 1 : 0;
        }
        EXPECT_EQ(passing, source[0] == 'm' ? 25u : 0u);
        EXPECT_TRUE(load_path("inside", *model, 10)) << source;
        EXPECT_TRUE(load_path("orbit", *model, 10)) << source;
        EXPECT_TRUE(load_path("auto", *model, 10)) << source;
    }
    const auto movers = load_scene("movers:count=900,triangles=100k");
    ASSERT_TRUE(movers);
    EXPECT_NEAR(static_cast<double>(drawn_triangles(*movers)), 100000.0, 15000.0);
}

TEST(MovingGenerators, StaticScenesHaveNoMotion)
{
    const auto boxes = load_scene("boxes:count=10");
    ASSERT_TRUE(boxes);
    EXPECT_TRUE(boxes->motion.empty());
}

} // namespace occlude::tools
