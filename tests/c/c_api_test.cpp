// Every algorithm does through the C interface what it does in C++, decision by decision; and the C
// interface refuses what has no meaning with a sentence.
#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/c/occlude.h>
#include <occlude/cull/oracle_cullers.h>
#include <occlude/cull/registry.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include "support/box_scene.h"
#include "support/walks.h"

#include <glm/ext/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <gtest/gtest.h>

#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

namespace occlude {
namespace {

/// The CPU device behind C callbacks.
class DeviceInC {
public:
    explicit DeviceInC(const CpuScene& scene)
        : device_(scene)
    {
        functions.struct_size = sizeof functions;
        functions.user = this;
        functions.same_frame_results = 1;
        for (const TestCost& cost : device_.caps().methods) {
            methods_.push_back({static_cast<uint32_t>(cost.method), cost.exact_counts,
                                cost.us_per_batch, cost.us_per_test, cost.us_per_box});
        }
        functions.methods = methods_.data();
        functions.method_count = static_cast<uint32_t>(methods_.size());
        functions.us_per_triangle = device_.caps().us_per_triangle;
        functions.us_per_item = device_.caps().us_per_item;
        functions.samples_at_pixel_centers = device_.caps().samples_at_pixel_centers;
        functions.max_outstanding = device_.caps().max_outstanding;
        functions.begin_frame = [](void* user, const occlude_view* view) {
            DeviceInC& self = of(user);
            self.seen = *view;
            self.view_ = View::from_clip(glm::make_mat4(view->clip_from_world),
                                         {view->width_px, view->height_px});
            self.device_.begin_frame(self.view_);
        };
        functions.draw = [](void* user, const uint32_t* items, size_t count, uint32_t pass) {
            of(user).device_.draw(ids(items, count), static_cast<DrawPass>(pass));
        };
        functions.query = &query;
        functions.flush = [](void* user) { of(user).device_.flush(); };
        functions.poll = [](void* user, occlude_ticket ticket) {
            return in_c(of(user).device_.poll({ticket.index, ticket.generation}));
        };
        functions.wait = [](void* user, occlude_ticket ticket) {
            return in_c(of(user).device_.wait({ticket.index, ticket.generation}));
        };
        functions.draw_and_query = [](void* user, const uint32_t* items, size_t count,
                                      uint32_t pass) {
            const Ticket ticket =
                of(user).device_.draw_and_query(ids(items, count), static_cast<DrawPass>(pass));
            return occlude_ticket{ticket.index, ticket.generation};
        };
        functions.end_frame = [](void* user) { of(user).device_.end_frame(); };
        functions.read_depth = [](void* user, int32_t x, int32_t y, int32_t width, int32_t height,
                                  float* out) {
            const PixelRect rect{x, y, width, height};
            const size_t count = static_cast<size_t>(width) * static_cast<size_t>(height);
            return of(user).device_.read_depth(rect, {out, count}) ? 1 : 0;
        };
        for (const DepthReadCost& cost : device_.caps().depth_reads) {
            depth_reads_.push_back(
                {cost.tile_px, cost.us_per_read, cost.us_per_pixel, cost.us_per_value});
        }
        functions.depth_reads = depth_reads_.data();
        functions.depth_read_count = depth_reads_.size();
        functions.read_depth_tiles = [](void* user, int32_t tile_px, float* out, size_t count) {
            ++of(user).tile_reads;
            return of(user).device_.read_depth_tiles(tile_px, {out, count}) ? 1 : 0;
        };
    }

    occlude_device functions{};
    occlude_view seen{}; ///< by begin_frame
    int tile_reads = 0;

private:
    static DeviceInC& of(void* user) { return *static_cast<DeviceInC*>(user); }

    static std::vector<ItemId> ids(const uint32_t* items, size_t count)
    {
        std::vector<ItemId> result;
        for (size_t i = 0; i < count; ++i) {
            result.push_back(ItemId{items[i]});
        }
        return result;
    }

