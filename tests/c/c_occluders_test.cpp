// The occluder buffer says the same through the C interface as in C++.
#include "c/c_fixture.h"

#include <occlude/c/occluders.h>
#include <occlude/occluder_buffer.h>

#include <array>

namespace occlude {
namespace {

// Before the eye, but not all over the view.
constexpr std::array<float, 12> kWall{-9.0f, -30.0f, -20.0f, 9.0f,  -30.0f, -20.0f,
                                      9.0f,  30.0f,  -20.0f, -9.0f, 30.0f,  -20.0f};
constexpr std::array<uint16_t, 6> kIndices{0, 1, 2, 0, 2, 3};
constexpr std::array<float, 16> kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

occlude_mesh_data wall_data()
{
    occlude_mesh_data data{};
    data.struct_size = sizeof data;
    data.positions = kWall.data();
    data.position_count = 4;
    data.indices = kIndices.data();
    data.index_count = kIndices.size();
    data.index_bytes = 2;
    return data;
}

struct OccludersInC {
    OccludersInC()
    {
        const occlude_mesh_data data = wall_data();
        EXPECT_EQ(occlude_occluder_mesh_create(&data, &mesh), OCCLUDE_OK) << occlude_last_error();
        EXPECT_EQ(occlude_occluder_buffer_create(nullptr, &buffer), OCCLUDE_OK);
    }
    ~OccludersInC()
    {
        occlude_occluder_buffer_destroy(buffer);
        occlude_occluder_mesh_destroy(mesh);
    }
    OccludersInC(const OccludersInC&) = delete;
    OccludersInC& operator=(const OccludersInC&) = delete;

    occlude_occluder_mesh* mesh = nullptr;
    occlude_occluder_buffer* buffer = nullptr;
};

TEST(CApi, OccludersHideTheSameBoxesAsInCpp)
{
    const View view = test::look_ahead();
    const occlude_view view_in_c = in_c(view);
    const OccludersInC c;
    ASSERT_EQ(occlude_occluder_buffer_begin(c.buffer, &view_in_c), OCCLUDE_OK);
    ASSERT_EQ(occlude_occluder_buffer_add(c.buffer, c.mesh, kIdentity.data()), OCCLUDE_OK);
    ASSERT_EQ(occlude_occluder_buffer_rasterize(c.buffer), OCCLUDE_OK);

    const OccluderMesh mesh = OccluderMesh::prepare(PositionStream(kWall.data(), 4, 12), kIndices);
    OccluderBuffer buffer;
    buffer.begin(view);
    buffer.add(mesh, glm::mat4{1.0f});
    buffer.rasterize();

    std::vector<Aabb> boxes;
    std::vector<float> boxes_in_c;
    for (const ItemBounds& item : test::random_boxes(700, 5)) {
        boxes.push_back(item.box);
        boxes_in_c.insert(boxes_in_c.end(), {item.box.min.x, item.box.min.y, item.box.min.z,
                                             item.box.max.x, item.box.max.y, item.box.max.z});
    }
    std::vector<Visibility> expected(boxes.size());
    buffer.test(boxes, expected);
    std::vector<uint8_t> results(boxes.size(), 99);
    ASSERT_EQ(occlude_occluder_buffer_test_boxes(c.buffer, boxes_in_c.data(), boxes.size(),
                                                 results.data()),
              OCCLUDE_OK);
    std::array<size_t, 3> found{};
    for (size_t i = 0; i < boxes.size(); ++i) {
        ASSERT_EQ(results[i], static_cast<uint8_t>(expected[i])) << "box " << i;
        ++found[results[i]];
    }
    EXPECT_GT(found[OCCLUDE_BOX_VISIBLE], 10u);
    EXPECT_GT(found[OCCLUDE_BOX_HIDDEN], 10u);
    EXPECT_GT(found[OCCLUDE_BOX_OUTSIDE], 10u);

    uint8_t result = 99;
    ASSERT_EQ(occlude_occluder_buffer_test_rectangle(c.buffer, -50, 0, 10, 10, 0.5f, &result),
              OCCLUDE_OK);
    EXPECT_EQ(result, OCCLUDE_BOX_OUTSIDE);
}

TEST(CApi, OccludersRefuseWhatHasNoMeaningWithASentence)
{
    const OccludersInC c;
    occlude_occluder_mesh* mesh = nullptr;
    occlude_mesh_data data = wall_data();
    data.index_bytes = 3;
    EXPECT_EQ(occlude_occluder_mesh_create(&data, &mesh), OCCLUDE_INVALID_ARGUMENT);
    EXPECT_EQ(std::string{occlude_last_error()}, "index_bytes is 3; it must be 2 or 4");
    data = wall_data();
    data.positions = nullptr;
    EXPECT_EQ(occlude_occluder_mesh_create(&data, &mesh), OCCLUDE_INVALID_ARGUMENT);
    EXPECT_EQ(mesh, nullptr);
    EXPECT_EQ(occlude_occluder_mesh_set_positions(c.mesh, kWall.data(), 4, 0), OCCLUDE_UNSUPPORTED);
    EXPECT_EQ(occlude_occluder_buffer_begin(c.buffer, nullptr), OCCLUDE_INVALID_ARGUMENT);
    EXPECT_EQ(occlude_occluder_buffer_add(c.buffer, nullptr, kIdentity.data()),
              OCCLUDE_INVALID_ARGUMENT);
    EXPECT_EQ(occlude_occluder_buffer_test_boxes(c.buffer, nullptr, 1, nullptr),
              OCCLUDE_INVALID_ARGUMENT);
    occlude_occluder_buffer_destroy(nullptr);
    occlude_occluder_mesh_destroy(nullptr);
}

} // namespace
} // namespace occlude
