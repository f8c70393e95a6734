// Stored runs in tests/data/recordings/: each must repeat bit by bit. There is one for each way of
// using a device (queries, late and lost answers, depth, the boxes of a pyramid, an eye between two
// floats) and each family of algorithms.
#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/cull/registry.h>
#include <occlude/device/delaying_device.h>
#include <occlude/device/recording_device.h>
#include <occlude/device/replay_device.h>

#include "support/box_scene.h"
#include "support/source_dir.h"
#include "support/trees.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <string_view>

namespace occlude {
namespace {

constexpr uint32_t kItems = 40;
constexpr uint64_t kSeed = 17;
constexpr glm::ivec2 kSize{16, 12};
constexpr int kFrames = 4;

enum class Answers : uint8_t { at_once, late_and_lost };

struct Stored {
    const char* name; ///< of the file, and of the test
    const char* algorithm;
    TestMethod method = TestMethod::queries;
    Answers answers = Answers::at_once;
    double distance = 0.0; ///< of the scene from zero
};

constexpr Stored kStored[]{
    {"frustum", "frustum"},
    {"stop_and_wait", "stop_and_wait"},
    {"chc", "chc"},
    {"chc_late", "chc", TestMethod::queries, Answers::late_and_lost},
    {"chc_plus_plus", "chc_plus_plus"},
    {"chc_plus_plus_late", "chc_plus_plus", TestMethod::queries, Answers::late_and_lost},
    {"chc_plus_plus_pyramid", "chc_plus_plus", TestMethod::pyramid},
    {"next_frame_late", "next_frame", TestMethod::queries, Answers::late_and_lost},
    {"statistical", "statistical"},
    {"two_level", "two_level"},
    {"batch_and_wait", "batch_and_wait"},
    {"prioritized", "prioritized"},
    {"adaptive_pyramid", "adaptive", TestMethod::pyramid},
    {"uniform_grid", "uniform_grid"},
    {"lazy_grid_depth", "lazy_grid"},
    {"two_phase_depth", "two_phase"},
    {"two_phase_far_away", "two_phase", TestMethod::queries, Answers::at_once, 1e7},
    {"stop_and_wait_far_away", "stop_and_wait", TestMethod::queries, Answers::at_once, 1e7},
};

/// Boxes whose corners are whole numbers, so that 1e7 units away they are the same. The first three
/// are walls that hide about half of the others.
std::vector<ItemBounds> boxes(double distance)
{
    std::vector<ItemBounds> items = test::random_boxes(kItems, kSeed, 40.0f, 12.0f);
    items[0].box = {{-30.0f, -30.0f, 8.0f}, {4.0f, 30.0f, 10.0f}};
    items[1].box = {{6.0f, -20.0f, -10.0f}, {30.0f, 20.0f, -9.0f}};
    items[2].box = {{-12.0f, -12.0f, -26.0f}, {12.0f, 12.0f, -25.0f}};
    const glm::dvec3 offset{distance, -0.5 * distance, 0.25 * distance};
    for (ItemBounds& item : items) {
        item.box = {glm::vec3{glm::dvec3{glm::floor(item.box.min)} + offset},
                    glm::vec3{glm::dvec3{glm::ceil(item.box.max)} + offset}};
    }
    return items;
}

/// A slow walk along the walls, with a jump before the last frame. No sine and no cosine: their
/// last bits differ from one C library to another.
View camera(int frame, double distance)
{
    const double step = frame < kFrames - 1 ? 0.75 * frame : 20.0;
    const glm::dvec3 eye = glm::dvec3{distance, -0.5 * distance, 0.25 * distance} +
                           glm::dvec3{step - 2.0, 1.25, 52.0 - 0.5 * step};
    glm::dmat4 clip{0.0}; // near 0.25, far 128, about 78 degrees high
    clip[0][0] = 0.875;
    clip[1][1] = 1.25;
    clip[2][2] = -(128.0 + 0.25) / (128.0 - 0.25);
    clip[2][3] = -1.0;
    clip[3][2] = -2.0 * 128.0 * 0.25 / (128.0 - 0.25);
    return View::camera_relative(glm::mat4{clip}, eye, kSize);
}

/// The items that all frames drew, in order.
std::vector<ItemId> walk(const Stored& stored, const Hierarchy& tree, QueryDevice& device)
{
    const auto culler = make_culler(stored.algorithm, tree);
    EXPECT_TRUE(culler);
    std::vector<ItemId> drawn;
    for (int frame = 0; frame < kFrames; ++frame) {
        (*culler)->cull(camera(frame, stored.distance), device);
        drawn.insert(drawn.end(), (*culler)->drawn_items().begin(), (*culler)->drawn_items().end());
    }
    return drawn;
}

Recording record(const Stored& stored, std::span<const ItemBounds> items, const Hierarchy& tree)
{
    const test::BoxCpuScene scene(items);
    CpuDevice cpu(scene);
    EXPECT_TRUE(cpu.use_method(stored.method));
    DelayingDevice late(cpu, {.seed = 4, .max_polls = 30, .max_frames = 2, .lose_every = 5});
    RecordingDevice recorder(stored.answers == Answers::at_once ? static_cast<QueryDevice&>(cpu)
                                                                : late);
    walk(stored, tree, recorder);
    return recorder.recording();
}

class StoredRecordings : public testing::TestWithParam<Stored> {};

TEST_P(StoredRecordings, RepeatBitByBit)
{
    const Stored& stored = GetParam();
    const std::string path = source_dir() + "/tests/data/recordings/" + stored.name + ".rec";
    const std::vector<ItemBounds> items = boxes(stored.distance);
    const Hierarchy tree = build_bvh(items, {.leaf_triangles = 300});
    if (std::getenv("OCCLUDE_WRITE_RECORDINGS") != nullptr) {
        std::ofstream out{path, std::ios::binary};
        ASSERT_TRUE(save_recording(record(stored, items, tree), out));
    }
    std::ifstream in{path, std::ios::binary};
    ASSERT_TRUE(in) << path;
    const Result<Recording> loaded = load_recording(in);
    ASSERT_TRUE(loaded) << loaded.error().message;
    EXPECT_LT(std::filesystem::file_size(path), 40u * 1024u);
    ReplayDevice device(*loaded);
    const std::vector<ItemId> drawn = walk(stored, tree, device);
    EXPECT_TRUE(device.complete()) << device.mismatch();
    // The walk is evidence if something is drawn and something in the frustum is not.
    EXPECT_GT(drawn.size(), 3u * kFrames);
    const test::BoxCpuScene scene(items);
    CpuDevice cpu(scene);
    const size_t in_frustum = walk({"", "frustum", {}, {}, stored.distance}, tree, cpu).size();
    // Algorithms whose defaults cull little in so small a scene may draw everything.
    constexpr std::array<std::string_view, 4> kMayDrawAll{"frustum", "prioritized", "adaptive",
                                                          "uniform_grid"};
    const bool may_draw_all =
        stored.method == TestMethod::pyramid || // a pyramid over 16x12 pixels hides little
        std::ranges::find(kMayDrawAll, stored.algorithm) != kMayDrawAll.end();
    EXPECT_TRUE(may_draw_all ? drawn.size() <= in_frustum : drawn.size() < in_frustum)
        << drawn.size() << " of " << in_frustum;
}

// The algorithms issue the recorded tests again, and a real device gives the recorded answers.
TEST_P(StoredRecordings, AreWhatTheDeviceAnswersToday)
{
    const Stored& stored = GetParam();
    std::ifstream in{source_dir() + "/tests/data/recordings/" + stored.name + ".rec",
                     std::ios::binary};
    const Result<Recording> loaded = load_recording(in);
    ASSERT_TRUE(loaded) << loaded.error().message;
    const std::vector<ItemBounds> items = boxes(stored.distance);
    const Hierarchy tree = build_bvh(items, {.leaf_triangles = 300});
    EXPECT_EQ(record(stored, items, tree).hash(), loaded->hash());
}

INSTANTIATE_TEST_SUITE_P(Every, StoredRecordings, testing::ValuesIn(kStored),
                         [](const auto& info) { return std::string{info.param.name}; });

} // namespace
} // namespace occlude
