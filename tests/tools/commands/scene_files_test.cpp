// Messages of the commands about scene files, and about frames that prove nothing.
#include "load/scene_cache.h"
#include "support/source_dir.h"
#include "tools/cli_runner.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace occlude::tools {

TEST(Cli, FramesThatShowNothingProveNothing)
{
    const std::string away =
        write_file("away.json", R"({"version":1,"frames":[{"eye":[0,0,50],"target":[0,0,90]},
                                 {"eye":[0,0,60],"target":[0,0,90]}]})")
            .string();
    const std::string json = (fs::path{away}.parent_path() / "away_out.json").string();
    for (const char* command : {"verify", "bench"}) {
        const Outcome outcome = run(
            small({command, scene_file(), "--path", away, "--algorithms", "chc", "--json", json}));
        EXPECT_EQ(outcome.code, 3) << outcome.out << outcome.err;
        EXPECT_NE(outcome.out.find("nothing was in view in any of the 2 frames"), std::string::npos)
            << outcome.out;
        const auto document = nlohmann::json::parse(std::ifstream{json});
        EXPECT_EQ(document["evidence"]["empty_frames"], 2);
        EXPECT_EQ(document["evidence"]["hiding_frames"], 0);
    }
}

TEST(Cli, APathThatLooksPastTheSceneProvesNothing)
{
    const std::string data = source_dir() + "/tests/data/scenes/";
    const Outcome outcome = run(small({"verify", data + "f07_invisible_wall.glb", "--path",
                                       data + "near_huge.json", "--algorithms", "chc"}));
    EXPECT_EQ(outcome.code, 3) << outcome.out << outcome.err;
    EXPECT_NE(outcome.out.find("nothing was in view"), std::string::npos) << outcome.out;
}

TEST(Cli, NothingHiddenIsSaidAndMayBeExpected)
{
    const std::string quad =
        write_file("quad.obj", "o quad\nv -4 -4 0\nv 4 -4 0\nv 4 4 0\nv -4 4 0\nf 1 2 3 4\n")
            .string();
    const std::vector<std::string> verify =
        small({"verify", quad, "--path", "orbit", "--algorithms", "chc", "--frames", "4"});
    const Outcome strict = run(verify);
    EXPECT_EQ(strict.code, 3) << strict.out << strict.err;
    EXPECT_NE(strict.out.find("Nothing was hidden"), std::string::npos) << strict.out;
    std::vector<std::string> expected = verify;
    expected.emplace_back("--nothing-hidden-is-fine");
    EXPECT_EQ(run(expected).code, 0);
    const Outcome bench =
        run(small({"bench", quad, "--path", "orbit", "--algorithms", "chc", "--frames", "4"}));
    EXPECT_EQ(bench.code, 0) << "a measurement all the same";
    EXPECT_NE(bench.out.find("Nothing was hidden"), std::string::npos) << bench.out;
}

/// A camera that moves toward two coplanar walls of different colours, and turns so that their
/// order by distance changes.
TEST(Cli, CoincidentSurfacesAreNamedInVerifyAndFailOnlyIfStrict)
{
    const std::string data = source_dir() + "/tests/data/scenes/";
    const std::string json = (fs::path{write_file("any", "")}.parent_path() / "tied.json").string();
    std::vector<std::string> verify{"verify", data + "f21_coplanar.glb"};
    for (const char* argument :
         {"--path", "", "--json", "", "--algorithms", "exact", "--frames", "12",
          "--nothing-hidden-is-fine", "--device", "gl", "--size", "40x30"}) {
        verify.emplace_back(argument);
    }
    verify[3] = data + "p21_move.json";
    verify[5] = json;
    const Outcome outcome = run(verify);
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    EXPECT_NE(outcome.out.find("equal but for ties"), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("Coincident surfaces: "), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("shade afterwards in a fixed order"), std::string::npos);
    const auto document = nlohmann::json::parse(std::ifstream{json});
    ASSERT_FALSE(document["coincident"].empty());
    const std::string name = document["coincident"][0]["objects"][0];
    EXPECT_NE(outcome.out.find("'" + name + "'"), std::string::npos) << outcome.out;
    EXPECT_GT(document["coincident"][0]["pixels"], 0);
    verify.emplace_back("--strict");
    EXPECT_EQ(run(verify).code, 1);
}

