#include "measure/measure.h"

#include "tools/tiny_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace occlude::tools {

using namespace test;

TEST(Statistics, MedianIsTheMiddleOrTheMeanOfTheTwoMiddleOnes)
{
    EXPECT_DOUBLE_EQ(median(std::vector<double>{5.0, 1.0, 3.0}), 3.0);
    EXPECT_DOUBLE_EQ(median(std::vector<double>{4.0, 1.0, 3.0, 100.0}), 3.5);
}

TEST(Statistics, PercentilesInterpolateBetweenRanks)
{
    const std::vector<double> values = {50.0, 10.0, 40.0, 20.0, 30.0};
    EXPECT_DOUBLE_EQ(percentile(values, 0.0), 10.0);
    EXPECT_DOUBLE_EQ(percentile(values, 0.25), 20.0);
    EXPECT_DOUBLE_EQ(percentile(values, 0.95), 48.0); // rank 3.8 of 0..4
    EXPECT_DOUBLE_EQ(percentile(values, 1.0), 50.0);
}

TEST(Statistics, DistributionOfFourValuesByHand)
{
    const Distribution d = distribution(std::vector<double>{1.0, 2.0, 3.0, 10.0});
    EXPECT_DOUBLE_EQ(d.median, 2.5);
    EXPECT_DOUBLE_EQ(d.mean, 4.0);
    EXPECT_DOUBLE_EQ(d.p95, 3.0 + 0.85 * 7.0); // rank 2.85
    EXPECT_DOUBLE_EQ(d.p99, 3.0 + 0.97 * 7.0);
    EXPECT_DOUBLE_EQ(d.max, 10.0);
    EXPECT_DOUBLE_EQ(d.total, 16.0);
}

TEST(Statistics, NothingMeasuredIsNotANumber)
{
    EXPECT_TRUE(std::isnan(median({})));
    EXPECT_TRUE(std::isnan(mean({})));
    EXPECT_TRUE(std::isnan(median(std::vector<double>{1.0, kNotMeasured})));
}

TEST(ContenderOrder, RotatesByOneFromFrameToFrameAndFromRepeatToRepeat)
{
    EXPECT_EQ(contender_order(3, 0, 0), (std::vector<size_t>{0, 1, 2}));
    EXPECT_EQ(contender_order(3, 1, 0), (std::vector<size_t>{1, 2, 0}));
    EXPECT_EQ(contender_order(3, 2, 0), (std::vector<size_t>{2, 0, 1}));
    EXPECT_EQ(contender_order(3, 2, 1), (std::vector<size_t>{0, 1, 2}));
}

TEST(OverdrawItems, CountsDrawnItemsWithoutPixelsPerItemWithPixels)
{
    const std::vector<ItemId> drawn = {ItemId{7u}, ItemId{1u}, ItemId{4u}, ItemId{2u}, ItemId{9u}};
    const std::vector<ItemId> owners = {ItemId{1u}, ItemId{7u}};
    EXPECT_DOUBLE_EQ(overdraw_items(drawn, owners), 1.5);
    EXPECT_DOUBLE_EQ(overdraw_items({}, {}), 0.0);
}

TEST(OwnersOfPixels, AreTheDifferentItemsInOrderWithoutTheBackground)
{
    const std::vector<uint32_t> ids = {5, 5, ItemId::kInvalid, 2, 5, 2, ItemId::kInvalid};
    EXPECT_EQ(owners_of_pixels(ids), (std::vector<ItemId>{ItemId{2u}, ItemId{5u}}));
}

TEST(CompareWithReferences, FormsRatiosPerFrameBeforeAnythingIsSummedUp)
{
    std::vector<AlgorithmRun> runs;
    const auto add = [&](const char* name, double first, double second) {
        AlgorithmRun run{name, {}, std::vector<FrameFigures>(2)};
        run.frames[0].frame_ms = first;
        run.frames[1].frame_ms = second;
        runs.push_back(run);
    };
    add("frustum", 10.0, 100.0);
    add("chc", 5.0, 10.0);
    add("opt", 4.0, 5.0);
    add("ideal", 2.0, 4.0);
    compare_with_references(runs);
    EXPECT_DOUBLE_EQ(runs[1].frames[0].speedup_vs_frustum, 2.0);
    EXPECT_DOUBLE_EQ(runs[1].frames[1].speedup_vs_frustum, 10.0);
    EXPECT_DOUBLE_EQ(runs[1].frames[1].ratio_to_opt, 2.0);
    EXPECT_DOUBLE_EQ(runs[1].frames[0].ratio_to_ideal, 2.5);
    EXPECT_DOUBLE_EQ(summarise(runs[1]).speedup_vs_frustum, 6.0); // not 110 / 15
    EXPECT_DOUBLE_EQ(summarise(runs[0]).speedup_vs_frustum, 1.0);
}

