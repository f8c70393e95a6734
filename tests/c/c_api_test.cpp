// Every algorithm makes the same decisions through the C interface as in C++. The C interface
// refuses invalid arguments with a sentence.
#include "c/c_fixture.h"

#include <occlude/cull/oracle_cullers.h>
#include <occlude/cull/registry.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace occlude {
namespace {

class SameInC : public testing::TestWithParam<std::string> {};

TEST_P(SameInC, AnAlgorithmDrawsTheSameItemsWithTheSameCounters)
{
    const std::vector<ItemBounds> bounds = test::random_boxes(400, 3);
    const std::vector<occlude_item> items = in_c(bounds);
    const test::BoxCpuScene scene{bounds};
    const Hierarchy tree = find_hierarchy_kind("bvh")->build(bounds, 24);
    CpuDevice device{scene};
    auto culler = make_culler(GetParam(), tree);
    ASSERT_TRUE(culler);

    const HierarchyInC tree_in_c{items};
    // Without a clock from the caller, "adaptive" uses the system's.
    std::vector<occlude_option> options;
    if (GetParam() == "adaptive") {
        options.push_back({"measure", "false"});
    }
    const CullerInC culler_in_c{GetParam(), tree_in_c, options};
    DeviceInC device_in_c{scene};
    uint64_t in_all = 0;
    uint64_t drawn = 0;
    for (uint64_t frame = 0; frame < 12; ++frame) {
        const View view = test::rough_walk(frame);
        const occlude_view view_in_c = in_c(view);
        if (auto* oracle = dynamic_cast<OracleCuller*>(culler->get())) {
            const std::vector<ItemId> owners{ItemId{1u}, ItemId{5u}};
            const std::vector<uint32_t> owners_in_c{1, 5};
            oracle->record(view, device, owners);
            ASSERT_EQ(occlude_culler_record(culler_in_c.culler, &view_in_c, &device_in_c.functions,
                                            owners_in_c.data(), owners_in_c.size()),
                      OCCLUDE_OK);
        }
        const FrameReport report = (*culler)->cull(view, device);
        occlude_report report_in_c{};
        report_in_c.struct_size = sizeof report_in_c;
        ASSERT_EQ(occlude_culler_cull(culler_in_c.culler, &view_in_c, &device_in_c.functions,
                                      &report_in_c),
                  OCCLUDE_OK)
            << occlude_last_error();

        std::vector<uint32_t> expected;
        for (const ItemId item : (*culler)->drawn_items()) {
            expected.push_back(item.value);
        }
        ASSERT_EQ(culler_in_c.drawn(), expected) << "frame " << frame;
        EXPECT_EQ(report_in_c.queries, report.counters.queries);
        EXPECT_EQ(report_in_c.nodes_visited, report.counters.nodes_visited);
        EXPECT_EQ(report_in_c.triangles_drawn, report.counters.triangles_drawn);
        EXPECT_EQ(report_in_c.depth_reads, report.counters.depth_reads);
        EXPECT_EQ(report_in_c.guarantee, static_cast<uint32_t>(report.guarantee.kind));
        in_all += bounds.size();
        drawn += report.counters.items_drawn;
    }
    EXPECT_GT(drawn, 0u);
    EXPECT_LT(drawn, in_all) << "nothing was culled: this is no evidence";
}

std::vector<std::string> names_of_algorithms()
{
    std::vector<std::string> names;
    for (const AlgorithmInfo& info : algorithms()) {
        names.push_back(info.name);
    }
    return names;
}

INSTANTIATE_TEST_SUITE_P(Every, SameInC, testing::ValuesIn(names_of_algorithms()),
                         [](const auto& info) { return info.param; });

TEST(CApi, ListsWhatTheRegistryLists)
{
    ASSERT_EQ(occlude_algorithm_count(), algorithms().size());
    for (size_t i = 0; i < algorithms().size(); ++i) {
        occlude_algorithm algorithm{};
        ASSERT_EQ(occlude_algorithm_at(i, &algorithm), OCCLUDE_OK);
        EXPECT_EQ(algorithm.name, algorithms()[i].name);
        EXPECT_EQ(algorithm.exact != 0, algorithms()[i].exact);
    }
    occlude_algorithm algorithm{};
    EXPECT_EQ(occlude_algorithm_at(1000, &algorithm), OCCLUDE_INVALID_ARGUMENT);
    ASSERT_EQ(occlude_hierarchy_kind_count(), hierarchy_kinds().size());
    EXPECT_STREQ(occlude_hierarchy_kind_at(0), "bvh");
    EXPECT_EQ(occlude_hierarchy_kind_at(1000), nullptr);
    EXPECT_EQ(occlude_abi_version(), OCCLUDE_C_ABI_VERSION);
}

TEST(CApi, ARefitMovesItems)
{
    std::vector<ItemBounds> bounds = test::random_boxes(50, 1);
    std::vector<occlude_item> items = in_c(bounds);
    const HierarchyInC hierarchy{items};
    const CullerInC culler{"frustum", hierarchy};
    const test::BoxCpuScene scene{bounds};
    DeviceInC device{scene};
    const occlude_view view = in_c(test::look_ahead());

    for (occlude_item& item : items) { // behind the camera
        item.min[2] = 50.0f;
        item.max[2] = 51.0f;
    }
    ASSERT_EQ(occlude_hierarchy_refit(hierarchy.tree, items.data(), items.size()), OCCLUDE_OK);
    ASSERT_EQ(occlude_culler_cull(culler.culler, &view, &device.functions, nullptr), OCCLUDE_OK);
    EXPECT_TRUE(culler.drawn().empty());

    items[7] = {{-1, -1, -9}, {1, 1, -8}, 12, 0}; // ahead
    const uint32_t moved = 7;
    ASSERT_EQ(occlude_hierarchy_refit_moved(hierarchy.tree, &moved, 1, items.data(), items.size()),
              OCCLUDE_OK);
    ASSERT_EQ(occlude_culler_cull(culler.culler, &view, &device.functions, nullptr), OCCLUDE_OK);
    EXPECT_EQ(culler.drawn(), std::vector<uint32_t>{7});
}

TEST(CApi, AShapeHoldsItsTrianglesAndStaysWithItsItems)
{
    // Two flat squares, far apart in x: one box leaves nearly all of itself empty.
    const std::vector<float> positions{0, 0, 0, 1,  0, 0, 1,  1, 0, 0, 1, 0,
                                       9, 0, 5, 10, 0, 5, 10, 1, 5, 9, 1, 5};
    const std::vector<uint32_t> indices{0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7};
    occlude_shape* shape = nullptr;
    ASSERT_EQ(occlude_shape_from_triangles(positions.data(), 8, indices.data(), 12, 2, &shape),
              OCCLUDE_OK);
    const occlude_box* boxes = nullptr;
    ASSERT_EQ(occlude_shape_boxes(shape, &boxes), 2u);
    EXPECT_FLOAT_EQ(boxes[0].max[0] - boxes[0].min[0], 1.0f);
    EXPECT_FLOAT_EQ(boxes[1].max[0] - boxes[1].min[0], 1.0f);
    occlude_shape* same = nullptr;
    ASSERT_EQ(occlude_shape_from_boxes(boxes, 2, &same), OCCLUDE_OK);
    EXPECT_EQ(occlude_shape_boxes(same, nullptr), 2u);

    const HierarchyInC hierarchy{in_c(test::random_boxes(5, 1))};
    glm::mat4 place{1.0f};
    const float* matrix = glm::value_ptr(place);
    EXPECT_EQ(occlude_hierarchy_place_shape(hierarchy.tree, 4, shape, matrix), OCCLUDE_OK);
    EXPECT_EQ(occlude_hierarchy_place_shape(hierarchy.tree, 4, nullptr, nullptr), OCCLUDE_OK);
    EXPECT_EQ(occlude_hierarchy_place_shape(hierarchy.tree, 4, same, matrix), OCCLUDE_OK);
    EXPECT_EQ(occlude_hierarchy_place_shape(hierarchy.tree, 5, same, matrix),
              OCCLUDE_INVALID_ARGUMENT);
    EXPECT_EQ(occlude_hierarchy_place_shape(hierarchy.tree, 4, same, nullptr),
              OCCLUDE_INVALID_ARGUMENT);
    place[3][3] = 2.0f;
    EXPECT_EQ(occlude_hierarchy_place_shape(hierarchy.tree, 4, same, matrix),
              OCCLUDE_INVALID_ARGUMENT);
    EXPECT_NE(std::string{occlude_last_error()}.find("not affine"), std::string::npos);
    occlude_shape_destroy(shape);
    occlude_shape_destroy(same); // item 4 keeps it
}

TEST(CApi, AShapeOfMeaninglessTrianglesOrBoxesIsRefused)
{
    const std::vector<float> positions(9, 0.0f);
    const std::vector<uint32_t> indices{0, 1, 3};
    occlude_shape* shape = nullptr;
    EXPECT_EQ(occlude_shape_from_triangles(positions.data(), 3, indices.data(), 3, 2, &shape),
              OCCLUDE_INVALID_ARGUMENT);
    EXPECT_NE(std::string{occlude_last_error()}.find("indices[2] is 3"), std::string::npos);
    EXPECT_EQ(occlude_shape_from_triangles(positions.data(), 3, indices.data(), 2, 2, &shape),
              OCCLUDE_INVALID_ARGUMENT);
    const occlude_box inside_out{{1, 0, 0}, {0, 1, 1}};
    EXPECT_EQ(occlude_shape_from_boxes(&inside_out, 1, &shape), OCCLUDE_INVALID_ARGUMENT);
    EXPECT_EQ(shape, nullptr);
    EXPECT_EQ(occlude_shape_boxes(nullptr, nullptr), 0u);
}

TEST(CApi, WhatHasNoMeaningIsRefusedWithASentence)
{
    const std::vector<occlude_item> items = in_c(test::random_boxes(5, 1));
    occlude_hierarchy* tree = nullptr;
    EXPECT_EQ(occlude_hierarchy_create("tree", items.data(), 5, 0, nullptr, 0, &tree),
              OCCLUDE_NOT_FOUND);
    EXPECT_NE(std::string{occlude_last_error()}.find("bvh"), std::string::npos);
    EXPECT_EQ(occlude_hierarchy_create("bvh", nullptr, 5, 0, nullptr, 0, &tree),
              OCCLUDE_INVALID_ARGUMENT);
    const occlude_option wrong{"max_leaf_itms", "3"};
    EXPECT_EQ(occlude_hierarchy_create("bvh", items.data(), 5, 0, &wrong, 1, &tree),
              OCCLUDE_INVALID_ARGUMENT);
    EXPECT_NE(std::string{occlude_last_error()}.find("max_leaf_itms"), std::string::npos);
    EXPECT_EQ(tree, nullptr);

    const HierarchyInC hierarchy{items};
    EXPECT_EQ(occlude_hierarchy_refit(hierarchy.tree, items.data(), 4), OCCLUDE_INVALID_ARGUMENT);
    const uint32_t stranger = 5;
    EXPECT_EQ(occlude_hierarchy_refit_moved(hierarchy.tree, &stranger, 1, items.data(), 5),
              OCCLUDE_INVALID_ARGUMENT);

    const CullerInC culler{"chc", hierarchy};
    const occlude_view view = in_c(test::look_ahead());
    occlude_device empty{};
    EXPECT_EQ(occlude_culler_cull(culler.culler, &view, &empty, nullptr), OCCLUDE_INVALID_ARGUMENT);
    EXPECT_EQ(occlude_culler_cull(culler.culler, nullptr, &empty, nullptr),
              OCCLUDE_INVALID_ARGUMENT);
    const test::BoxCpuScene scene{test::random_boxes(5, 1)};
    DeviceInC device{scene};
    EXPECT_EQ(occlude_culler_record(culler.culler, &view, &device.functions, nullptr, 0),
              OCCLUDE_UNSUPPORTED);
    device.functions.wait = nullptr;
    EXPECT_EQ(occlude_culler_cull(culler.culler, &view, &device.functions, nullptr),
              OCCLUDE_INVALID_ARGUMENT);
    EXPECT_NE(std::string{occlude_last_error()}.find("wait"), std::string::npos);
    DeviceInC tiled{scene};
    const occlude_depth_read_cost twelve{12, 1.0f, 0.0f, 0.0f};
    tiled.functions.depth_reads = &twelve;
    tiled.functions.depth_read_count = 1;
    EXPECT_EQ(occlude_culler_cull(culler.culler, &view, &tiled.functions, nullptr),
              OCCLUDE_INVALID_ARGUMENT);
    EXPECT_NE(std::string{occlude_last_error()}.find("12"), std::string::npos);
    occlude_culler_destroy(nullptr);
    occlude_hierarchy_destroy(nullptr);
    occlude_culler_reset(nullptr);
    EXPECT_EQ(occlude_culler_drawn_items(nullptr, nullptr), 0u);
}

TEST(CApi, ACallbackThatThrowsGivesAStatus)
{
    const std::vector<ItemBounds> bounds = test::random_boxes(20, 1);
    const HierarchyInC hierarchy{in_c(bounds)};
    const CullerInC culler{"frustum", hierarchy};
    const test::BoxCpuScene scene{bounds};
    DeviceInC device{scene};
    device.functions.draw = [](void*, const uint32_t*, size_t, uint32_t) {
        throw std::runtime_error("the engine is out of buffers");
    };
    const occlude_view view = in_c(test::look_ahead());
    EXPECT_EQ(occlude_culler_cull(culler.culler, &view, &device.functions, nullptr),
              OCCLUDE_DEVICE_FAILED);
    EXPECT_STREQ(occlude_last_error(), "the engine is out of buffers");
}

TEST(CApi, AnOlderCallerGetsTheMembersItKnows)
{
    const std::vector<ItemBounds> bounds = test::random_boxes(20, 1);
    const HierarchyInC hierarchy{in_c(bounds)};
    const CullerInC culler{"frustum", hierarchy};
    const test::BoxCpuScene scene{bounds};
    DeviceInC device{scene};
    const occlude_view view = in_c(test::look_ahead());
    occlude_report report{};
    report.cells_asked = 77;
    report.struct_size = offsetof(occlude_report, cells_asked);
    ASSERT_EQ(occlude_culler_cull(culler.culler, &view, &device.functions, &report), OCCLUDE_OK);
    EXPECT_GT(report.items_drawn, 0u);
    EXPECT_EQ(report.cells_asked, 77u) << "written beyond struct_size";
}

} // namespace
} // namespace occlude
