// The same town at any place and in any unit gives the same picture and the same items.
#include "generate/scene_source.h"
#include "measure/stage.h"
#include "render/gl_renderer.h"
#include "render/image.h"
#include "render/scene_renderer.h"
#include "tools/temp_folder.h"
#include "walk/paths.h"

#include <occlude/cull/two_phase.h>
#include <occlude/hierarchy/builders/bvh_builder.h>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstring>
#include <map>
#include <set>

namespace occlude::tools {
namespace {

using nlohmann::json;

constexpr glm::ivec2 kSize{192, 108};

/// A box of 1 m as glTF with one node per house of a town of 6 by 6.
std::string town_gltf(const glm::dvec3& offset, double scale)
{
    json root{{"asset", {{"version", "2.0"}}}};
    json roots = json::array();
    for (int house = 0; house < 36; ++house) {
        const double height = 6.0 + (house * 7 % 5);
        root["nodes"].push_back({{"mesh", 0},
                                 {"name", "house " + std::to_string(house)},
                                 {"translation",
                                  {offset.x + scale * 12.0 * (house % 6), offset.y,
                                   offset.z + scale * 12.0 * (house / 6)}},
                                 {"scale", {scale * 8.0, scale * height, scale * 8.0}}});
        roots.push_back(house);
    }
    root["scenes"] = json::array({{{"nodes", roots}}});
    root["meshes"] = json::array(
        {{{"primitives", json::array({{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}})}}});
    root["accessors"] = json::array(
        {{{"bufferView", 0}, {"componentType", 5126}, {"count", 8}, {"type", "VEC3"}},
         {{"bufferView", 1}, {"componentType", 5123}, {"count", 36}, {"type", "SCALAR"}}});
    root["bufferViews"] = json::array({{{"buffer", 0}, {"byteOffset", 0}, {"byteLength", 96}},
                                       {{"buffer", 0}, {"byteOffset", 96}, {"byteLength", 72}}});
    root["buffers"] = json::array({{{"byteLength", 168}, {"uri", "box.bin"}}});
    return root.dump();
}

std::string box_bin()
{
    std::string bytes(168, '\0');
    size_t at = 0;
    for (int i = 0; i < 8; ++i) {
        const float corner[3] = {i & 4 ? 1.0f : 0.0f, i & 2 ? 1.0f : 0.0f, i & 1 ? 1.0f : 0.0f};
        std::memcpy(bytes.data() + at, corner, sizeof corner);
        at += sizeof corner;
    }
    const uint16_t indices[36] = {0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1,
                                  2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3};
    std::memcpy(bytes.data() + at, indices, sizeof indices);
    return bytes;
}

enum class Device { cpu, gl };

struct Shot {
    Image image;
    Image culled;                           ///< drawn by two_phase
    std::set<uint32_t> hidden;              ///< items in the frustum that two_phase did not draw
    std::map<uint32_t, uint64_t> pixels_of; ///< by item
    uint64_t items = 0;                     ///< in the frustum
};

/// Looks along a street of the town, at eye height.
Shot look(const TempFolder& folder, const glm::dvec3& offset, double scale,
          const SceneOptions& options = {}, Device device = Device::cpu)
{
    folder.write("box.bin", box_bin());
    const auto model = load_scene(folder.write("town.gltf", town_gltf(offset, scale)), options);
    EXPECT_TRUE(model) << model.error().message;
    const glm::dvec3 eye = offset + scale * glm::dvec3{10.0, 1.7, -9.0};
    const glm::dvec3 target = offset + scale * glm::dvec3{14.0, 3.0, 40.0};
    const json path{{"version", 1},
                    {"frames", json::array({{{"eye", {eye.x, eye.y, eye.z}},
                                             {"target", {target.x, target.y, target.z}}}})}};
    auto cameras = load_path(folder.write("path.json", path.dump()), *model, 1);
    EXPECT_TRUE(cameras) << cameras.error().message;
    choose_depth_range(*cameras, *model);
    const View view = make_view(cameras->front(), kSize);
    const CullScene cull = make_cull_scene(*model);
    auto renderer = device == Device::gl ? make_gl_renderer(*model, cull.items, kSize, 1)
                                         : make_cpu_renderer(*model, cull.items, kSize);
    EXPECT_TRUE(renderer);
    const std::vector<ItemId> items = items_in_frustum(view, cull.scene.item_bounds());
    Shot shot;
    shot.items = items.size();
    for (const uint32_t id : (*renderer)->render_ids(view, items)) {
        ++shot.pixels_of[id];
    }
    (*renderer)->render(view, items);
    shot.image = (*renderer)->capture().color;
    const Hierarchy tree = build_bvh(cull.scene.item_bounds(), {.leaf_triangles = 0});
    // From the third frame on, every box is tested against the full depth of the frame. In earlier
    // frames the order of the tests matters, and rounding decides it between equal distances.
    TwoPhase culler(tree, {.final_depth = true});
    for (int frame = 0; frame < 3; ++frame) {
        culler.cull(view, (*renderer)->device());
    }
    shot.culled = (*renderer)->capture().color;
    for (const ItemId item : items) {
        shot.hidden.insert(item.value);
    }
    for (const ItemId item : culler.drawn_items()) {
        shot.hidden.erase(item.value);
    }
    return shot;
}

/// Items that own more than a few pixels: rounding cannot make these visible or hidden.
std::set<uint32_t> clearly_visible(const Shot& shot)
{
    std::set<uint32_t> items;
    for (const auto& [item, pixels] : shot.pixels_of) {
        if (pixels > 8) {
            items.insert(item);
        }
    }
    return items;
}

void expect_same_picture(const Shot& shot, const Shot& reference)
{
    const auto pixels = static_cast<uint64_t>(kSize.x * kSize.y);
    EXPECT_LT(count_differences(shot.image, reference.image), pixels / 200) << "edges may round";
    EXPECT_EQ(clearly_visible(shot), clearly_visible(reference));
    EXPECT_EQ(shot.hidden, reference.hidden);
    EXPECT_EQ(count_differences(shot.culled, shot.image), 0u) << "culling changed the picture";
}

/// The picture is evidence: many items, of which some are clearly visible and some hidden.
void expect_evidence(const Shot& near)
{
    ASSERT_GT(near.items, 20u);
    ASSERT_LT(clearly_visible(near).size(), near.items) << "something must be hidden";
    ASSERT_GT(clearly_visible(near).size(), 4u);
    ASSERT_GT(near.hidden.size(), 4u);
}

class FarTown : public testing::TestWithParam<Device> {};

TEST_P(FarTown, LooksTheSameAtAnyOffset)
{
    const TempFolder folder;
    const Shot near = look(folder, glm::dvec3{0.0}, 1.0, {}, GetParam());
    expect_evidence(near);
    for (const double away : {1e5, 1e6, 1e7}) {
        for (const glm::dvec3 axis : {glm::dvec3{1, 0, 0}, glm::dvec3{0, 1, 0}, glm::dvec3{0, 0, 1},
                                      glm::dvec3{1, -1, 1}}) {
            SCOPED_TRACE(testing::Message() << away << " along " << axis.x << axis.y << axis.z);
            expect_same_picture(look(folder, away * axis, 1.0, {}, GetParam()), near);
        }
    }
    SCOPED_TRACE("where single precision leaves no town");
    expect_same_picture(look(folder, {1e12, 0.0, -1e12}, 1.0, {}, GetParam()), near);
}

TEST(FarTownMoved, IsTheSameToTheBitIfItIsMovedByItsOffset)
{
    const TempFolder folder;
    const Shot near = look(folder, glm::dvec3{0.0}, 1.0);
    const glm::dvec3 offset{1e7, -4096.0, 123456.0};
    const Shot far = look(folder, offset, 1.0, {.origin = offset});
    EXPECT_EQ(count_differences(far.image, near.image), 0u);
    EXPECT_EQ(far.pixels_of, near.pixels_of);
}

TEST_P(FarTown, LooksTheSameAtAnyScale)
{
    const TempFolder folder;
    const Shot near = look(folder, glm::dvec3{0.0}, 1.0, {}, GetParam());
    for (const double scale : {1e-6, 1e-3, 1e3, 1e6, 1e9}) {
        SCOPED_TRACE(scale);
        expect_same_picture(look(folder, glm::dvec3{0.0}, scale, {}, GetParam()), near);
        expect_same_picture(look(folder, glm::dvec3{1e6 * scale}, scale, {}, GetParam()), near);
    }
}

INSTANTIATE_TEST_SUITE_P(On, FarTown, testing::Values(Device::cpu, Device::gl),
                         [](const auto& device) {
                             return device.param == Device::gl ? "Gl" : "Cpu";
                         });

} // namespace
} // namespace occlude::tools
