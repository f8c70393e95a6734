#include "tools/cli_runner.h"

namespace occlude::tools {
namespace {

// The output as a terminal sees it: every part, and an empty line at the end.
void expect_watched(const std::vector<std::string>& arguments,
                    const std::vector<std::string>& parts)
{
    const Outcome watched = run(arguments, Watcher::terminal);
    ASSERT_EQ(watched.code, 0) << watched.err;
    for (const std::string& part : parts) {
        EXPECT_NE(watched.err.find(part), std::string::npos) << part << " in: " << watched.err;
    }
    EXPECT_EQ(watched.err.back(), '\r');
    EXPECT_EQ(run(arguments).err.find('\r'), std::string::npos) << "nobody watches";
}

TEST(ProgressOfCommands, LoadingBuildingMeasuringRecordingAndReplayingAreShown)
{
    const std::string recording = write_file("run.rec", "").string();
    expect_watched(
        small({"bench", "boxes:count=50", "--frames", "2", "--algorithms", "chc", "--record",
               recording}),
        {"boxes:count=50: building the tree [", "measuring boxes", "recording boxes", "%, about "});
    expect_watched({"replay", recording}, {"replaying boxes", "%, about "});
}

TEST(ProgressOfCommands, SeveralTreesAreCounted)
{
    expect_watched(small({"bench", "boxes:count=50", "--frames", "2", "--algorithms", "chc",
                          "--hierarchy", "bvh,octree"}),
                   {"boxes:count=50: building the trees ["});
}

TEST(ProgressOfCommands, ConvertingIsShown)
{
    const std::string scene = scene_file();
    expect_watched({"convert", scene, "--out", write_file("wall.glb", "").string()},
                   {"converting " + scene + ": writing, 0 s"});
}

} // namespace
} // namespace occlude::tools