TEST(TimingDevice, CountsPollsAndChargesReadBacks)
{
    TinyStage tiny{wall_model()};
    double now = 0.0;
    TimingDevice device{tiny.renderer->device(), [&] { return now += 1.0; }};
    device.begin_frame(look_along_z());
    std::vector<float> depth(4);
    EXPECT_TRUE(device.read_depth({0, 0, 2, 2}, depth));
    EXPECT_EQ(device.polls(), 0u);
    device.poll(Ticket{});
    EXPECT_EQ(device.polls(), 1u);
    device.end_frame();
    EXPECT_DOUBLE_EQ(device.read_seconds(), 1.0);
    device.restart();
    EXPECT_EQ(device.polls(), 0u);
    EXPECT_DOUBLE_EQ(device.read_seconds(), 0.0);
}

TEST(CompareWithReferences, TheFastestFrustumIsToBeatAndTheOptOfTheSameTree)
{
    std::vector<AlgorithmRun> runs;
    const auto add = [&](const char* name, const char* hierarchy, double ms) {
        AlgorithmRun run{name, {}, std::vector<FrameFigures>(1), hierarchy};
        run.frames[0].frame_ms = ms;
        runs.push_back(run);
    };
    add("frustum", "bvh", 30.0);
    add("frustum", "grid", 20.0);
    add("chc", "bvh", 5.0);
    add("chc", "grid", 10.0);
    add("uniform_grid", "octree", 10.0);
    add("opt", "bvh", 5.0);
    add("opt", "grid", 2.0);
    compare_with_references(runs);
    EXPECT_DOUBLE_EQ(runs[0].frames[0].speedup_vs_frustum, 20.0 / 30.0);
    EXPECT_DOUBLE_EQ(runs[2].frames[0].speedup_vs_frustum, 4.0);
    EXPECT_DOUBLE_EQ(runs[2].frames[0].ratio_to_opt, 1.0);
    EXPECT_DOUBLE_EQ(runs[3].frames[0].ratio_to_opt, 5.0);
    EXPECT_DOUBLE_EQ(runs[4].frames[0].ratio_to_opt, 2.0) << "no opt on octree: the first";
    EXPECT_TRUE(on_several_hierarchies(runs));
    EXPECT_EQ(run_label(runs[3], true), "chc on grid");
    EXPECT_EQ(run_label(runs[3], false), "chc");
}

TEST(TimingDevice, ChargesWaitsAndVerbsByTheClock)
{
    TinyStage tiny{wall_model()};
    double now = 0.0;
    TimingDevice device{tiny.renderer->device(), [&] { return now += 1.0; }};
    const View view = look_along_z();
    device.begin_frame(view);
    const std::vector<ItemId> wall = {ItemId{0u}};
    device.draw(wall, DrawPass::shade);
    const std::vector<QueryBox> boxes = {
        {view.inflated_for_test(tiny.scene.scene.item_bounds()[1].box), nullptr, NodeId{0u}}};
    const std::vector<uint32_t> ends = {1};
    std::vector<Ticket> tickets(1);
    device.query({boxes, ends}, tickets);
    EXPECT_EQ(device.wait(tickets[0]).samples,
              0u); // hidden by the wall: the draw reached the device
    device.end_frame();
    EXPECT_DOUBLE_EQ(device.wait_seconds(), 1.0);
    EXPECT_DOUBLE_EQ(device.verb_seconds(), 5.0);
    device.restart();
    EXPECT_DOUBLE_EQ(device.verb_seconds(), 0.0);
}

namespace {

// Draws nothing and notes its name when it runs.
class NotingCuller final : public Culler {
public:
    NotingCuller(const Hierarchy& hierarchy, char name, std::string& notes)
        : Culler(hierarchy)
        , name_(name)
        , notes_(notes)
    {
    }

private:
    void cull_frame(CullFrame&) override { notes_ += name_; }
    void reset_state() override { notes_ += '|'; }

