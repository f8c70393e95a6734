// `adaptive` on devices with other costs than this machine's. On each it must keep up with the best
// algorithm for it, and never lose to frustum culling. The clock is that of the cost model.
#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/cull/frustum_culler.h>
#include <occlude/cull/registry.h>
#include <occlude/device/cost_model_device.h>
#include <occlude/hierarchy/builders/bvh_builder.h>

#include "support/box_scene.h"
#include "support/trees.h"

#include <occlude/core/rng.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

namespace occlude {
namespace {

constexpr glm::ivec2 kSize{192, 108};
constexpr uint32_t kTrianglesPerItem = 150;
constexpr int kLearningFrames = 8;
constexpr int kFrames = 60;

// Rows of houses along streets, with smaller boxes in the yards.
std::vector<ItemBounds> town()
{
    std::vector<ItemBounds> items;
    Rng rng{7};
    for (int x = -18; x < 18; ++x) {
        for (int z = -18; z < 18; ++z) {
            const glm::vec3 corner{10.0f * static_cast<float>(x), 0.0f,
                                   10.0f * static_cast<float>(z)};
            const float height = rng.range(5.0f, 12.0f);
            items.push_back(
                {{corner + glm::vec3{2.0f, 0.0f, 2.0f}, corner + glm::vec3{8.0f, height, 8.0f}},
                 kTrianglesPerItem});
            const glm::vec3 small =
                corner + glm::vec3{rng.range(0.5f, 1.5f), 0.0f, rng.range(0.5f, 9.0f)};
            items.push_back({{small, small + glm::vec3{0.4f, 1.0f, 0.4f}}, kTrianglesPerItem});
        }
    }
    return items;
}

View in_the_street(int frame)
{
    const float t = 0.5f * static_cast<float>(frame);
    return test::look({0.0f, 1.7f, 60.0f - t}, {8.0f, 1.7f, -100.0f - t}, kSize);
}

// Looks down from high above: nothing hides anything.
View from_above(int frame)
{
    const float t = 0.5f * static_cast<float>(frame);
    return test::look({t, 260.0f, 1.0f}, {t, 0.0f, 0.0f}, kSize);
}

// A walk through a town on a device with these costs: returns the seconds of each algorithm.
class Model {
public:
    explicit Model(const DeviceCosts& costs)
        : costs_(costs)
        , bounds_(town())
        , tree_(build_bvh(bounds_, {.leaf_triangles = 0}))
        , scene_(bounds_)
        , triangles_(bounds_.size(), kTrianglesPerItem)
    {
    }

    /// The seconds of all frames but the first ones, in which `adaptive` learns. Every image is
    /// compared with that of frustum culling.
    double seconds(const std::string& algorithm, View (*camera)(int),
                   std::vector<FrameReport>* reports = nullptr)
    {
        const std::vector<double> each = frame_seconds(algorithm, camera, kFrames, reports);
        return std::accumulate(each.begin() + kLearningFrames, each.end(), 0.0);
    }

