#include "tools/cli_runner.h"

#include <nlohmann/json.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <unistd.h>

namespace occlude::tools {

TEST(Cli, HelpExitsWithZeroAndNamesEveryCommand)
{
    const Outcome outcome = run({"--help"});
    EXPECT_EQ(outcome.code, 0);
    for (const char* command : {"bench", "verify", "render", "info", "list", "convert"}) {
        EXPECT_NE(outcome.out.find(command), std::string::npos) << command;
    }
    EXPECT_EQ(outcome.err, "");
    EXPECT_EQ(run({"--version"}).code, 0);
}

TEST(Cli, BenchHasTheOptionsOfTheContract)
{
    const Outcome outcome = run({"bench", "--help"});
    EXPECT_EQ(outcome.code, 0);
    for (const char* option : {"--algorithms", "--hierarchy", "--device", "--test", "--path",
                               "--frames", "--size", "--msaa", "--repeat", "--verify", "--set",
                               "--leaf-triangles", "--json", "--csv", "--html"}) {
        EXPECT_NE(outcome.out.find(option), std::string::npos) << option;
    }
}

TEST(Cli, WrongCommandsAndOptionsAreRefusedWithWhatWouldWork)
{
    const std::string scene = scene_file();
    expect_refused({}, {"bench", "--help"});
    expect_refused({"bnech", scene}, {"'bnech'", "bench"});
    expect_refused({"watch", scene}, {"'watch'"});
    expect_refused({"bench"}, {"scenes", "bench --help"});
    expect_refused({"bench", scene, "--nonsense"}, {"--nonsense", "bench --help"});
    expect_refused({"bench", scene, "--frames", "0"}, {"--frames", "'0'"});
    expect_refused({"bench", scene, "--frames", "-3"}, {"--frames", "-3"});
    expect_refused({"bench", scene, "--frames", "99999999999999999999999"}, {"--frames"});
    expect_refused({"bench", scene, "--repeat", "many"}, {"--repeat", "'many'"});
    expect_refused({"bench", scene, "--size", "12"}, {"--size", "'12'", "1280x720"});
    expect_refused({"bench", scene, "--size", "0x5"}, {"--size", "'0x5'"});
    expect_refused({"bench", scene, "--device", "abacus"}, {"--device", "'abacus'", "cpu"});
    expect_refused({"bench", scene, "--hierarchy", "heap"}, {"--hierarchy", "'heap'", "bvh"});
    expect_refused({"bench", scene, "--test", "guess"}, {"--test", "'guess'", "queries"});
    expect_refused({"bench", scene, "--device", "cpu", "--test", "raster"},
                   {"--test raster", "queries or pyramid"});
    expect_refused({"bench", scene, "--device", "cpu", "--msaa", "4"}, {"--msaa 4", "gl"});
    expect_refused({"bench", scene, "--algorithms", "chc,magic"}, {"'magic'", "chc_plus_plus"});
    expect_refused({"render", scene, "--out", "x.png", "--show", "smell"}, {"'smell'", "states"});
    expect_refused({"render", scene, "--out", "x.png", "--camera", "moon"}, {"'moon'", "overview"});
    expect_refused({"render", scene, "--out", "frames", "--frames", "9:3"},
                   {"'9:3'", "FIRST:LAST"});
    expect_refused({"list", "things"}, {"'things'", "algorithms"});
    expect_refused({"list", "devices", scene}, {"paths"});
}

TEST(Cli, EmptyFileNamesAreRefusedNotTakenForNoFile)
{
    const std::string scene = scene_file();
    for (const char* option : {"--json", "--csv", "--html"}) {
        expect_refused({"bench", scene, option, ""}, {option, "the file name is empty"});
    }
    expect_refused({"render", scene, "--out", ""}, {"--out", "the file name is empty"});
    expect_refused({"generate", "city", "--out", ""}, {"--out", "the file name is empty"});
}

TEST(Cli, AFullStandardOutputIsAnErrorWithASentence)
{
    for (const char* command : {"--help", "--version", "list"}) {
        std::ofstream full{"/dev/full"};
        std::ostringstream err;
        const std::array argv = {"occlude", command, "algorithms"};
        EXPECT_EQ(run_program(command[0] == '-' ? 2 : 3, argv.data(), {full, err}), 2) << command;
        EXPECT_EQ(err.str(), "occlude: cannot write to the standard output; is the disk full?\n");
    }
}

TEST(Cli, SettingsMustReachAnAlgorithmThatTakesPart)
{
    const std::string scene = scene_file();
    expect_refused({"bench", scene, "--set", "chc"}, {"--set", "'chc'", "ALGORITHM.OPTION=VALUE"});
    expect_refused({"bench", scene, "--set", "nobody.x=1"}, {"'nobody'", "chc"});
    expect_refused({"bench", scene, "--set", "chc.no_such=1"}, {"no_such", "chc"});
    expect_refused({"bench", scene, "--algorithms", "frustum", "--set", "chc.threshold=1"},
                   {"chc does not take part"});
}

TEST(Cli, SettingsReachHierarchiesByTheirNames)
{
    const std::string scene = scene_file();
    expect_refused(
        {"bench", scene, "--hierarchy", "bsp", "--set", "bsp.splat=1"},
        {"--set bsp", "'splat'", "split, straddling, max_leaf_items, max_depth, leaf_triangles"});
    expect_refused({"bench", scene, "--hierarchy", "bsp", "--set", "bsp.split=best"},
                   {"--set bsp", "'best'", "cost middle median"});
    expect_refused({"bench", scene, "--set", "grid.items_per_cell=2"},
                   {"--set grid.items_per_cell", "--hierarchy"});
    expect_refused(
        {"bench", scene, "--hierarchy", "two_level", "--set", "two_level.quiet_frames=4"},
        {"two_level", "quiet_frames"}); // the algorithm
    const Outcome listed = run({"list", "hierarchies"});
    for (const char* option : {"bvh.max_leaf_items=4", "bsp.split=cost", "octree.max_depth=21",
                               "grid.items_per_cell=8", "two_level_tree.quiet_frames=0"}) {
        EXPECT_NE(listed.out.find(std::string{"--set "} + option), std::string::npos) << option;
    }
    // A tree of one leaf needs one test.
    const std::string json = write_file("tree_settings.json", "").string();
    const Outcome outcome =
        run(small({"bench", scene, "--frames", "1", "--json", json, "--hierarchy", "bvh,two_level",
                   "--algorithms", "chc", "--set", "bvh.leaf_triangles=1000000", "--set",
                   "two_level_tree.leaf_triangles=1000000"}));
    EXPECT_EQ(outcome.code, 0) << outcome.err;
}

TEST(Cli, AnAlgorithmRunsSeveralTimesWithOptionsOfItsOwn)
{
    const std::string json = write_file("variants.json", "").string();
    const Outcome outcome = run(small({"bench", scene_file(), "--frames", "3", "--json", json,
                                       "--algorithms", "lazy_grid:update=busy,chc,lazy_grid"}));
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    std::ifstream file{json};
    const nlohmann::json runs = nlohmann::json::parse(file)["runs"];
    std::map<std::string, double> asked;
    for (const auto& each : runs) {
        asked[each["algorithm"]] = each["per_frame"]["cells_asked"];
    }
    ASSERT_TRUE(asked.contains("lazy_grid:update=busy"));
    EXPECT_GT(asked["lazy_grid:update=busy"], asked["lazy_grid"]);
}

TEST(Cli, MissingBrokenAndEmptyScenesAreNamed)
{
    expect_refused({"info", "no/such/scene.glb"}, {"no/such/scene.glb"});
    const std::string broken = write_file("broken.glb", "this is no scene").string();
    expect_refused({"bench", broken, "--device", "cpu"}, {"broken.glb"});
    const std::string empty = write_file("empty.obj", "v 0 0 0\nv 1 0 0\n").string();
    expect_refused({"info", empty, "--device", "cpu"}, {"empty.obj"});
}

TEST(Cli, MissingAndEmptyPathsAreNamed)
{
    const std::string scene = scene_file();
    expect_refused(small({"bench", scene, "--path", "no_such_path"}), {"no_such_path"});
    const std::string empty =
        write_file("empty_path.json", R"({"version":1,"frames":[]})").string();
    expect_refused(small({"bench", scene, "--path", empty}), {"empty_path.json"});
    const std::string broken = write_file("broken_path.json", R"({"version":1,)").string();
    expect_refused(small({"bench", scene, "--path", broken}), {"broken_path.json"});
}

TEST(Cli, UnwritableOutputIsFoundBeforeTheRun)
{
    const std::string scene = scene_file();
    expect_refused(small({"bench", scene, "--json", "no/such/directory/out.json"}),
                   {"no/such/directory/out.json"});
    expect_refused({"bench", "no_scene_either.glb", "--csv", "no/such/directory/out.csv"},
                   {"out.csv"}); // before the scene is even looked for
    expect_refused({"render", scene, "--out", "no/such/directory/out.png"}, {"out.png"});
}

TEST(Cli, BenchMeasuresAndWritesItsReports)
{
    const std::string scene = scene_file();
    const fs::path directory = fs::path{scene}.parent_path();
    const std::string json = (directory / "bench.json").string();
    const std::string csv = (directory / "bench.csv").string();
    const std::string html = (directory / "bench.html").string();
    const Outcome outcome = run(
        small({"bench", scene, "--algorithms", "chc", "--frames", "5", "--repeat", "2", "--verify",
               "--set", "chc.threshold=0", "--json", json, "--csv", csv, "--html", html}));
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, ""); // nobody watches: no progress
    for (const char* algorithm : {"frustum", "chc", "opt", "ideal"}) { // including the references
        EXPECT_NE(outcome.out.find(std::string{"\n"} + algorithm + " "), std::string::npos)
            << outcome.out;
    }
    std::ifstream file{json};
    const nlohmann::json report = nlohmann::json::parse(file);
    EXPECT_EQ(report["frames"], 5);
    EXPECT_EQ(report["repeat"], 2);
    EXPECT_EQ(report["device"]["name"], "cpu");
    ASSERT_EQ(report["runs"].size(), 4u);
    for (const auto& each : report["runs"]) {
        EXPECT_EQ(each["differing_pixels"], 0) << each["algorithm"];
        EXPECT_GT(each["frame_ms"]["median"], 0.0);
        EXPECT_EQ(each["frames"].size(), 5u);
    }
    EXPECT_GT(fs::file_size(csv), 100u);
    EXPECT_GT(fs::file_size(html), 100000u);
}