    char name_;
    std::string& notes_;
};

Contender noting(char name, std::string& notes)
{
    return {std::string{name},
            [name, &notes](const Hierarchy& hierarchy) -> Result<std::unique_ptr<Culler>> {
                return std::unique_ptr<Culler>{new NotingCuller{hierarchy, name, notes}};
            }};
}

std::vector<Contender> all_registered()
{
    std::vector<Contender> contenders;
    for (const AlgorithmInfo& info : algorithms()) {
        contenders.push_back(registered(info.name));
    }
    return contenders;
}

std::vector<View> small_walk()
{
    std::vector<View> views;
    for (int i = 0; i < 6; ++i) {
        views.push_back(look_along_z({0.2f * static_cast<float>(i), 0.0f, 0.0f}));
    }
    views.push_back(look_along_z({0.0f, 0.0f, -7.0f}));        // behind the wall: a jump
    views.push_back(look_along_z({0.0f, 0.0f, -7.0f}, 90.0f)); // ... and a turn
    return views;
}

} // namespace

TEST(Measure, InterleavesContendersFrameByFrameInRotatingOrderAndResetsThemForEveryRepeat)
{
    TinyStage tiny{wall_model()};
    std::string notes;
    const std::vector<Contender> contenders = {noting('a', notes), noting('b', notes),
                                               noting('c', notes)};
    const std::vector<View> views(3, look_along_z());
    const auto runs = measure(tiny.stage(), contenders, views, {.repeat = 2});
    ASSERT_TRUE(runs);
    const std::string timed = "|||abcbcacab"
                              "|||bcacababc";
    ASSERT_GE(notes.size(), timed.size());
    EXPECT_EQ(notes.substr(notes.size() - timed.size()), timed);
}

TEST(Measure, MedianOverRepeatsIsTheFigureOfAFrame)
{
    TinyStage tiny{wall_model()};
    std::string notes;
    const std::vector<View> views(1, look_along_z());
    // Every reading of the clock takes 1 ms more than the last one.
    double now = 0.0;
    double step = 0.0;
    const SecondsClock clock = [&] { return now += (step += 0.001); };
    const std::vector<Contender> contenders = {noting('a', notes)};
    const auto runs = measure(tiny.stage(), contenders, views, {.repeat = 3, .clock = clock});
    ASSERT_TRUE(runs);
    // A frame reads the clock at its start, twice per verb (begin_frame, end_frame), when culled
    // and at its stop: 7 times. Repeat r ends with reading 7 r + 7 and lasts readings 7 r + 2 to 7
    // r + 7. The middle repeat takes 9 + 10 + ... + 14 ms.
    EXPECT_NEAR((*runs)[0].frames[0].frame_ms, 69.0, 1e-9);
    EXPECT_DOUBLE_EQ((*runs)[0].frames[0].wait_ms, 0.0);
}

TEST(Measure, ReferencesCompareWithThemselvesAsOne)
{
    TinyStage tiny{wall_model()};
    const std::vector<View> views = small_walk();
    const auto runs = measure(tiny.stage(), all_registered(), views);
    ASSERT_TRUE(runs);
    for (const AlgorithmRun& run : *runs) {
        ASSERT_EQ(run.frames.size(), views.size());
        const Summary summary = summarise(run);
        EXPECT_GT(summary.frame_ms.median, 0.0) << run.algorithm;
        EXPECT_GE(summary.cull_cpu_ms, 0.0) << run.algorithm;
        EXPECT_FALSE(summary.verified) << "nothing was compared";
        if (run.algorithm == "frustum") {
            EXPECT_DOUBLE_EQ(summary.speedup_vs_frustum, 1.0);
            EXPECT_EQ(summary.total.queries, 0u);
        }
        if (run.algorithm == "opt") {
            EXPECT_DOUBLE_EQ(summary.ratio_to_opt, 1.0);
        }
        if (run.algorithm == "ideal") {
            EXPECT_DOUBLE_EQ(summary.ratio_to_ideal, 1.0);
            EXPECT_DOUBLE_EQ(summary.overdraw_items_vs_exact, 0.0);
        }
    }
}

