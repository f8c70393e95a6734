// A culler makes the same calls on a recording as on the recorded device.
#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/cull/registry.h>
#include <occlude/device/recording_device.h>
#include <occlude/device/replay_device.h>

#include "support/box_scene.h"
#include "support/trees.h"
#include "support/walks.h"

#include <gtest/gtest.h>

#include <sstream>

namespace occlude {
namespace {

/// Knows its samples per pixel only after a frame has begun, as an OpenGL device does.
class LateCapsDevice final : public ForwardingDevice {
public:
    explicit LateCapsDevice(QueryDevice& inner)
        : ForwardingDevice(inner)
        , caps_(inner.caps())
    {
        caps_.samples_at_pixel_centers = false;
        caps_.us_per_item = 7.5f;
    }
    const DeviceCaps& caps() const override { return caps_; }
    void begin_frame(const View& view) override
    {
        caps_.samples_at_pixel_centers = true;
        inner().begin_frame(view);
    }

private:
    DeviceCaps caps_;
};

constexpr uint64_t kFrames = 12;

/// The items that each frame draws, in order.
std::vector<std::vector<ItemId>> walk(Culler& culler, QueryDevice& device)
{
    std::vector<std::vector<ItemId>> drawn;
    for (uint64_t frame = 0; frame < kFrames; ++frame) {
        culler.cull(test::rough_walk(frame), device);
        drawn.emplace_back(culler.drawn_items().begin(), culler.drawn_items().end());
    }
    return drawn;
}

Recording saved_and_loaded(const Recording& recording)
{
    std::stringstream file;
    EXPECT_TRUE(save_recording(recording, file));
    Result<Recording> loaded = load_recording(file);
    EXPECT_TRUE(loaded);
    return loaded ? std::move(*loaded) : Recording{};
}

class Replay : public testing::TestWithParam<std::string> {};

TEST_P(Replay, MakesTheSameDecisionsFromTheFile)
{
    const std::vector<ItemBounds> bounds = test::random_boxes(400, 11);
    const Hierarchy tree = test::random_bvh(400, 11);
    const test::BoxCpuScene scene(bounds);
    CpuDevice cpu(scene);
    LateCapsDevice late(cpu);
    RecordingDevice recorder(late);
    const auto culler = make_culler(GetParam(), tree);
    ASSERT_TRUE(culler);
    const auto drawn = walk(**culler, recorder);
    size_t total = 0;
    for (const std::vector<ItemId>& frame : drawn) {
        total += frame.size();
    }
    EXPECT_GT(total, kFrames) << "the walk sees something";

    ReplayDevice replay(saved_and_loaded(recorder.recording()));
    const auto again = make_culler(GetParam(), tree);
    ASSERT_TRUE(again);
    EXPECT_EQ(walk(**again, replay), drawn);
    EXPECT_TRUE(replay.complete()) << replay.mismatch();
    EXPECT_TRUE(replay.caps().samples_at_pixel_centers);
    EXPECT_EQ(replay.caps().us_per_item, 7.5f);
}

std::vector<std::string> algorithms_without_an_oracle()
{
    std::vector<std::string> names;
    for (const AlgorithmInfo& info : algorithms()) {
        if (!info.needs.visible_set) {
            names.push_back(info.name);
        }
    }
    return names;
}

INSTANTIATE_TEST_SUITE_P(Algorithms, Replay, testing::ValuesIn(algorithms_without_an_oracle()),
                         [](const auto& info) { return test::case_name(info.param, {}); });

} // namespace
} // namespace occlude