TEST(Cli, BenchComparesHierarchiesInOneRunAndLabelsThem)
{
    const std::string scene = scene_file();
    const std::string json = (fs::path{scene}.parent_path() / "hierarchies.json").string();
    const Outcome outcome = run(small({"bench", scene, "--algorithms", "chc", "--frames", "2",
                                       "--verify", "--hierarchy", "bvh,octree", "--json", json}));
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("hierarchy bvh, octree"), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("\nalgorithm  hierarchy"), std::string::npos) << outcome.out;
    std::ifstream file{json};
    std::vector<std::string> runs;
    const nlohmann::json report = nlohmann::json::parse(file);
    for (const auto& each : report["runs"]) {
        runs.push_back(each["algorithm"].get<std::string>() + "/" +
                       each["hierarchy"].get<std::string>());
        EXPECT_EQ(each["differing_pixels"], 0) << runs.back();
    }
    const std::vector<std::string> expected{"frustum/bvh", "frustum/octree", "chc/bvh",
                                            "chc/octree",  "opt/bvh",        "opt/octree",
                                            "ideal/bvh"};
    EXPECT_EQ(runs, expected);
}

TEST(Cli, AlgorithmsThatDoNotSuitAHierarchyAreLeftOutWithANote)
{
    const Outcome outcome = run(small({"verify", scene_file(), "--frames", "2", "--path", "auto",
                                       "--algorithms", "exact", "--hierarchy", "bsp"}));
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("batch_and_wait is left out on bsp"), std::string::npos)
        << outcome.err;
    EXPECT_EQ(outcome.out.find("\nbatch_and_wait"), std::string::npos) << outcome.out;
}

