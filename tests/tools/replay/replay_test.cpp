// Recordings: a run repeats bit by bit without its scene and without its device. A broken file ends
// with a sentence.
#include "replay/replay.h"

#include "commands/cli.h"
#include "replay/check_tree.h"
#include "tools/temp_folder.h"

#include <occlude/core/rng.h>

#include <nlohmann/json.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <sstream>

namespace occlude::tools {

namespace {

struct Outcome {
    int code = -1;
    std::string out;
    std::string err;
};

Outcome run(const std::vector<std::string>& arguments)
{
    std::vector<const char*> argv{"occlude"};
    for (const std::string& argument : arguments) {
        argv.push_back(argument.c_str());
    }
    std::ostringstream out;
    std::ostringstream err;
    const int code = run_program(static_cast<int>(argv.size()), argv.data(), {out, err});
    return {code, out.str(), err.str()};
}

std::string content_of(const std::string& file)
{
    std::ifstream stream{file, std::ios::binary};
    return {std::istreambuf_iterator<char>{stream}, {}};
}

/// Records every algorithm in a small city on the CPU.
std::string record_city(const TempFolder& folder, const std::string& hierarchy = "bvh")
{
    const std::string file = folder.path("run.rec");
    const Outcome recorded = run({"bench", "city:blocks=2,triangles=10k", "--device", "cpu",
                                  "--size", "40x30", "--frames", "4", "--hierarchy", hierarchy,
                                  "--leaf-triangles", "200", "--record", file});
    EXPECT_EQ(recorded.code, 0) << recorded.err;
    return file;
}

RunRecording small_recording()
{
    const TempFolder folder;
    auto recording = from_bytes(content_of(record_city(folder)), "small");
    EXPECT_TRUE(recording);
    return std::move(*recording);
}

} // namespace

TEST(Replay, RepeatsEveryAlgorithmOnEveryTreeBitByBit)
{
    const TempFolder folder;
    const std::string file = record_city(folder, "all");
    const std::string json = folder.path("replay.json");
    const Outcome replayed = run({"replay", file, "--json", json});
    EXPECT_EQ(replayed.code, 0) << replayed.out << replayed.err;
    const auto document = nlohmann::json::parse(content_of(json));
    EXPECT_GT(document["runs"].size(), 40u); // algorithms times hierarchies
    uint64_t drawn = 0;
    for (const auto& one : document["runs"]) {
        EXPECT_TRUE(one["identical"]) << one;
        EXPECT_EQ(one["frames"], 4) << one;
        drawn += one["items_drawn"].get<uint64_t>();
    }
    EXPECT_GT(drawn, 1000u);
}

TEST(Replay, ChoosesRunsByNameAndNamesWhatWasRecorded)
{
    const TempFolder folder;
    const std::string file = record_city(folder);
    const Outcome one = run({"replay", file, "--algorithms", "chc,ideal"});
    EXPECT_EQ(one.code, 0) << one.err;
    EXPECT_NE(one.out.find("chc"), std::string::npos);
    EXPECT_EQ(one.out.find("stop_and_wait"), std::string::npos);
    const Outcome none = run({"replay", file, "--algorithms", "magic"});
    EXPECT_EQ(none.code, 2);
    EXPECT_NE(none.err.find("'magic'"), std::string::npos);
    EXPECT_NE(none.err.find("chc_plus_plus"), std::string::npos);
}

TEST(Replay, NamesTheFrameInWhichARunDecidesDifferently)
{
    RunRecording recording = small_recording();
    const auto chc = std::find_if(recording.runs.begin(), recording.runs.end(),
                                  [](const RecordedRun& r) { return r.algorithm == "chc"; });
    ASSERT_NE(chc, recording.runs.end());
    RecordedRun other_hash = *chc;
    other_hash.decision_hashes[2] ^= 1;
    auto replayed = replay(recording, other_hash);
    ASSERT_TRUE(replayed);
    EXPECT_EQ(replayed->mismatch, "frame 2: it decided differently");
    EXPECT_EQ(replayed->frames, 2u);

    RecordedRun other_algorithm = *chc; // stop_and_wait makes other calls to the device
    other_algorithm.algorithm = "stop_and_wait";
    replayed = replay(recording, other_algorithm);
    ASSERT_TRUE(replayed);
    EXPECT_NE(replayed->mismatch.find("frame "), std::string::npos);

    RecordedRun unknown = *chc;
    unknown.options = {{"magic", "1"}};
    EXPECT_FALSE(replay(recording, unknown));
}

TEST(Replay, TheBytesOfARecordingHoldAllOfIt)
{
    const RunRecording recording = small_recording();
    const auto bytes = to_bytes(recording);
    ASSERT_TRUE(bytes);
    const auto again = from_bytes(*bytes, "again");
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(*to_bytes(*again), *bytes);
    EXPECT_EQ(again->views.size(), 4u);
    EXPECT_EQ(again->runs.size(), recording.runs.size());
}

TEST(Replay, FilesThatAreCutOffChangedOrStrangeEndWithASentence)
{
    const auto bytes = to_bytes(small_recording());
    ASSERT_TRUE(bytes);
    Rng rng{5};
    const auto expect_broken = [](const std::string& content) {
        const auto loaded = from_bytes(content, "bad.rec");
        ASSERT_FALSE(loaded);
        EXPECT_EQ(loaded.error().message.rfind("bad.rec: it ", 0), 0u) << loaded.error().message;
        EXPECT_NE(loaded.error().message.find("record it again"), std::string::npos);
    };
    expect_broken("");
    expect_broken("an invalid device recording");
    for (int i = 0; i < 40; ++i) {
        expect_broken(bytes->substr(0, rng.below(static_cast<uint32_t>(bytes->size()))));
        std::string changed = *bytes;
        changed[rng.below(static_cast<uint32_t>(changed.size()))] ^= 0x10;
        expect_broken(changed);
    }
    const TempFolder folder;
    const Outcome missing = run({"replay", folder.path("nothing.rec")});
    EXPECT_EQ(missing.code, 2);
    EXPECT_NE(missing.err.find("nothing.rec: cannot be read"), std::string::npos);
}

// A hostile file has a right hash, so that only checks of its contents can stop it.
TEST(Replay, HostileTreesAreRefusedNotWalked)
{
    const RunRecording recording = small_recording();
    RecordedTree tree = recording.trees.front();
    ASSERT_EQ(check_tree(tree), "");
    ASSERT_GT(tree.nodes.size(), 8u);
    uint64_t refused = 0;
    Rng rng{9};
    constexpr std::array<uint32_t, 5> kValues{0, 1, 7, 0x7fffffff, 0xffffffff};
    for (int i = 0; i < 4000; ++i) {
        RecordedTree changed = tree;
        Node& node = changed.nodes[rng.below(static_cast<uint32_t>(changed.nodes.size()))];
        const std::array<uint32_t*, 8> fields{&node.parent.value, &node.first_child.value,
                                              &node.child_count,  &node.first_item,
                                              &node.own_items,    &node.subtree_items,
                                              &node.leaf,         &node.subtree_triangles};
        uint32_t& field = *fields[rng.below(fields.size())];
        const uint32_t before = field;
        field = rng.below(2) == 0 ? kValues[rng.below(kValues.size())] : field + 1;
        // Inner nodes may be virtual leaves or not. Everything else is determined.
        const bool other_leaf = &field == &node.leaf && field <= 1;
        const std::string problem = check_tree(changed);
        EXPECT_TRUE(field == before || other_leaf || !problem.empty()) << before << " " << field;
        refused += problem.empty() ? 0 : 1;
    }
    EXPECT_GT(refused, 2000u);
}

TEST(Replay, ScenesThatMoveAndSeveralScenesAreRefusedBeforehand)
{
    const TempFolder folder;
    const std::vector<std::string> rest{"--device", "cpu", "--size",   "40x30",
                                        "--frames", "2",   "--record", folder.path("x.rec")};
    std::vector<std::string> moving{"bench", "movers:count=20,triangles=2k"};
    moving.insert(moving.end(), rest.begin(), rest.end());
    const Outcome refused = run(moving);
    EXPECT_EQ(refused.code, 2);
    EXPECT_NE(refused.err.find("moves; recordings hold static scenes"), std::string::npos)
        << refused.err;
    std::vector<std::string> two{"bench", "city", "city"};
    two.insert(two.end(), rest.begin(), rest.end());
    EXPECT_NE(run(two).err.find("--record: give one SCENE"), std::string::npos);
}

} // namespace occlude::tools
