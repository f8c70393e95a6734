#include "render/cpu_renderer.h"

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

namespace occlude::tools {
namespace {

constexpr glm::ivec2 kSize{65, 33};
constexpr uint32_t kNobody = 0xffffffffu;

Mesh rectangle_mesh()
{
    Mesh mesh;
    mesh.name = "rectangle";
    mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    mesh.normals.assign(4, {0, 0, 1});
    mesh.indices = {0, 1, 2, 0, 2, 3};
    return mesh;
}

// A wall of one part at z = -5; a rectangle of two parts (its triangles) in front of it at z = -3;
// another one behind the wall at z = -7.
SceneModel walls()
{
    SceneModel model;
    model.name = "walls";
    Mesh wall = rectangle_mesh();
    wall.parts = {{0, 6, {{-1, -1, 0}, {1, 1, 0}}}};
    Mesh halves = rectangle_mesh();
    halves.parts = {{0, 3, {{-1, -1, 0}, {1, 1, 0}}}, {3, 3, {{-1, -1, 0}, {1, 1, 0}}}};
    model.meshes = {wall, halves};
    const auto at = [](float z, float scale) {
        return glm::scale(glm::translate(glm::mat4{1.0f}, {0, 0, z}), glm::vec3{scale});
    };
    model.instances = {{"wall", 0, at(-5.0f, 2.0f), {1.0f, 0.5f, 0.25f}},
                       {"near", 1, at(-3.0f, 0.5f), {0.0f, 1.0f, 0.0f}},
                       {"hidden", 1, at(-7.0f, 1.0f), {0.0f, 0.0f, 1.0f}}};
    return model;
}

const std::vector<SceneModel::Item> kItems = {{0, 0}, {1, 0}, {1, 1}, {2, 0}, {2, 1}};

std::vector<ItemId> ids(std::initializer_list<uint32_t> values)
{
    std::vector<ItemId> result;
    for (const uint32_t value : values) {
        result.push_back(ItemId{value});
    }
    return result;
}

View front_view(glm::ivec2 size = kSize)
{
    const float aspect = static_cast<float>(size.x) / static_cast<float>(size.y);
    return View::from_clip(glm::perspective(glm::radians(60.0f), aspect, 0.1f, 50.0f), size);
}

std::unique_ptr<SceneRenderer> renderer_of(const SceneModel& model)
{
    Result<std::unique_ptr<SceneRenderer>> renderer = make_cpu_renderer(model, kItems, kSize);
    EXPECT_TRUE(renderer) << renderer.error().message;
    return std::move(*renderer);
}

size_t at(int x, int y)
{
    return static_cast<size_t>(y * kSize.x + x);
}

// The colour of a surface that faces +z or -z: its base colour times the ambient light and its
// share of the light.
uint32_t expected_color(glm::vec3 base)
{
    const float cosine = 0.45f / std::sqrt(0.4f * 0.4f + 0.8f * 0.8f + 0.45f * 0.45f);
    const glm::vec3 bytes = base * (0.35f + 0.65f * cosine) * 255.0f;
    return 0xff000000u | static_cast<uint32_t>(std::lround(bytes.x)) |
           static_cast<uint32_t>(std::lround(bytes.y)) << 8 |
           static_cast<uint32_t>(std::lround(bytes.z)) << 16;
}

TEST(CpuRenderer, ShadesWithTheLightOnTheGeometricNormalOfEitherSide)
{
    SceneModel model = walls();
    const auto renderer = renderer_of(model);
    const std::vector<ItemId> all = ids({0, 1, 2, 3, 4});
    renderer->render(front_view(), all);
    const Capture capture = renderer->capture();
    ASSERT_EQ(capture.color.size, kSize);
    ASSERT_EQ(capture.color.pixels.size(), at(0, kSize.y));
    EXPECT_EQ(capture.color.pixels[at(32, 16)], expected_color({0, 1, 0}));
    EXPECT_EQ(capture.color.pixels[at(32, 25)], expected_color({1.0f, 0.5f, 0.25f}));
    const uint32_t background = capture.color.pixels[at(0, 0)];
    EXPECT_EQ(capture.depth[at(0, 0)], 1.0f);
    EXPECT_EQ(background >> 24, 0xffu);
    EXPECT_NE(background, expected_color({0, 1, 0}));
    EXPECT_LT(capture.depth[at(32, 16)], capture.depth[at(32, 25)]);

    // From behind, mirrored: the same brightness.
    model.instances[1].world_from_mesh =
        glm::scale(model.instances[1].world_from_mesh, {1.0f, 1.0f, -1.0f});
    const auto mirrored = renderer_of(model);
    mirrored->render(front_view(), all);
    EXPECT_EQ(mirrored->capture().color.pixels, capture.color.pixels);
}

TEST(CpuRenderer, SurfacesTowardTheLightAreBrighterThanSurfacesAlongIt)
{
    SceneModel model = walls();
    model.instances[0].color = glm::vec3{1.0f};
    const auto brightness = [&model](float degrees) {
        model.instances[0].world_from_mesh = glm::rotate(
            glm::translate(glm::mat4{1.0f}, {0, 0, -5}), glm::radians(degrees), {1, 0, 0});
        const auto renderer = renderer_of(model);
        renderer->render(front_view(), ids({0}));
        return renderer->capture().color.pixels[at(32, 16)] & 0xffu;
    };
    // The light stands 61 degrees above the z axis, seen from the side.
    EXPECT_GT(brightness(-61.0f), brightness(0.0f));
    EXPECT_GT(brightness(0.0f), brightness(25.0f));
    EXPECT_GE(brightness(29.0f), 89u) << "ambient";
}

TEST(CpuRenderer, FramesDrawnThroughTheDeviceEqualRenderedOnes)
{
    const SceneModel model = walls();
    const auto renderer = renderer_of(model);
    renderer->render(front_view(), ids({0, 1, 2, 3, 4}));
    const Capture reference = renderer->capture();

    // Another order, without hidden items, depth first.
    QueryDevice& device = renderer->device();
    device.begin_frame(front_view());
    device.draw(ids({2, 1}), DrawPass::depth_only);
    device.draw(ids({0}), DrawPass::shade);
    device.draw(ids({1, 2}), DrawPass::shade_equal);
    device.end_frame();
    renderer->finish();
    const Capture culled = renderer->capture();
    EXPECT_EQ(culled.color.pixels, reference.color.pixels);
    EXPECT_EQ(culled.depth, reference.depth);

    // Without a visible item, the image differs.
    renderer->render(front_view(), ids({0, 1}));
    EXPECT_NE(renderer->capture().color.pixels, reference.color.pixels);
}

TEST(CpuRenderer, IdsNameTheItemThatOwnsEachPixelAndLeaveTheFrameAlone)
{
    const SceneModel model = walls();
    const auto renderer = renderer_of(model);
    renderer->render(front_view(), ids({0}));
    const Capture before = renderer->capture();
    const std::vector<uint32_t> owners = renderer->render_ids(front_view(), ids({4, 3, 2, 1, 0}));
    ASSERT_EQ(owners.size(), at(0, kSize.y));
    EXPECT_EQ(owners[at(0, 0)], kNobody);
    EXPECT_EQ(owners[at(32, 25)], 0u);
    EXPECT_EQ(owners[at(34, 16)], 1u) << "right of the diagonal";
    EXPECT_EQ(owners[at(30, 16)], 2u) << "left of the diagonal";
    EXPECT_EQ(std::set<uint32_t>(owners.begin(), owners.end()),
              (std::set<uint32_t>{0, 1, 2, kNobody}));
    const Capture after = renderer->capture();
    EXPECT_EQ(after.color.pixels, before.color.pixels);
    EXPECT_EQ(after.depth, before.depth);

    const std::vector<uint32_t> without_wall = renderer->render_ids(front_view(), ids({3, 4}));
    EXPECT_EQ(std::set<uint32_t>(without_wall.begin(), without_wall.end()),
              (std::set<uint32_t>{3, 4, kNobody}));
}

TEST(CpuRenderer, ItemColorsOverrideTheScenesUntilTakenBack)
{
    const SceneModel model = walls();
    const auto renderer = renderer_of(model);
    renderer->render(front_view(), ids({0, 1, 2}));
    const uint32_t own = renderer->capture().color.pixels[at(34, 16)];
    const std::vector<glm::vec4> colors = {{1, 0, 0, 1}, {0, 0, 1, 1}};
    renderer->set_item_colors(colors);
    const Capture colored = renderer->capture();
    EXPECT_EQ(colored.color.pixels[at(32, 25)], expected_color({1, 0, 0}));
    EXPECT_EQ(colored.color.pixels[at(34, 16)], expected_color({0, 0, 1}));
    EXPECT_EQ(colored.color.pixels[at(30, 16)], own) << "item 2 has no override";
    renderer->set_item_colors({});
    EXPECT_EQ(renderer->capture().color.pixels[at(34, 16)], own);
}

TEST(CpuRenderer, MovedInstancesAreDrawnWhereTheyAre)
{
    const SceneModel model = walls();
    const auto renderer = renderer_of(model);
    std::vector<glm::mat4> transforms;
    for (const Instance& instance : model.instances) {
        transforms.push_back(instance.world_from_mesh);
    }
    transforms[2] = glm::translate(glm::mat4{1.0f}, {0, 0, -2});
    renderer->update_transforms(transforms);
    const std::vector<uint32_t> owners = renderer->render_ids(front_view(), ids({0, 1, 2, 3, 4}));
    EXPECT_EQ(owners[at(34, 16)], 3u);
    EXPECT_EQ(owners[at(30, 16)], 4u);
}

TEST(CpuRenderer, LinesAreHiddenBehindTheSceneUnlessOnTop)
{
    const SceneModel model = walls();
    const auto renderer = renderer_of(model);
    const std::vector<ItemId> items = ids({0, 1, 2});
    const glm::vec4 white{1, 1, 1, 1};
    // Across the picture at z = -4: in front of the wall, behind the near rectangle; one end is
    // behind the eye for the second line.
    const std::vector<glm::vec3> line = {{-40, 0.05f, -4}, {40, 0.05f, -4}};
    const auto white_pixels = [&] {
        const std::vector<uint32_t> pixels = renderer->capture().color.pixels;
        return std::count(pixels.begin(), pixels.end(), 0xffffffffu);
    };
    renderer->render(front_view(), items);
    EXPECT_EQ(white_pixels(), 0);
    const Capture before = renderer->capture();
    renderer->draw_lines(front_view(), line, white, false);
    const Capture tested = renderer->capture();
    EXPECT_EQ(tested.color.pixels[at(32, 16)], expected_color({0, 1, 0}));
    EXPECT_EQ(tested.color.pixels[at(2, 16)], 0xffffffffu);
    EXPECT_EQ(tested.depth, before.depth);
    const auto behind = white_pixels();
    EXPECT_GT(behind, 40);
    EXPECT_LT(behind, kSize.x);
    renderer->draw_lines(front_view(), line, white, true);
    EXPECT_EQ(white_pixels(), kSize.x);

    renderer->render(front_view(), items);
    EXPECT_EQ(renderer->capture().color.pixels, before.color.pixels) << "gone with the next frame";
    const std::vector<glm::vec3> odd = {{0, -1, 5}, {0, 0, -20}, {0, 0, 1}, {0, 0, 5}, {1, 1, 1}};
    renderer->draw_lines(front_view(), odd, white, true);
    EXPECT_GT(white_pixels(), 5) << "clipped at the near plane";
    renderer->render(front_view(), items);
    renderer->draw_lines(front_view(), line, {1, 1, 1, 0}, true);
    EXPECT_EQ(renderer->capture().color.pixels, before.color.pixels) << "transparent";
}

TEST(CpuRenderer, CaptureBeforeTheFirstFrameIsBackground)
{
    const SceneModel model = walls();
    const auto renderer = renderer_of(model);
    renderer->warm_up();
    const Capture capture = renderer->capture();
    EXPECT_EQ(capture.color.size, kSize);
    EXPECT_EQ(std::set<uint32_t>(capture.color.pixels.begin(), capture.color.pixels.end()).size(),
              1u);
    EXPECT_EQ(capture.depth, std::vector<float>(at(0, kSize.y), 1.0f));
    EXPECT_EQ(renderer->api(), "cpu");
    EXPECT_FALSE(renderer->renderer_name().empty());
}

TEST(CpuRenderer, RefusesSizesAndSamplesItCannotDraw)
{
    const SceneModel model = walls();
    const auto renderer = renderer_of(model);
    EXPECT_TRUE(renderer->resize({641, 359}, 1));
    const Result<bool> multisampled = renderer->resize({641, 359}, 4);
    ASSERT_FALSE(multisampled);
    EXPECT_EQ(multisampled.error().code, ErrorCode::unsupported);
    const Result<bool> empty = renderer->resize({0, 359}, 1);
    ASSERT_FALSE(empty);
    EXPECT_EQ(empty.error().code, ErrorCode::invalid_argument);
    EXPECT_NE(empty.error().message.find("0x359"), std::string::npos);
    EXPECT_FALSE(make_cpu_renderer(model, kItems, {-1, 4}));

    renderer->render(front_view({641, 359}), ids({0}));
    EXPECT_EQ(renderer->capture().color.size, (glm::ivec2{641, 359}));
}

TEST(CpuRenderer, RefusesItemsThatDrawWhatIsNotThere)
{
    SceneModel model = walls();
    const auto error_of = [&model](std::vector<SceneModel::Item> items) {
        const auto renderer = make_cpu_renderer(model, items, kSize);
        return renderer ? std::string{} : renderer.error().message;
    };
    EXPECT_EQ(error_of({{0, 0}}), "");
    EXPECT_NE(error_of({{0, 0}, {3, 0}}).find("item 1 of scene 'walls'"), std::string::npos);
    EXPECT_NE(error_of({{0, 1}}).find("part 1"), std::string::npos);
    model.meshes[0].parts[0].index_count = 9;
    EXPECT_NE(error_of({{0, 0}}).find("beyond the end"), std::string::npos);
}

} // namespace
} // namespace occlude::tools