TEST(Cli, OtherCommandsTakeOneHierarchy)
{
    const std::string scene = scene_file();
    expect_refused({"info", scene, "--hierarchy", "all"}, {"--hierarchy", "'all'", "bench"});
    expect_refused({"render", scene, "--out", "x.png", "--hierarchy", "bvh,bsp"}, {"'bvh,bsp'"});
}

TEST(Cli, VerifyWalksASmoothPathAndOneWithJumpsAndExitsWithZero)
{
    const Outcome outcome = run(small({"verify", scene_file(), "--frames", "6"}));
    EXPECT_EQ(outcome.code, 0) << outcome.err << outcome.out;
    EXPECT_NE(outcome.out.find("path auto"), std::string::npos);
    EXPECT_NE(outcome.out.find("path teleport"), std::string::npos);
    EXPECT_EQ(outcome.out.find("DIFFERS"), std::string::npos);
}

// llvmpipe gives four samples for two requested ones. The table states the actual number.
TEST(Cli, TheTableSaysHowManySamplesThereAreNotHowManyWereAskedFor)
{
    const std::string json = write_file("samples.json", "").string();
    const Outcome outcome = run({"bench", scene_file(), "--device", "gl", "--msaa", "2", "--frames",
                                 "2", "--size", "32x24", "--algorithms", "chc", "--json", json});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    std::ifstream file{json};
    const std::string document{std::istreambuf_iterator<char>{file}, {}};
    const size_t at = document.find("\"samples\":");
    ASSERT_NE(at, std::string::npos);
    const int samples = std::atoi(document.c_str() + at + 10);
    EXPECT_GE(samples, 2);
    EXPECT_NE(outcome.out.find(std::to_string(samples) + " samples on"), std::string::npos)
        << outcome.out;
}

