#include "device_test_helpers.h"

#include <occlude/device/recording_device.h>
#include <occlude/device/replay_device.h>
#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

#include <sstream>

namespace occlude {
namespace {

using test::ask;
using test::ask_batch;
using test::draw;

/// Makes two frames with every verb, and returns the answers to the caller as text.
std::string run(QueryDevice& device, uint32_t first_item = 0)
{
    std::ostringstream learned;
    const auto note = [&](const Answer& answer) {
        learned << static_cast<int>(answer.state) << ":" << answer.samples << " ";
    };
    device.begin_frame(test::camera());
    draw(device, {first_item, 1});
    auto tickets = ask_batch(device, {{7}, {8, 9}});
    device.flush();
    note(device.poll(tickets[0]));
    note(device.poll(tickets[0]));
    note(device.wait(tickets[0]));
    const glm::mat4 turned = glm::rotate(glm::mat4{1.0f}, 0.25f, glm::vec3{0.0f, 0.0f, 1.0f});
    QueryBox box = test::box_of(3);
    box.world_from_box = &turned;
    note(device.wait(ask(device, std::span{&box, 1})));
    note(device.wait(device.draw_and_query(test::items({2}), DrawPass::shade)));
    std::array<float, 4> depth{};
    learned << device.read_depth({0, 0, 2, 2}, depth) << depth[0] << depth[3] << " ";
    learned << device.read_depth_tiles(32, depth) << depth[0] << depth[3] << " ";
    device.end_frame();
    device.begin_frame(test::camera());
    note(device.wait(tickets[1]));
    device.end_frame();
    return learned.str();
}

ScriptedDevice scripted_device()
{
    return ScriptedDevice({.boxes = visible_subjects({NodeId{7u}, NodeId{3u}}, 123),
                           .latency = [](uint64_t) { return Latency::after_polls(1); },
                           .depth =
                               [](const PixelRect&, std::span<float> out) {
                                   for (size_t i = 0; i < out.size(); ++i) {
                                       out[i] = static_cast<float>(i) * 0.25f;
                                   }
                                   return true;
                               },
                           .caps = {.name = "scripted \xc3\xa9",
                                    .draw_and_query = true,
                                    .read_depth = true,
                                    .max_outstanding = 17,
                                    .methods = {{TestMethod::raster, 1.0f, 2.0f, 3.0f, false},
                                                {TestMethod::queries, 1.0f, 2.0f, 4.0f}},
                                    .depth_reads = {{.tile_px = 32}}}});
}

Recording record(uint32_t first_item = 0)
{
    ScriptedDevice scripted = scripted_device();
    RecordingDevice device(scripted);
    run(device, first_item);
    return device.recording();
}

std::string saved(const Recording& recording)
{
    std::ostringstream out;
    EXPECT_TRUE(save_recording(recording, out));
    return out.str();
}

TEST(RecordingDevice, DoesNotChangeWhatTheCallerLearns)
{
    ScriptedDevice plain = scripted_device();
    ScriptedDevice wrapped = scripted_device();
    RecordingDevice device(wrapped);
    EXPECT_EQ(run(device), run(plain));
    EXPECT_EQ(wrapped.trace_text(), plain.trace_text());
}

TEST(RecordingDevice, TheHashFollowsTheCallsAndTheAnswers)
{
    const Recording recording = record();
    EXPECT_EQ(recording.hash(), record().hash());
    EXPECT_NE(recording.hash(), record(5).hash());
    Recording changed = recording;
    changed.calls[4].answer.samples ^= 1;
    EXPECT_NE(recording.hash(), changed.hash());
}

TEST(RecordingDevice, TheHashIsTheSameOnEveryMachine)
{
    ScriptedDevice scripted({.boxes = visible_subjects({NodeId{7u}}, 123)});
    RecordingDevice device(scripted);
    device.begin_frame(View{});
    draw(device, {3, 4});
    device.wait(ask(device, {7, 8}));
    device.end_frame();
    EXPECT_EQ(device.recording().hash(), 2392106025691983787ull);
}

TEST(RecordingDevice, SurvivesSavingAndLoading)
{
    const Recording recording = record();
    std::istringstream in(saved(recording));
    const Result<Recording> loaded = load_recording(in);
    ASSERT_TRUE(loaded) << loaded.error().message;
    EXPECT_EQ(loaded->hash(), recording.hash());
    EXPECT_EQ(loaded->caps.name, recording.caps.name);
    EXPECT_EQ(loaded->caps.max_outstanding, 17u);
    ASSERT_EQ(loaded->caps.methods.size(), 2u);
    EXPECT_EQ(loaded->caps.methods[0].us_per_box, 3.0f);
    EXPECT_FALSE(loaded->caps.methods[0].exact_counts);
    EXPECT_TRUE(loaded->caps.methods[1].exact_counts);
    EXPECT_EQ(saved(*loaded), saved(recording));
}

// A camera 1e7 units away. It differs from its neighbour in the origin only, because the matrix to
// world coordinates has no bit left for that.
TEST(RecordingDevice, KeepsAllThatAViewIsMadeOf)
{
    const glm::mat4 clip = glm::perspectiveRH_ZO(1.0f, 1.5f, 0.1f, 100.0f);
    const glm::dvec3 origin{1e7 + 0.25, -3e6, 2e6 + 0.125};
    const ClipConvention convention{DepthRange::zero_to_one, DepthOrder::near_is_small};
    const ViewOptions options{
        .viewport_origin_px = {7, -9}, .tag = 0x123456789abcdefull, .ignores_near_plane = true};
    const View view = View::camera_relative(clip, origin, {48, 32}, convention, options);
    ScriptedDevice scripted;
    RecordingDevice device(scripted);
    device.begin_frame(view);
    device.end_frame();
    std::istringstream in(saved(device.recording()));
    const Result<Recording> loaded = load_recording(in);
    ASSERT_TRUE(loaded) << loaded.error().message;
    const RecordedCall& call = loaded->calls.front();
    EXPECT_EQ(call.clip_from_world, view.clip_from_world());
    EXPECT_EQ(call.clip_from_relative, view.clip_from_relative());
    EXPECT_EQ(call.origin, origin);
    EXPECT_EQ(call.size_px, (glm::ivec2{48, 32}));
    EXPECT_EQ(call.convention, convention);
    EXPECT_EQ(call.view_options, options);

    const auto replayed = [&](const View& another) {
        ReplayDevice replay(*loaded);
        replay.begin_frame(another);
        return replay.mismatch().empty();
    };
    EXPECT_TRUE(replayed(view));
    ViewOptions other = options;
    other.tag ^= 1;
    EXPECT_FALSE(replayed(View::camera_relative(clip, origin, {48, 32}, convention, other)));
    other = options;
    other.viewport_origin_px.y = 9;
    EXPECT_FALSE(replayed(View::camera_relative(clip, origin, {48, 32}, convention, other)));
    const glm::dvec3 beside = origin + glm::dvec3{0.125, 0.0, 0.0};
    EXPECT_FALSE(replayed(View::camera_relative(clip, beside, {48, 32}, convention, options)));
}

TEST(RecordingDevice, BrokenFilesAreErrorsWhereverTheyBreak)
{
    const std::string good = saved(record());
    for (size_t i = 0; i < good.size(); ++i) {
        std::string changed = good;
        changed[i] = static_cast<char>(changed[i] ^ 0x40);
        std::istringstream in(changed);
        ASSERT_FALSE(load_recording(in)) << "byte " << i << " changed";
        std::istringstream cut(good.substr(0, i));
        const Result<Recording> result = load_recording(cut);
        ASSERT_FALSE(result) << "cut at " << i;
        ASSERT_EQ(result.error().code, ErrorCode::bad_data);
    }
}

TEST(RecordingDevice, AFileWithAValidChecksumOverNonsenseIsAnError)
{
    const std::string good = saved(record());
    size_t refused = 0;
    for (size_t i = 8; i + 8 < good.size(); ++i) {
        std::string changed = good.substr(0, good.size() - 8);
        changed[i] = static_cast<char>(0xee);
        uint64_t hash = 0xcbf29ce484222325ull;
        for (const char c : changed) {
            hash = (hash ^ static_cast<uint8_t>(c)) * 0x100000001b3ull;
        }
        for (int byte = 0; byte < 8; ++byte) {
            changed.push_back(static_cast<char>(hash >> (8 * byte) & 0xff));
        }
        std::istringstream in(changed);
        const Result<Recording> result = load_recording(in);
        refused += result ? 0 : 1;
        if (!result) {
            ASSERT_NE(result.error().message.find("invalid calls"), std::string::npos);
        }
    }
    EXPECT_GT(refused, 50u) << "counts and enums are checked; plain numbers may be anything";
}

TEST(RecordingDevice, AFailedStreamIsAnError)
{
    std::ostringstream out;
    out.setstate(std::ios::badbit);
    EXPECT_FALSE(save_recording(record(), out));
}

TEST(ReplayDevice, TheSameCallsGetTheSameAnswers)
{
    ScriptedDevice scripted = scripted_device();
    RecordingDevice recorder(scripted);
    const std::string learned = run(recorder);
    ReplayDevice replay(recorder.recording());
    EXPECT_EQ(run(replay), learned);
    EXPECT_TRUE(replay.complete()) << replay.mismatch();
    EXPECT_EQ(replay.caps().name, scripted.caps().name);
}

TEST(ReplayDevice, ADifferentCallIsReportedAndEverythingAfterItIsLost)
{
    ReplayDevice replay(record());
    const std::string learned = run(replay, 5);
    EXPECT_FALSE(replay.complete());
    EXPECT_EQ(replay.mismatch(), "call 1, draw: the recorded one has other arguments");
    EXPECT_EQ(learned.find("1:123"), std::string::npos);
    EXPECT_EQ(learned.find(":0 "), std::string::npos) << "nothing counts as hidden";
}

TEST(ReplayDevice, AnotherVerbAndTheEndOfTheRecordingAreReported)
{
    ReplayDevice other(record());
    other.begin_frame(test::camera());
    other.flush();
    EXPECT_EQ(other.mismatch(), "call 1, flush: the recording has draw here");

    ReplayDevice ended(Recording{});
    ended.flush();
    EXPECT_EQ(ended.mismatch(), "call 0, flush: the recording has ended");
}

TEST(ReplayDevice, ASpentTicketIsLostAsItWasWhenRecorded)
{
    ScriptedDevice scripted;
    RecordingDevice recorder(scripted);
    const auto spend_twice = [](QueryDevice& device) {
        device.begin_frame(test::camera());
        const Ticket ticket = ask(device, {1});
        EXPECT_EQ(device.wait(ticket).state, AnswerState::ready);
        EXPECT_EQ(device.wait(ticket).state, AnswerState::lost);
    };
    spend_twice(recorder);
    ReplayDevice replay(recorder.recording());
    spend_twice(replay);
    EXPECT_TRUE(replay.complete()) << replay.mismatch();
}

} // namespace
} // namespace occlude