    /// The seconds of each frame: of the frames above, and of `frames` more.
    std::vector<double> frame_seconds(const std::string& algorithm, View (*camera)(int), int frames,
                                      std::vector<FrameReport>* reports = nullptr)
    {
        CpuDevice cpu(scene_);
        CpuDevice reference_device(scene_);
        FrustumCuller reference{tree_};
        CostModelDevice device{cpu, costs_, triangles_};
        auto culler = make_culler(algorithm, tree_, {}, [&device] { return device.seconds(); });
        EXPECT_TRUE(culler);
        std::vector<double> each;
        for (int frame = 0; frame < kLearningFrames + frames; ++frame) {
            const double before = device.seconds();
            const FrameReport report = (*culler)->cull(camera(frame), device);
            each.push_back(device.seconds() - before);
            reference.cull(camera(frame), reference_device);
            EXPECT_TRUE(std::ranges::equal(cpu.depth(), reference_device.depth()))
                << algorithm << " frame " << frame;
            if (reports != nullptr) {
                reports->push_back(report);
            }
        }
        return each;
    }

private:
    DeviceCosts costs_;
    std::vector<ItemBounds> bounds_;
    Hierarchy tree_;
    test::BoxCpuScene scene_;
    std::vector<uint32_t> triangles_;
};

struct Profile {
    const char* name;
    DeviceCosts costs;
};

std::vector<Profile> profiles()
{
    DeviceCosts free_queries;
    free_queries.per_batch = 0.5;
    free_queries.per_test = 0.02;
    free_queries.per_box = 0.0;
    free_queries.latency = 0.0;
    free_queries.per_depth_read = 20000.0;
    DeviceCosts expensive_queries;
    expensive_queries.per_test = 400.0;
    DeviceCosts late_answers;
    late_answers.latency = 2000.0;
    late_answers.per_test = 2.0;
    DeviceCosts expensive_triangles;
    expensive_triangles.per_triangle = 2.0;
    DeviceCosts expensive_reads;
    expensive_reads.per_depth_read = 50000.0; // far too expensive to read depth
    return {{"free queries", free_queries},
            {"expensive queries", expensive_queries},
            {"late answers", late_answers},
            {"expensive triangles", expensive_triangles},
            {"expensive read-backs", expensive_reads}};
}

class AdaptiveCosts : public testing::TestWithParam<Profile> {};

TEST_P(AdaptiveCosts, KeepsUpWithTheBestFixedAlgorithmInAStreet)
{
    Model model(GetParam().costs);
    double best = model.seconds("frustum", in_the_street);
    const double frustum = best;
    std::string best_name = "frustum";
    for (const AlgorithmInfo& info : algorithms()) {
        if (!info.exact || info.needs.visible_set || info.name == "adaptive") {
            continue;
        }
        const double seconds = model.seconds(info.name, in_the_street);
        if (seconds < best) {
            best = seconds;
            best_name = info.name;
        }
    }
    std::vector<FrameReport> reports;
    const double adaptive = model.seconds("adaptive", in_the_street, &reports);
    RecordProperty("device", GetParam().name);
    RecordProperty("best", best_name);
    RecordProperty("time_of_best", std::to_string(adaptive / best));
    EXPECT_LE(adaptive, 1.10 * best)
        << "best is " << best_name << " at " << best << " s; frustum " << frustum
        << " s; adaptive: " << to_string(reports.back().plan);
    EXPECT_LT(best, 0.9 * frustum) << "the scene proves nothing";
}

TEST_P(AdaptiveCosts, LosesNothingToFrustumCullingWhereNothingIsHidden)
{
    Model model(GetParam().costs);
    const double frustum = model.seconds("frustum", from_above);
    std::vector<FrameReport> reports;
    EXPECT_LE(model.seconds("adaptive", from_above, &reports), 1.01 * frustum)
        << to_string(reports.back().plan);
}

// Nor does it make more than one frame in a hundred noticeably slower.
TEST_P(AdaptiveCosts, LeavesThe99thPercentileWhereNothingIsHidden)
{
    constexpr int kManyFrames = 300;
    const auto p99 = [](std::vector<double> each) {
        each.erase(each.begin(), each.begin() + kLearningFrames);
        const auto rank =
            static_cast<ptrdiff_t>(std::ceil(0.99 * static_cast<double>(each.size())));
        std::nth_element(each.begin(), each.begin() + rank - 1, each.end());
        return each[static_cast<size_t>(rank) - 1];
    };
    Model model(GetParam().costs);
    EXPECT_LE(p99(model.frame_seconds("adaptive", from_above, kManyFrames)),
              1.05 * p99(model.frame_seconds("frustum", from_above, kManyFrames)));
}

// No frame pays for more than one measurement of another method: a round of at most 16 tests, or
// one read-back.
TEST_P(AdaptiveCosts, MeasuresOneRoundOfOneMethodInAFrame)
{
    Model model(GetParam().costs);
    std::vector<FrameReport> reports;
    model.seconds("adaptive", in_the_street, &reports);
    size_t frames = 0;
    uint64_t queries = 0;
    for (const FrameReport& report : reports) {
        if (report.plan.kind == FramePlan::Kind::pyramid) { // any query is a measurement
            ++frames;
            queries += report.counters.queries;
            EXPECT_LE(report.counters.batches, 1u);
            EXPECT_LE(report.counters.queries, 16u);
        }
    }
    EXPECT_GT(frames, 0u);
    if (std::string_view{GetParam().name} == "late answers") {
        EXPECT_GT(queries, 16u) << "the scene proves nothing";
    }
}

// Read-backs pay here, and queries turn out to be better still. The culler keeps what it knows of
// the view.
TEST(AdaptiveMethods, AChangeOfMethodStartsFromTheCutOfTheOther)
{
    DeviceCosts costs;
    costs.per_batch = 0.5;
    costs.per_test = 0.5;
    costs.per_box = 0.0;
    costs.latency = 0.0;
    costs.per_depth_read = 2000.0;
    Model model(costs);
    std::vector<FrameReport> reports;
    model.seconds("adaptive", in_the_street, &reports);
    const auto changed = std::ranges::find(reports, FramePlan::Kind::queries,
                                           [](const FrameReport& r) { return r.plan.kind; });
    ASSERT_NE(changed, reports.end());
    ASSERT_GT(changed - reports.begin(), 2);
    EXPECT_EQ((changed - 1)->plan.kind, FramePlan::Kind::pyramid);
    // No single measurement decides: three rounds of each of three kinds are needed.
    EXPECT_EQ(std::count_if(reports.begin(), changed,
                            [](const FrameReport& r) { return r.counters.queries > 0; }),
              9);
    EXPECT_LE(changed->counters.items_drawn, 2 * (changed - 1)->counters.items_drawn);
    EXPECT_TRUE(std::none_of(changed, reports.end(), [](const FrameReport& r) {
        return r.plan.kind == FramePlan::Kind::draw_all;
    }));
}

INSTANTIATE_TEST_SUITE_P(Devices, AdaptiveCosts, testing::ValuesIn(profiles()),
                         [](const auto& info) {
                             std::string name = info.param.name;
                             std::erase_if(name, [](char c) { return c == ' ' || c == '-'; });
                             return name;
                         });

} // namespace
} // namespace occlude
