#include "tools/scene_checks.h"

namespace occlude::tools {
namespace {

using namespace test;

size_t books_in(const SceneModel& model)
{
    return static_cast<size_t>(
        std::count_if(model.instances.begin(), model.instances.end(),
                      [](const Instance& instance) { return instance.name == "book"; }));
}

TEST(Library, HasFortyThousandBooksOfMoreThanTenMillionTriangles)
{
    const SceneModel model = loaded("library");
    EXPECT_EQ(books_in(model), 40000u);
    EXPECT_GT(drawn_triangles(model), 10000000u);
    EXPECT_LT(drawn_triangles(model), 10400000u);
    EXPECT_LT(model.meshes.size(), 40u);
    for (const Mesh& mesh : model.meshes) {
        if (mesh.name.starts_with("book")) {
            EXPECT_EQ(mesh.indices.size() / 3, 254u);
        }
    }
}

TEST(Library, IsTheSameOnEveryMachineAndFollowsItsSeed)
{
    const uint64_t hash = hash_of(loaded("library:books=500,seed=3", kHashedOptions));
    EXPECT_EQ(hash, 834375396863996278u);
    EXPECT_NE(hash, hash_of(loaded("library:books=500,seed=4")));
}

TEST(Library, IsSound)
{
    expect_sound(loaded("library:books=300,triangles=700"));
    expect_sound(loaded("library:books=1,triangles=12"));
}

TEST(Library, WalkIsFreeAndSmooth)
{
    for (const char* source : {"library:books=2k", "library:books=1", "library:books=9k,seed=5"}) {
        const SceneModel model = loaded(source);
        expect_free_and_smooth(model, "walk", 0.3f, 30.0f);
    }
}

TEST(Library, OneSeesThroughTheShelvesButNotFar)
{
    const SceneModel model = loaded("library:books=6k,triangles=50");
    const double hidden = hidden_share(model, "walk", 8);
    EXPECT_GT(hidden, 0.5);
    EXPECT_LT(hidden, 0.97);
    // Between the books of a row the eye sees the rows behind it: some pixel beside the walker, at
    // the height of the gap under a board, is farther than the next row.
    const SegmentTester tester(model);
    const std::vector<Keyframe> walk = keys_of(model, "walk");
    size_t open = 0;
    for (const Keyframe& key : walk) {
        for (float y = 1.0f; y < 2.0f; y += 0.02f) {
            const glm::vec3 eye{key.camera.eye.x, y, key.camera.eye.z};
            open += !tester.hits(eye, eye + glm::vec3{0.0f, 0.0f, 1.4f});
        }
    }
    EXPECT_GT(open, 20u);
}

} // namespace
} // namespace occlude::tools