TEST(Cli, MovingScenesAreVerifiedOnEveryHierarchyAndSaidToMove)
{
    const std::string scene = "movers:count=60,triangles=2k";
    const Outcome outcome = run(small({"verify", scene, "--frames", "20", "--leaf-triangles", "50",
                                       "--hierarchy", "all", "--repeat", "2"}));
    EXPECT_EQ(outcome.code, 0) << outcome.err << outcome.out;
    const Outcome info = run(small({"info", scene}));
    EXPECT_NE(info.out.find("60, moving, 15 of them appear and vanish"), std::string::npos)
        << info.out;
}

TEST(Cli, RenderWritesPngFilesOfTheSizeAskedFor)
{
    const std::string scene = scene_file();
    const fs::path directory = fs::path{scene}.parent_path() / "pictures";
    fs::remove_all(directory);
    fs::create_directories(directory);
    for (const char* show : {"visible", "hidden", "boxes", "states"}) {
        for (const char* camera : {"path", "overview"}) {
            const std::string png = (directory / (std::string{show} + camera + ".png")).string();
            const Outcome outcome =
                run(small({"render", scene, "--algorithm", "stop_and_wait", "--frame", "3",
                           "--show", show, "--camera", camera, "--out", png}));
            ASSERT_EQ(outcome.code, 0) << outcome.err;
            std::ifstream file{png, std::ios::binary};
            const std::string bytes{std::istreambuf_iterator<char>{file}, {}};
            ASSERT_GT(bytes.size(), 24u);
            EXPECT_EQ(bytes.substr(1, 3), "PNG");
            EXPECT_EQ(bytes[19], 40); // width, height: big-endian words of the header
            EXPECT_EQ(bytes[23], 30);
            const bool legend = std::string{show} != "visible";
            EXPECT_EQ(outcome.out.find("drawn_near") != std::string::npos, legend);
        }
    }
}

TEST(Cli, RenderOfARangeFillsADirectory)
{
    const std::string scene = scene_file();
    const fs::path directory = fs::path{scene}.parent_path() / "range";
    fs::remove_all(directory);
    const Outcome outcome =
        run(small({"render", scene, "--frames", "2:4", "--out", directory.string()}));
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_FALSE(fs::exists(directory / "frame_0001.png"));
    EXPECT_TRUE(fs::exists(directory / "frame_0002.png"));
    EXPECT_TRUE(fs::exists(directory / "frame_0004.png"));
    EXPECT_EQ(std::distance(fs::directory_iterator{directory}, fs::directory_iterator{}), 3);
}

TEST(Cli, RenderBeyondTheEndOfThePathSaysWhereItEnds)
{
    expect_refused(small({"render", scene_file(), "--frame", "7", "--path-frames", "5", "--out",
                          (fs::path{testing::TempDir()} / "beyond.png").string()}),
                   {"frame 7", "last frame is 4", "--path-frames"});
}

TEST(Cli, InfoCountsTheSceneAndSaysWhatToDo)
{
    const Outcome outcome = run(small({"info", scene_file()}));
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("triangles         4\n"), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("own a pixel"), std::string::npos);
    EXPECT_NE(outcome.out.find("Culling is unlikely to pay"), std::string::npos);
}

TEST(Cli, ListsWhatThereIs)
{
    const std::string algorithms = run({"list", "algorithms"}).out;
    EXPECT_NE(algorithms.find("chc_plus_plus"), std::string::npos);
    EXPECT_NE(algorithms.find("hierarchies: bvh, bsp, octree, grid, two_level"), std::string::npos);
    EXPECT_NE(algorithms.find("hierarchies: bvh, octree, grid\n"), std::string::npos);
    EXPECT_NE(algorithms.find("hierarchies: any"), std::string::npos);
    EXPECT_NE(run({"list", "hierarchies"}).out.find("bvh"), std::string::npos);
    EXPECT_NE(run({"list", "devices"}).out.find("cpu"), std::string::npos);
    EXPECT_NE(run({"list", "scenes"}).out.find("city"), std::string::npos);
    EXPECT_NE(run({"list", "paths"}).out.find("auto"), std::string::npos);
    EXPECT_EQ(run({"list", "paths", scene_file()}).code, 0);
}

TEST(Cli, ViewSaysWhatIsWrongBeforeItOpensAnything)
{
    expect_refused({"view", scene_file(), "--headless"}, {"--frames or --script"});
    expect_refused({"view", scene_file(), "--algorithm", "magic"}, {"'magic'"});
}

} // namespace occlude::tools