    static occlude_answer in_c(const Answer& answer)
    {
        return {static_cast<uint32_t>(answer.state), answer.samples};
    }

    static void query(void* user, const occlude_query_batch* batch, occlude_ticket* tickets)
    {
        std::vector<glm::mat4> matrices(batch->box_count);
        std::vector<QueryBox> boxes;
        for (size_t i = 0; i < batch->box_count; ++i) {
            const occlude_query_box& box = batch->boxes[i];
            if (box.world_from_box != nullptr) {
                matrices[i] = glm::make_mat4(box.world_from_box);
            }
            boxes.push_back({{glm::make_vec3(box.min), glm::make_vec3(box.max)},
                             box.world_from_box != nullptr ? &matrices[i] : nullptr,
                             NodeId{box.node}});
        }
        std::vector<Ticket> given(batch->test_count);
        of(user).device_.query(
            {boxes, {batch->test_ends, batch->test_count}, static_cast<TestMethod>(batch->method)},
            given);
        for (size_t i = 0; i < given.size(); ++i) {
            tickets[i] = {given[i].index, given[i].generation};
        }
    }

    CpuDevice device_;
    View view_;
    std::vector<occlude_test_cost> methods_;
    std::vector<occlude_depth_read_cost> depth_reads_;
};

occlude_view in_c(const View& view)
{
    occlude_view result{};
    result.struct_size = sizeof result;
    std::copy_n(glm::value_ptr(view.clip_from_world()), 16, result.clip_from_world);
    result.width_px = view.size_px().x;
    result.height_px = view.size_px().y;
    return result;
}

std::vector<occlude_item> in_c(std::span<const ItemBounds> bounds)
{
    std::vector<occlude_item> items;
    for (const ItemBounds& item : bounds) {
        items.push_back({{item.box.min.x, item.box.min.y, item.box.min.z},
                         {item.box.max.x, item.box.max.y, item.box.max.z},
                         item.triangles,
                         static_cast<uint32_t>(item.flags)});
    }
    return items;
}

/// A hierarchy through C, given back at the end.
struct HierarchyInC {
    explicit HierarchyInC(std::span<const occlude_item> items, const char* kind = "bvh")
    {
        EXPECT_EQ(occlude_hierarchy_create(kind, items.data(), items.size(), 24, nullptr, 0, &tree),
                  OCCLUDE_OK)
            << occlude_last_error();
    }
    ~HierarchyInC() { occlude_hierarchy_destroy(tree); }

    occlude_hierarchy* tree = nullptr;
};

struct CullerInC {
    CullerInC(const std::string& name, const HierarchyInC& hierarchy,
              const std::vector<occlude_option>& options = {})
    {
        EXPECT_EQ(occlude_culler_create(name.c_str(), hierarchy.tree, options.data(),
                                        options.size(), nullptr, nullptr, &culler),
                  OCCLUDE_OK)
            << occlude_last_error();
    }
    ~CullerInC() { occlude_culler_destroy(culler); }

    std::vector<uint32_t> drawn() const
    {
        const uint32_t* items = nullptr;
        const size_t count = occlude_culler_drawn_items(culler, &items);
        return {items, items + count};
    }