TEST(Measure, FirstFrameOfTheWallCountsWhatFrustumDrawsInVain)
{
    TinyStage tiny{wall_model()};
    const std::vector<View> views = {look_along_z()};
    const std::vector<Contender> contenders = {registered("frustum"), registered("ideal")};
    const auto runs = measure(tiny.stage(), contenders, views);
    ASSERT_TRUE(runs);
    EXPECT_EQ((*runs)[0].frames[0].counters.items_drawn, 5u); // all but the one behind the camera
    EXPECT_EQ((*runs)[1].frames[0].counters.items_drawn, 3u); // the wall, before it, beside it
    EXPECT_DOUBLE_EQ((*runs)[0].frames[0].overdraw_items_vs_exact, 2.0 / 3.0);
}

TEST(Measure, TwoMeasurementsMakeTheSameDecisions)
{
    TinyStage tiny{wall_model()};
    const std::vector<View> views = small_walk();
    const auto first = measure(tiny.stage(), all_registered(), views);
    const auto second = measure(tiny.stage(), all_registered(), views, {.repeat = 2});
    ASSERT_TRUE(first && second);
    for (size_t i = 0; i < first->size(); ++i) {
        EXPECT_EQ(summarise((*first)[i]).decision_hash, summarise((*second)[i]).decision_hash)
            << (*first)[i].algorithm;
    }
}

TEST(Measure, SampledFramesAreWhatTheyAreOnTheWholeWalk)
{
    TinyStage tiny{wall_model()};
    const std::vector<View> views = small_walk();
    std::vector<Contender> contenders = all_registered();
    for (Contender& contender : contenders) {
        contender.remembers = find_algorithm(contender.name)->remembers;
    }
    const auto whole = measure(tiny.stage(), contenders, views);
    const auto sampled = measure(tiny.stage(), contenders, views, {.sample_every = 3});
    ASSERT_TRUE(whole && sampled);
    for (size_t i = 0; i < whole->size(); ++i) {
        const AlgorithmRun& run = (*sampled)[i];
        ASSERT_EQ(run.frames.size(), 2u); // the last frame of each three: 2 and 5 of 0 to 7
        for (const FrameFigures& figures : run.frames) {
            EXPECT_EQ(figures.frame % 3, 2u);
            const FrameFigures& same = (*whole)[i].frames[figures.frame];
            EXPECT_EQ(figures.decision_hash, same.decision_hash) << run.algorithm;
            EXPECT_EQ(figures.counters, same.counters) << run.algorithm;
        }
    }
}

TEST(Measure, FramesBetweenSamplesAreCulledOnlyByThoseWhoRemember)
{
    TinyStage tiny{wall_model()};
    std::string notes;
    std::vector<Contender> contenders = {noting('m', notes), noting('f', notes)};
    contenders[1].remembers = false;
    const std::vector<View> views(4, look_along_z());
    ASSERT_TRUE(measure(tiny.stage(), contenders, views, {.sample_every = 2}));
    const std::string timed = "||"
                              "mmfmfm"; // m alone, m f, m alone, f m: the order rotates
    EXPECT_EQ(notes.substr(notes.size() - timed.size()), timed);
}

TEST(Measure, ComparesTheImagesOfSomeMeasuredFrames)
{
    TinyStage tiny{wall_model()};
    const std::vector<Contender> contenders = {registered("frustum"), registered("chc"),
                                               registered("next_frame")};
    const auto runs = measure(tiny.stage(), contenders, small_walk(), {.verify_every = 3});
    ASSERT_TRUE(runs);
    for (const AlgorithmRun& run : *runs) {
        const Summary summary = summarise(run);
        EXPECT_TRUE(summary.verified);
        EXPECT_EQ(summary.compared_frames, 3u); // 0, 3 and 6 of 0 to 7
        EXPECT_FALSE(run.frames[1].verdict);
    }
    EXPECT_EQ(summarise((*runs)[1]).differing_pixels, 0u);
    EXPECT_GT(summarise((*runs)[2]).differing_pixels, 0u); // frame 6 is a jump
}

TEST(Measure, AContenderThatCannotBeMadeIsAnErrorThatSaysWhy)
{
    TinyStage tiny{wall_model()};
    const std::vector<View> views = {look_along_z()};
    const std::vector<Contender> contenders = {registered("no_such_algorithm")};
    const auto runs = measure(tiny.stage(), contenders, views);
    ASSERT_FALSE(runs);
    EXPECT_NE(runs.error().message.find("no_such_algorithm"), std::string::npos);
}

} // namespace occlude::tools