TEST(Cli, WhatIsLeftOutOfAFileIsSaidAndStrictRefusesIt)
{
    const std::string file =
        write_file("flat.obj", "o a\nv 0 0 0\nv 4 0 0\nv 0 4 0\nv 9 9 9\nf 1 2 3\nf 1 1 4\n")
            .string();
    const Outcome info = run(small({"info", file, "--unit", "cm", "--up", "z"}));
    EXPECT_EQ(info.code, 0) << info.err;
    EXPECT_NE(info.out.find("1 of 2 in the file"), std::string::npos) << info.out;
    EXPECT_NE(info.out.find("1 triangles without area"), std::string::npos) << info.out;
    EXPECT_NE(info.out.find("100 units a metre (as --unit says"), std::string::npos) << info.out;
    EXPECT_NE(info.out.find("up is +z (as --up says"), std::string::npos) << info.out;
    expect_refused(small({"info", file, "--strict"}), {"flat.obj", "--strict", "without area"});
    expect_refused({"convert", file, "--strict", "--out", file + ".glb"}, {"--strict"});
    EXPECT_FALSE(fs::exists(file + ".glb"));
    expect_refused({"info", file, "--origin", "1e30,0,0"}, {"flat.obj", "--origin", "far away"});
    expect_refused({"info", file, "--unit", "furlong"}, {"--unit", "furlong", "mm"});
    expect_refused({"info", file, "--up", "w"}, {"--up", "'w'"});
    expect_refused({"info", file, "--origin", "1,2"}, {"--origin", "'1,2'", "X,Y,Z"});
}

TEST(Cli, ConvertWritesMetresWithYUp)
{
    const std::string town = write_file("town.obj", "o house\nv 0 0 0\nv 8000 0 0\nv 0 8000 0\n"
                                                    "v 0 0 3000\nf 1 2 3\nf 1 2 4\nf 1 3 4\n")
                                 .string();
    const std::string glb = (fs::path{town}.parent_path() / "town.glb").string();
    const Outcome convert = run({"convert", town, "--out", glb, "--unit", "mm", "--up", "z"});
    ASSERT_EQ(convert.code, 0) << convert.err;
    const Outcome info = run(small({"info", glb}));
    ASSERT_EQ(info.code, 0) << info.err;
    EXPECT_NE(info.out.find("to (8, 3, "), std::string::npos) << info.out;
    expect_refused({"convert", town, "--out", "town.obj"}, {"--out", ".glb"});
}

/// Writes other bytes of the same size over a file and puts its time back.
static void change_in_place(const fs::path& file, const std::string& content)
{
    ASSERT_EQ(fs::file_size(file), content.size());
    const auto time = fs::last_write_time(file);
    std::ofstream(file, std::ios::in | std::ios::out) << content;
    fs::last_write_time(file, time);
}

TEST(Cli, AKeptSceneIsUsedUntilAnyOfItsFilesHasOtherContent)
{
    const std::string obj = "mtllib paint.mtl\nusemtl a\nv 0 0 0\nv 4 0 0\nv 0 4 0\nf 1 2 3\n";
    const fs::path material = write_file("paint.mtl", "newmtl a\nd 1.0\n");
    const fs::path file = write_file("kept.obj", obj);
    const std::string cache = (file.parent_path() / "cache").string();
    LoadedScene scene; // as a slow reader would have left it there, but told apart by a note
    scene.meshes.push_back({.positions = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}, .indices = {0, 1, 2}});
    scene.instances.push_back({});
    scene.notes = {"from the cache"};
    for (const fs::path& source : {file, material}) {
        scene.sources.push_back({source.string(), content_hash(source)});
    }
    keep_scene(cache, scene);
    const auto uses_cache = [&] {
        const Outcome info = run(small({"info", file.string(), "--cache", cache}));
        EXPECT_EQ(info.code, 0) << info.err;
        return info.out.find("from the cache") != std::string::npos;
    };
    EXPECT_TRUE(uses_cache());
    change_in_place(material, "newmtl a\nd 0.5\n");
    EXPECT_FALSE(uses_cache()) << "another file that it reads changed";
    change_in_place(material, "newmtl a\nd 1.0\n");
    EXPECT_TRUE(uses_cache());
    std::string edited = obj;
    edited[edited.find("v 4 0") + 2] = '5';
    change_in_place(file, edited);
    EXPECT_FALSE(uses_cache()) << "it changed itself";
}

TEST(Cli, ABufferOfAGltfFileThatChangesInPlaceIsReadAgain)
{
    const auto corner = [](float x) {
        const float corners[9] = {0, 0, 0, x, 0, 0, 0, 1, 0};
        return std::string{reinterpret_cast<const char*>(corners), sizeof corners};
    };
    const fs::path buffer = write_file("corners.bin", corner(2.0f));
    const std::string file =
        write_file("tri.gltf",
                   R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
                       "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
                       "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
                       "bufferViews":[{"buffer":0,"byteLength":36}],
                       "buffers":[{"byteLength":36,"uri":"corners.bin"}]})")
            .string();
    const std::string cache = (buffer.parent_path() / "cache").string();
    EXPECT_NE(run(small({"info", file, "--cache", cache})).out.find("to (2, 1, "),
              std::string::npos);
    change_in_place(buffer, corner(3.0f));
    EXPECT_NE(run(small({"info", file, "--cache", cache})).out.find("to (3, 1, "),
              std::string::npos);
}

} // namespace occlude::tools
