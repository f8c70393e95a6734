#include "generate/scene_source.h"
#include "model/exact_split.h"
#include "model/mesh_tools.h"
#include "model/scene_options.h"
#include "support/source_dir.h"
#include "tools/temp_folder.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <iterator>

namespace occlude::tools {
namespace {

namespace fs = std::filesystem;

/// A winding staircase of slanted panels: planes must cut some of them.
Mesh slanted_mesh()
{
    MeshBuilder builder;
    for (int i = 0; i < 200; ++i) {
        const float x = 0.37f * static_cast<float>(i);
        const float y = 0.11f * static_cast<float>(i % 17);
        builder.quad({x, y, 0}, {x + 1.3f, y + 0.2f, 0.3f}, {x + 1.1f, y + 2, 0.4f},
                     {x - 0.2f, y + 1.7f, 0});
    }
    return builder.take("stairs", 100000);
}

std::string content(const fs::path& file)
{
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void expect_same(const Mesh& a, const Mesh& b)
{
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_EQ(a.normals, b.normals);
    EXPECT_EQ(a.indices, b.indices);
    ASSERT_EQ(a.parts.size(), b.parts.size());
    for (size_t i = 0; i < a.parts.size(); ++i) {
        EXPECT_EQ(a.parts[i].first_index, b.parts[i].first_index);
        EXPECT_EQ(a.parts[i].index_count, b.parts[i].index_count);
        EXPECT_EQ(a.parts[i].box, b.parts[i].box);
    }
}

TEST(ExactSplit, IsTheSameFromTheCache)
{
    const TempFolder folder;
    const fs::path cache = folder.path("a/cache"); // is made
    Mesh first = slanted_mesh();
    Mesh second = slanted_mesh();
    Mesh uncached = slanted_mesh();
    EXPECT_FALSE(split_mesh_exactly(first, 50, cache));
    EXPECT_TRUE(split_mesh_exactly(second, 50, cache));
    EXPECT_FALSE(split_mesh_exactly(uncached, 50, {}));
    EXPECT_GT(first.parts.size(), 8u);
    EXPECT_GT(first.positions.size(), slanted_mesh().positions.size());
    expect_same(first, second);
    expect_same(first, uncached);
    // No unfinished part is left.
    EXPECT_EQ(std::distance(fs::directory_iterator{cache}, fs::directory_iterator{}), 1);
}

TEST(ExactSplit, TheNameDependsOnAllThatTheCutDependsOn)
{
    const Mesh mesh = slanted_mesh();
    Mesh moved = mesh;
    moved.positions[3].x += 0.001f;
    Mesh turned = mesh;
    turned.normals[3] = -turned.normals[3];
    Mesh other = mesh;
    std::swap(other.indices[0], other.indices[1]);
    EXPECT_EQ(split_cache_name(mesh, 50), split_cache_name(slanted_mesh(), 50));
    EXPECT_NE(split_cache_name(mesh, 50), split_cache_name(mesh, 51));
    EXPECT_NE(split_cache_name(mesh, 50), split_cache_name(moved, 50));
    EXPECT_NE(split_cache_name(mesh, 50), split_cache_name(turned, 50));
    EXPECT_NE(split_cache_name(mesh, 50), split_cache_name(other, 50));
}

TEST(ExactSplit, ADamagedCacheFileIsIgnoredAndMadeAgain)
{
    const TempFolder folder;
    const fs::path cache = folder.path("cache");
    Mesh good = slanted_mesh();
    split_mesh_exactly(good, 50, cache);
    const fs::path file = cache / split_cache_name(slanted_mesh(), 50);
    const std::string whole = content(file);
    ASSERT_TRUE(read_cut_mesh(file));

    std::vector<std::string> damaged{"",
                                     "x",
                                     whole.substr(0, 39),
                                     whole.substr(0, whole.size() / 2),
                                     whole + "x",
                                     std::string(whole.size(), '\xff')};
    for (size_t at = 0; at < whole.size(); at += 97) { // every byte counts
        damaged.push_back(whole);
        damaged.back()[at] = static_cast<char>(damaged.back()[at] ^ 0x10);
    }
    for (const std::string& bytes : damaged) {
        std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
        ASSERT_FALSE(read_cut_mesh(file)) << bytes.size();
    }
    Mesh again = slanted_mesh();
    EXPECT_FALSE(split_mesh_exactly(again, 50, cache));
    EXPECT_EQ(content(file), whole);
    expect_same(again, good);
    EXPECT_FALSE(read_cut_mesh(cache / "no such file"));
}

TEST(ExactSplit, ACacheThatCannotBeWrittenOnlyCostsTime)
{
    const TempFolder folder;
    const std::string blocked = folder.write("file", "not a folder");
    Mesh mesh = slanted_mesh();
    EXPECT_FALSE(split_mesh_exactly(mesh, 50, fs::path{blocked} / "cache"));
    EXPECT_GT(mesh.parts.size(), 8u);
}

TEST(ExactSplit, ASmallMeshIsOnePartAndNotKept)
{
    const TempFolder folder;
    const fs::path cache = folder.path("cache");
    Mesh mesh = slanted_mesh();
    EXPECT_FALSE(split_mesh_exactly(mesh, 1000, cache));
    EXPECT_EQ(mesh.parts.size(), 1u);
    EXPECT_EQ(mesh.positions, slanted_mesh().positions);
    EXPECT_FALSE(fs::exists(cache));
}

TEST(ExactSplit, ScenesCanBeLoadedCut)
{
    const TempFolder folder;
    SceneOptions options{.item_triangles = 500};
    const auto whole = load_scene(source_dir() + "/assets/castle/castle.glb", options);
    options.split = SceneOptions::Split::exact;
    options.cache_folder = folder.path("cache");
    const auto cut = load_scene(source_dir() + "/assets/castle/castle.glb", options);
    ASSERT_TRUE(whole);
    ASSERT_TRUE(cut);
    EXPECT_GT(drawn_triangles(*cut), drawn_triangles(*whole));
    EXPECT_LT(drawn_triangles(*cut), drawn_triangles(*whole) * 3 / 2);
    EXPECT_EQ(world_bounds(*cut), world_bounds(*whole));
    EXPECT_TRUE(fs::exists(options.cache_folder));
}

TEST(ExactSplit, TheCacheIsWhereTheUserKeepsCaches)
{
    const char* old = std::getenv("XDG_CACHE_HOME");
    const std::string kept = old != nullptr ? old : "";
    ::setenv("XDG_CACHE_HOME", "/somewhere", 1);
    EXPECT_EQ(default_cache_folder(), fs::path{"/somewhere/occlude"});
    ::unsetenv("XDG_CACHE_HOME");
    if (const char* home = std::getenv("HOME")) {
        EXPECT_EQ(default_cache_folder(), fs::path{home} / ".cache" / "occlude");
    }
    if (old != nullptr) {
        ::setenv("XDG_CACHE_HOME", kept.c_str(), 1);
    }
}

} // namespace
} // namespace occlude::tools
