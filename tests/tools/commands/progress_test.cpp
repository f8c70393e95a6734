#include "tools/cli_runner.h"

#include "commands/progress.h"

#include <cmath>
#include <sstream>

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

TEST(Progress, IsSilentWhenNobodyWatches)
{
    std::ostringstream err;
    {
        Progress progress{err, Watcher::none, "work"};
        progress.show(0.5);
    }
    EXPECT_EQ(err.str(), "");
}

TEST(Progress, EstimatesFromTheShareDoneAndCleansUp)
{
    std::ostringstream err;
    double now = 0.0;
    {
        Progress progress{err, Watcher::terminal, "work", [&] { return now; }};
        now = 30.0;
        progress.show(0.25);
        EXPECT_NE(err.str().find("25%, about 1 min 30 s left"), std::string::npos) << err.str();
        const size_t length = err.str().size();
        now = 30.05;
        progress.show(0.26); // too soon to draw again
        EXPECT_EQ(err.str().size(), length);
    }
    EXPECT_EQ(err.str().back(), '\r');
}

TEST(Progress, PhasesHaveEstimatesOfTheirOwnAndUnknownSharesATime)
{
    std::ostringstream err;
    double now = 0.0;
    Progress progress{err, Watcher::terminal, "castle", [&] { return now; }};
    progress.show("reading", std::nan(""));
    now = 12.0;
    progress.show("reading", std::nan(""));
    EXPECT_NE(err.str().find("castle: reading, 12 s"), std::string::npos) << err.str();
    progress.show("building", 0.0); // at once, though the last line is new
    EXPECT_NE(err.str().find("castle: building ["), std::string::npos) << err.str();
    now = 22.0;
    progress.show("building", 0.5);
    EXPECT_NE(err.str().find("50%, about 10 s left"), std::string::npos) << err.str();
}

TEST(Progress, ALogGetsALineEveryTenSecondsWithoutABar)
{
    std::ostringstream err;
    double now = 0.0;
    {
        Progress progress{err, Watcher::log, "castle", [&] { return now; }};
        progress.show("reading", 0.0);
        now = 9.0;
        progress.show("measuring", 0.0);
        EXPECT_EQ(err.str(), "") << "short work leaves no line";
        now = 12.0;
        progress.show("measuring", 0.25);
        now = 21.0;
        progress.show("measuring", 0.9);
    }
    EXPECT_EQ(err.str(), "castle: measuring  25%, about 9 s left\n");
}

} // namespace
} // namespace occlude::tools