    occlude_culler* culler = nullptr;
};

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
    // Without a clock of the caller's "adaptive" takes the system's.
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

TEST(CApi, DepthIsReadByTiles)
{
    const std::vector<ItemBounds> bounds = test::random_boxes(400, 3);
    const std::vector<occlude_item> items = in_c(bounds);
    const test::BoxCpuScene scene{bounds};
    const HierarchyInC tree{items};
    DeviceInC by_pixels{scene};
    DeviceInC by_tiles{scene};
    const CullerInC pixels{"two_phase", tree};
    const CullerInC tiles{"two_phase", tree, {{"tile", "8"}}};
    uint64_t values_of_pixels = 0;
    uint64_t values_of_tiles = 0;
    for (uint64_t frame = 0; frame < 6; ++frame) {
        const occlude_view view = in_c(test::rough_walk(frame));
        occlude_report report{};
        report.struct_size = sizeof report;
        ASSERT_EQ(occlude_culler_cull(pixels.culler, &view, &by_pixels.functions, &report),
                  OCCLUDE_OK);
        values_of_pixels += report.pixels_read;
        ASSERT_EQ(occlude_culler_cull(tiles.culler, &view, &by_tiles.functions, &report),
                  OCCLUDE_OK);
        values_of_tiles += report.pixels_read;
    }
    EXPECT_EQ(by_pixels.tile_reads, 0);
    EXPECT_GT(by_tiles.tile_reads, 0);
    EXPECT_LT(values_of_tiles * 10, values_of_pixels);
}

TEST(CApi, AViewHasAllThatAViewHasInCpp)
{
    const std::vector<ItemBounds> bounds = test::random_boxes(50, 1);
    const HierarchyInC hierarchy{in_c(bounds)};
    const CullerInC culler{"frustum", hierarchy};
    const test::BoxCpuScene scene{bounds};
    DeviceInC device{scene};
    occlude_view view = in_c(test::look_ahead());
    view.viewport_x_px = 12;
    view.viewport_y_px = 34;
    view.tag = 1ull << 40;
    ASSERT_EQ(occlude_culler_cull(culler.culler, &view, &device.functions, nullptr), OCCLUDE_OK);
    EXPECT_EQ(device.seen.viewport_x_px, 12);
    EXPECT_EQ(device.seen.viewport_y_px, 34);
    EXPECT_EQ(device.seen.tag, 1ull << 40);
    const std::vector<uint32_t> drawn = culler.drawn();
    ASSERT_GT(drawn.size(), 0u);
    ASSERT_LT(drawn.size(), bounds.size());

    // The same camera, relative to an origin that is far from the eye.
    const glm::vec3 origin{5.0f, -3.0f, 40.0f};
    const glm::mat4 relative =
        glm::make_mat4(view.clip_from_world) * glm::translate(glm::mat4{1.0f}, origin);
    std::copy_n(glm::value_ptr(relative), 16, view.clip_from_world);
    view.camera_relative = 1;
    std::copy_n(glm::value_ptr(glm::dvec3{origin}), 3, view.origin);
    ASSERT_EQ(occlude_culler_cull(culler.culler, &view, &device.functions, nullptr), OCCLUDE_OK);
    EXPECT_EQ(culler.drawn(), drawn);

    // Depth clamp: what lies between the eye and the near plane is in the frustum.
    occlude_item before{{-0.01f, -0.01f, -0.06f}, {0.01f, 0.01f, -0.05f}, 12, 0};
    const HierarchyInC one{{&before, 1}};
    const CullerInC culler_of_one{"frustum", one};
    view = in_c(test::look_ahead());
    ASSERT_EQ(occlude_culler_cull(culler_of_one.culler, &view, &device.functions, nullptr),
              OCCLUDE_OK);
    EXPECT_EQ(culler_of_one.drawn().size(), 0u);
    view.ignores_near_plane = 1;
    ASSERT_EQ(occlude_culler_cull(culler_of_one.culler, &view, &device.functions, nullptr),
              OCCLUDE_OK);
    EXPECT_EQ(culler_of_one.drawn().size(), 1u);
}

TEST(CApi, CallersOfVersionOneNeedNotKnowWhatCameLater)
{
    const std::vector<ItemBounds> bounds = test::random_boxes(50, 1);
    const HierarchyInC hierarchy{in_c(bounds)};
    const CullerInC culler{"two_phase", hierarchy, {{"tile", "8"}}};
    const test::BoxCpuScene scene{bounds};
    DeviceInC device{scene};
    occlude_view view = in_c(test::look_ahead());
    view.struct_size = offsetof(occlude_view, viewport_x_px);
    view.ignores_near_plane = 1;
    device.functions.struct_size = offsetof(occlude_device, depth_reads);
    ASSERT_EQ(occlude_culler_cull(culler.culler, &view, &device.functions, nullptr), OCCLUDE_OK);
    EXPECT_EQ(device.tile_reads, 0) << "read beyond struct_size";
    view.struct_size = 8;
    EXPECT_EQ(occlude_culler_cull(culler.culler, &view, &device.functions, nullptr),
              OCCLUDE_INVALID_ARGUMENT);
}

TEST(CApi, FaultsAreToldOnceByNameAndInASentence)
{
    const std::vector<ItemBounds> bounds = test::random_boxes(400, 3);
    const HierarchyInC hierarchy{in_c(bounds)};
    const CullerInC culler{"stop_and_wait", hierarchy};
    const test::BoxCpuScene scene{bounds};
    DeviceInC device{scene};
    device.functions.wait = [](void*, occlude_ticket) {
        return occlude_answer{OCCLUDE_ANSWER_LOST, 0};
    };
    device.functions.poll = device.functions.wait;
    std::string heard;
    ASSERT_EQ(occlude_culler_set_message_handler(
                  culler.culler,
                  [](void* user, uint32_t severity, const char* name, const char* text) {
                      EXPECT_EQ(severity, static_cast<uint32_t>(OCCLUDE_SEVERITY_WARNING));
                      EXPECT_GT(std::strlen(text), 20u);
                      *static_cast<std::string*>(user) += name;
                  },
                  &heard),
              OCCLUDE_OK);
    for (uint64_t frame = 0; frame < 3; ++frame) {
        const occlude_view view = in_c(test::rough_walk(frame));
        ASSERT_EQ(occlude_culler_cull(culler.culler, &view, &device.functions, nullptr),
                  OCCLUDE_OK);
    }
    EXPECT_EQ(heard, "culler.lost_answers");
    EXPECT_EQ(occlude_culler_set_message_handler(culler.culler, nullptr, nullptr), OCCLUDE_OK);
    EXPECT_EQ(occlude_culler_set_message_handler(nullptr, nullptr, nullptr),
              OCCLUDE_INVALID_ARGUMENT);
    EXPECT_EQ(occlude_culler_release(culler.culler, &device.functions), OCCLUDE_OK);
    EXPECT_EQ(occlude_culler_release(culler.culler, nullptr), OCCLUDE_INVALID_ARGUMENT);
}

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

// The layout is what bindings rely on. A change here needs a new OCCLUDE_C_ABI_VERSION, or at the
// end of a struct none.
TEST(CApi, StructsHaveTheLayoutOfVersionOne)
{
    EXPECT_EQ(sizeof(occlude_item), 32u);
    EXPECT_EQ(sizeof(occlude_ticket), 8u);
    EXPECT_EQ(sizeof(occlude_answer), 16u);
    EXPECT_EQ(sizeof(occlude_option), 16u);
    EXPECT_EQ(sizeof(occlude_query_box), 40u);
    EXPECT_EQ(sizeof(occlude_query_batch), 40u);
    EXPECT_EQ(offsetof(occlude_view, depth_order), 84u);
    EXPECT_EQ(offsetof(occlude_device, begin_frame), 48u);
    EXPECT_EQ(offsetof(occlude_device, read_depth), 112u);
    EXPECT_EQ(offsetof(occlude_report, cells_asked), 144u);
}

TEST(CApi, StructsHaveTheLayoutOfVersionTwo)
{
    EXPECT_EQ(offsetof(occlude_view, viewport_x_px), 88u);
    EXPECT_EQ(offsetof(occlude_view, origin), 112u);
    EXPECT_EQ(sizeof(occlude_view), 136u);
    EXPECT_EQ(sizeof(occlude_depth_read_cost), 16u);
    EXPECT_EQ(offsetof(occlude_device, depth_reads), 120u);
    EXPECT_EQ(sizeof(occlude_device), 144u);
    EXPECT_EQ(sizeof(occlude_report), 152u);
}

} // namespace
} // namespace occlude
