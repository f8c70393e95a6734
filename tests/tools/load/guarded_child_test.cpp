#include "generate/scene_source.h"
#include "load/guarded_child.h"
#include "load/scene_bytes.h"
#include "load/scene_cache.h"
#include "support/source_dir.h"
#include "tools/temp_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <new>
#include <stdexcept>

#include <unistd.h>

namespace occlude::tools {
namespace {

Result<LoadedScene> read_guarded(const ChildLimits& limits,
                                 const std::function<Result<LoadedScene>()>& read)
{
    return read_in_child("some.file", "Reader", limits, {},
                         [&](const ReadProgress&) { return read(); });
}

TEST(GuardedChild, HandsBackWhatWasReadAndErrorsAsTheyAre)
{
    const auto scene = read_guarded({}, [] {
        LoadedScene made;
        made.meshes.push_back({.name = "m", .positions = {{1, 2, 3}}, .indices = {0, 0, 0}});
        made.instances.push_back({"i", 0, glm::dmat4{2.0}});
        made.materials.push_back({.name = "glass", .color = glm::vec3{0.5f}, .opacity = 0.25f});
        made.cameras.push_back({.name = "c", .eye = {1e7, 0.0, 0.125}});
        made.up = glm::vec3{0.0f, 0.0f, 1.0f};
        made.notes = {"a note"};
        return Result<LoadedScene>{std::move(made)};
    });
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_EQ(scene->meshes.size(), 1u);
    EXPECT_EQ(scene->meshes[0].positions[0], glm::vec3(1, 2, 3));
    EXPECT_EQ(scene->instances.at(0).world_from_mesh, glm::dmat4{2.0});
    EXPECT_EQ(scene->materials.at(0).opacity, 0.25f);
    EXPECT_EQ(scene->cameras.at(0).eye.x, 1e7);
    EXPECT_EQ(scene->up, glm::vec3(0.0f, 0.0f, 1.0f));
    EXPECT_EQ(scene->notes, std::vector<std::string>{"a note"});

    const auto error = read_guarded({}, [] {
        return Result<LoadedScene>{Error{ErrorCode::not_found, "some.file: is gone"}};
    });
    ASSERT_FALSE(error);
    EXPECT_EQ(error.error().code, ErrorCode::not_found);
    EXPECT_EQ(error.error().message, "some.file: is gone");
}

TEST(GuardedChild, ACrashAHangAndTooMuchMemoryBecomeSentences)
{
    const auto says = [](const Result<LoadedScene>& result, const std::string& part) {
        EXPECT_FALSE(result);
        EXPECT_NE(result.error().message.find(part), std::string::npos) << result.error().message;
    };
    says(read_guarded({}, []() -> Result<LoadedScene> { std::abort(); }), "crashed Reader");
    says(read_guarded({.seconds = 1},
                      []() -> Result<LoadedScene> {
                          for (;;) {
                              ::usleep(1000);
                          }
                      }),
         "within 1 seconds; raise --load-seconds");
    says(read_guarded({}, []() -> Result<LoadedScene> { throw std::runtime_error{"bad magic"}; }),
         "bad magic");
    says(read_guarded({}, []() -> Result<LoadedScene> { throw std::bad_alloc{}; }),
         "raise --load-memory");
}

TEST(GuardedChild, ProgressOfTheChildIsHeardInTheParent)
{
    std::vector<double> shares;
    const auto scene = read_in_child(
        "some.file", "Reader", {}, [&](double share) { shares.push_back(share); },
        [](const ReadProgress& told) {
            told(0.25);
            ::usleep(350000); // the parent listens ten times a second
            told(0.75);
            ::usleep(350000);
            return Result<LoadedScene>{LoadedScene{}};
        });
    ASSERT_TRUE(scene);
    EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
    EXPECT_NE(std::find(shares.begin(), shares.end(), 0.25), shares.end());
    EXPECT_NE(std::find(shares.begin(), shares.end(), 0.75), shares.end());
}

TEST(LoadScene, TellsHowFarItIsFromReadingToTheLastShape)
{
    std::vector<double> shares;
    const auto model = load_scene(source_dir() + "/assets/castle/castle.glb",
                                  {.progress = [&](double share) { shares.push_back(share); }});
    ASSERT_TRUE(model) << model.error().message;
    ASSERT_GT(shares.size(), 50u);
    EXPECT_LT(shares.size(), 500u);
    EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
    EXPECT_GE(shares.front(), 0.0);
    EXPECT_LT(shares.front(), 0.1);
    EXPECT_GT(shares.back(), 0.95);
    EXPECT_LE(shares.back(), 1.0);
}

TEST(GuardedChild, AScenesBytesThatAreCutOffAreNoScene)
{
    LoadedScene scene;
    scene.meshes.push_back({.name = "m", .positions = {{1, 2, 3}}, .indices = {0, 0, 0}});
    scene.instances.push_back({"i", 0, glm::dmat4{1.0}});
    char* data = nullptr;
    size_t size = 0;
    std::FILE* out = ::open_memstream(&data, &size);
    ASSERT_TRUE(write_scene(out, scene));
    std::fclose(out);
    const std::span<const uint8_t> bytes{reinterpret_cast<const uint8_t*>(data), size};
    EXPECT_TRUE(read_scene(bytes));
    for (size_t cut = 0; cut < size; ++cut) {
        EXPECT_FALSE(read_scene(bytes.first(cut))) << cut;
    }
    std::vector<uint8_t> wrong(bytes.begin(), bytes.end());
    for (size_t i = 0; i < wrong.size(); ++i) { // any changed byte is safe to use
        wrong[i] ^= 0xff;
        if (const auto read = read_scene(wrong)) {
            for (const LoadedMesh& mesh : read->meshes) {
                for (const uint32_t index : mesh.indices) {
                    ASSERT_LT(index, mesh.positions.size());
                }
            }
        }
        wrong[i] ^= 0xff;
    }
    std::free(data);
}

TEST(SceneCache, KeepsAFileUntilItOrWhatItReadsChanges)
{
    const TempFolder folder;
    const std::string file = folder.write("quad.obj", "v 0 0 0\n");
    const std::string material = folder.write("none.mtl", "newmtl a\n");
    LoadedScene scene;
    scene.sources = {{file, content_hash(file)}, {material, content_hash(material)}};
    scene.notes = {"kept"};
    keep_scene(folder.path("cache"), scene);
    const auto found = find_cached_scene(folder.path("cache"), file);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->notes, scene.notes);
    EXPECT_FALSE(find_cached_scene(folder.path("other"), file));
    folder.write("none.mtl", "newmtl b\n");
    EXPECT_FALSE(find_cached_scene(folder.path("cache"), file)) << "its material changed";
    folder.write("none.mtl", "newmtl a\n");
    EXPECT_TRUE(find_cached_scene(folder.path("cache"), file));
    folder.write("quad.obj", "# nothing\n");
    EXPECT_FALSE(find_cached_scene(folder.path("cache"), file)) << "it changed itself";
}

} // namespace
} // namespace occlude::tools
