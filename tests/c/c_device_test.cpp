// Devices, views and messages through the C interface, and the layout of its structs.
#include "c/c_fixture.h"

#include <glm/ext/matrix_transform.hpp>

#include <cstddef>
#include <cstring>

namespace occlude {
namespace {

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

    // Depth clamp: geometry between the eye and the near plane is in the frustum.
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

// Bindings rely on this layout. A change needs a new OCCLUDE_C_ABI_VERSION, unless it appends to
// the end of a struct.
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
