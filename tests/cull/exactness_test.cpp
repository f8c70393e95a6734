// Invariant I6: the image of an exact algorithm equals that of drawing everything in the frustum,
// pixel by pixel, on the exact CPU device: with teleports, turns, moving items, odd sizes and every
// clip convention. (Each algorithm with its options: exactness_of_each_test.cpp.)
#include <occlude/cull/oracle_cullers.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include "cull/exactness.h"

#include <gtest/gtest.h>

#include <set>

namespace occlude {
namespace {

using namespace test::exactness;

TEST(Exactness, OnEveryHierarchy)
{
    for (const HierarchyKind& kind : hierarchy_kinds()) {
        for (const AlgorithmInfo& info : algorithms()) {
            const bool has_own_cells = info.name == "uniform_grid"; // nodes are not used
            if (culls_exactly(info) && !has_own_cells) {
                SCOPED_TRACE(info.name + " on " + std::string{kind.name});
                expect_exact({.algorithm = info.name, .hierarchy = kind.name});
                expect_exact({.algorithm = info.name, .moving = true, .hierarchy = kind.name});
            }
        }
    }
}

TEST(Exactness, WithTestsAnsweredByTheDepthPyramid)
{
    for (const AlgorithmInfo& info : algorithms()) {
        if (culls_exactly(info) && !info.needs.depth_read) {
            SCOPED_TRACE(info.name);
            std::vector<OptionValue> options;
            if (info.name == "uniform_grid") {
                options.emplace_back("cell_triangles",
                                     "100"); // by default three cells hold everything
            }
            expect_exact(
                {.algorithm = info.name, .options = options, .method = TestMethod::pyramid});
            expect_exact({.algorithm = info.name,
                          .options = options,
                          .moving = true,
                          .method = TestMethod::pyramid});
        }
    }
    expect_exact({.algorithm = "chc_plus_plus",
                  .convention = {DepthRange::zero_to_one, DepthOrder::near_is_large},
                  .method = TestMethod::pyramid});
}

TEST(Exactness, InEveryClipConvention)
{
    for (const DepthRange range : {DepthRange::minus_one_to_one, DepthRange::zero_to_one}) {
        for (const DepthOrder order : {DepthOrder::near_is_small, DepthOrder::near_is_large}) {
            expect_exact({.algorithm = "chc_plus_plus", .convention = {range, order}});
            expect_exact({.algorithm = "two_phase", .convention = {range, order}});
            expect_exact({.algorithm = "adaptive", .convention = {range, order}});
        }
    }
}

TEST(Exactness, AtOtherSizes)
{
    expect_exact({.algorithm = "chc_plus_plus", .size = {320, 180}});
    expect_exact({.algorithm = "stop_and_wait", .size = {67, 211}});
    expect_exact({.algorithm = "two_phase", .size = {67, 211}});
    expect_exact({.algorithm = "adaptive", .size = {67, 211}});
    expect_exact({.algorithm = "two_phase", .size = {256, 128}});
}

TEST(Exactness, WhileEverythingMoves)
{
    expect_exact({.algorithm = "stop_and_wait", .moving = true});
    expect_exact({.algorithm = "chc", .moving = true});
    expect_exact({.algorithm = "chc_plus_plus", .moving = true});
    expect_exact({.algorithm = "two_phase", .moving = true});
    expect_exact({.algorithm = "statistical", .moving = true});
    expect_exact({.algorithm = "lazy_grid", .moving = true});
    expect_exact({.algorithm = "adaptive", .moving = true});
}

TEST(Exactness, WithLateAndLostAnswers)
{
    expect_exact({.algorithm = "chc", .late_answers = true});
    expect_exact({.algorithm = "chc_plus_plus", .late_answers = true});
    expect_exact({.algorithm = "statistical", .late_answers = true});
    expect_exact(
        {.algorithm = "statistical", .options = {{"results", "oldest"}}, .late_answers = true});
}

TEST(Exactness, WithTranslucentAndOtherFlaggedItems)
{
    for (const AlgorithmInfo& info : algorithms()) {
        if (culls_exactly(info)) {
            SCOPED_TRACE(info.name);
            expect_exact({.algorithm = info.name, .flags = true});
        }
    }
    const std::vector<OptionValue> geometry{{"visible_test", "geometry"}};
    expect_exact({.algorithm = "chc", .options = geometry, .flags = true});
    const std::vector<OptionValue> depth_only{{"depth_only_pass", "true"}};
    expect_exact({.algorithm = "chc_plus_plus", .options = depth_only, .flags = true});
}

TEST(Exactness, ARebuiltHierarchyStartsAfresh)
{
    BoxScene scene(test::random_boxes(300, 32, 24.0f, 7.0f));
    Hierarchy tree = build_bvh(scene.bounds, {.leaf_triangles = 24});
    CpuDevice device(scene);
    CpuDevice reference_device(scene);
    auto culler = make_culler("chc_plus_plus", tree);
    for (uint64_t frame = 0; frame < 12; ++frame) {
        if (frame == 6) {
            tree =
                build_bvh(scene.bounds, {.leaf_triangles = 60}); // other node ids in the same place
        }
        const View view = camera(frame, {161, 89});
        const FrameReport report = (*culler)->cull(view, device);
        FrustumCuller reference{tree};
        reference.cull(view, reference_device);
        ASSERT_EQ(picture_of(device), picture_of(reference_device)) << "frame " << frame;
        EXPECT_EQ(report.frame, frame % 6); // counting starts again at the rebuild
    }
}

TEST(Exactness, TheOraclesDrawTheSamePicture)
{
    BoxScene scene(test::random_boxes(500, 33, 24.0f, 7.0f));
    for (size_t i = 0; i < scene.bounds.size(); i += 29) {
        scene.bounds[i].flags = ItemFlags::translucent;
    }
    const Hierarchy tree = build_bvh(scene.bounds, {.leaf_triangles = 24});
    CpuDevice device(scene);
    CpuDevice reference_device(scene);
    FrustumCuller reference{tree};
    size_t drawn_by_opt = 0;
    for (const std::string name : {"opt", "ideal"}) {
        auto culler = make_culler(name, tree);
        auto& oracle = dynamic_cast<OracleCuller&>(**culler);
        size_t drawn = 0;
        for (uint64_t frame = 0; frame < 10; ++frame) {
            const View view = camera(frame, {161, 89});
            reference.cull(view, reference_device);
            const Picture expected = picture_of(reference_device);
            std::set<ItemId> owners;
            for (const CpuDevice::Owner& owner : expected.owners) {
                if (owner.item.valid()) {
                    owners.insert(owner.item);
                }
            }
            const std::vector<ItemId> list(owners.begin(), owners.end());
            oracle.record(view, device, list);
            const FrameReport report = oracle.cull(view, device);
            ASSERT_EQ(picture_of(device), expected) << name << ", frame " << frame;
            EXPECT_EQ(report.counters.queries, 0u);
            if (name == "ideal") {
                EXPECT_GE(oracle.drawn_items().size(), list.size()); // and translucent ones
            }
            drawn += oracle.drawn_items().size();
        }
        if (name == "opt") {
            drawn_by_opt = drawn;
        } else {
            EXPECT_LT(drawn, drawn_by_opt); // boxes are looser than what they bound
        }
    }
}

TEST(Exactness, OptDrawsWhatStopAndWaitDraws)
{
    BoxScene scene(test::random_boxes(500, 34, 24.0f, 7.0f));
    // Inner nodes have items, too.
    const Hierarchy tree = find_hierarchy_kind("bsp")->build(scene.bounds, 24);
    CpuDevice device(scene);
    auto stop_and_wait = make_culler("stop_and_wait", tree);
    auto opt = make_culler("opt", tree);
    auto& oracle = dynamic_cast<OracleCuller&>(**opt);
    for (uint64_t frame = 0; frame < 5; ++frame) {
        const View view = camera(frame, {161, 89});
        (*stop_and_wait)->cull(view, device);
        oracle.record(view, device, {});
        oracle.cull(view, device);
        EXPECT_TRUE(std::ranges::equal((*stop_and_wait)->drawn_items(), oracle.drawn_items()));
    }
}

} // namespace
} // namespace occlude
