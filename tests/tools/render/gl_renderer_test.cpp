#include "render/gl_renderer.h"
#include "render/image.h"
#include "tools/render/spheres.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>

namespace occlude::tools {
namespace {

class GlRendererTest : public testing::Test {
protected:
    GlRendererTest()
        : model(test_model())
        , items(items_of(model))
    {
        for (size_t i = 0; i < items.size(); ++i) {
            all.emplace_back(i);
        }
    }

    void SetUp() override { renderer = make(1); }

    std::unique_ptr<SceneRenderer> make(int samples, const GlRendererOptions& options = {})
    {
        auto made = make_gl_renderer(model, items, kSize, samples, options);
        EXPECT_TRUE(made) << (made ? "" : made.error().message);
        return made ? std::move(*made) : nullptr;
    }

    static Capture image_of(SceneRenderer& renderer, std::span<const ItemId> items,
                            const View& view = test_view())
    {
        renderer.render(view, items);
        return renderer.capture();
    }

    static void expect_same(const Capture& a, const Capture& b)
    {
        EXPECT_EQ(count_differences(a.color, b.color), 0u);
        EXPECT_EQ(a.depth, b.depth);
    }

    // Pixels nearer than the far plane.
    static ptrdiff_t covered(const Capture& capture)
    {
        return std::ranges::count_if(capture.depth, [](float d) { return d < 1.0f; });
    }

    SceneModel model;
    std::vector<SceneModel::Item> items;
    std::vector<ItemId> all;
    std::unique_ptr<SceneRenderer> renderer;
};

TEST_F(GlRendererTest, NamesItsApiAndDriver)
{
    EXPECT_EQ(renderer->api().substr(0, 3), "gl ");
    EXPECT_GE(renderer->api(), "gl 3.3");
    EXPECT_FALSE(renderer->renderer_name().empty());
}

TEST_F(GlRendererTest, PictureShowsGroundSpheresAndBackground)
{
    const Capture capture = image_of(*renderer, all);
    EXPECT_EQ(capture.color.size, kSize);
    const auto pixel_count = static_cast<ptrdiff_t>(capture.depth.size());
    EXPECT_GT(covered(capture), pixel_count / 3);
    EXPECT_LT(covered(capture), pixel_count);
    const std::set<uint32_t> colors(capture.color.pixels.begin(), capture.color.pixels.end());
    EXPECT_GT(colors.size(), 100u) << "shaded, not flat";
    EXPECT_LT(capture.depth.front(), 1.0f) << "the ground is at the bottom";
    EXPECT_EQ(capture.depth.back(), 1.0f) << "the sky is at the top";
}

TEST_F(GlRendererTest, DepthFirstThenShadeEqualIsTheSamePicture)
{
    const Capture expected = image_of(*renderer, all);
    QueryDevice& device = renderer->device();
    device.begin_frame(test_view());
    device.draw(all, DrawPass::depth_only);
    device.draw(all, DrawPass::shade_equal);
    device.end_frame();
    expect_same(renderer->capture(), expected);
}

TEST_F(GlRendererTest, DepthOnlyWritesNoColour)
{
    QueryDevice& device = renderer->device();
    device.begin_frame(test_view());
    device.draw(all, DrawPass::depth_only);
    device.end_frame();
    const Capture capture = renderer->capture();
    EXPECT_GT(covered(capture), 0);
    EXPECT_EQ(std::ranges::count(capture.color.pixels, capture.color.pixels[0]),
              static_cast<ptrdiff_t>(capture.color.pixels.size()));
}

TEST_F(GlRendererTest, TestsBetweenDrawsChangeNothing)
{
    const Capture expected = image_of(*renderer, all);
    QueryDevice& device = renderer->device();
    const View view = test_view();
    device.begin_frame(view);
    for (size_t i = 0; i < all.size(); i += 10) {
        const size_t count = std::min<size_t>(10, all.size() - i);
        device.draw(std::span(all).subspan(i, count), DrawPass::shade);
        const QueryBox box{{{-3, 0, -3}, {3, 3, 3}}, nullptr, {}};
        const std::array<uint32_t, 1> ends{1};
        std::array<Ticket, 1> ticket;
        device.query({{&box, 1}, ends, TestMethod::automatic}, ticket);
        EXPECT_EQ(device.wait(ticket[0]).state, AnswerState::ready);
    }
    device.end_frame();
    expect_same(renderer->capture(), expected);
}

TEST_F(GlRendererTest, OldestOpenGlDrawsTheSamePicture)
{
    const Capture expected = image_of(*renderer, all);
    const auto ids = renderer->render_ids(test_view(), all);
    const auto old = make(1, {.max_gl_version = 33});
    ASSERT_TRUE(old);
    EXPECT_EQ(old->api(), "gl 3.3");
    expect_same(image_of(*old, all), expected);
    EXPECT_EQ(old->render_ids(test_view(), all), ids);
}

TEST_F(GlRendererTest, MergedRunsDrawWhatSingleItemsDraw)
{
    const Capture expected = image_of(*renderer, all);
    QueryDevice& device = renderer->device();
    device.begin_frame(test_view());
    for (const ItemId item : all) {
        device.draw({&item, 1}, DrawPass::shade);
    }
    device.end_frame();
    expect_same(renderer->capture(), expected);
}

TEST_F(GlRendererTest, OnlyTrianglesThatFollowEachOtherAreMerged)
{
    // Parts 1 and 3, and 4 before 3, of one sphere. The parts between must not be drawn.
    for (const std::array<uint32_t, 2>& parts : {std::array{2u, 4u}, std::array{5u, 4u}}) {
        const std::array<ItemId, 2> two{ItemId{parts[0]}, ItemId{parts[1]}};
        ASSERT_EQ(items[two[0].value].instance, items[two[1].value].instance);
        const std::vector<uint32_t> ids = renderer->render_ids(test_view(), two);
        const auto expected =
            static_cast<ptrdiff_t>(ids.size()) - std::ranges::count(ids, 0xffffffffu);
        EXPECT_GT(expected, 0);
        EXPECT_EQ(covered(image_of(*renderer, two)), expected);
    }
}

TEST_F(GlRendererTest, EachItemIsDrawnAlone)
{
    // The second part of an instance without the first. No other part may be drawn with it.
    const ItemId second{2u};
    ASSERT_EQ(items[2].part, 1u);
    const std::vector<uint32_t> ids = renderer->render_ids(test_view(), {&second, 1});
    const std::set<uint32_t> owners(ids.begin(), ids.end());
    EXPECT_EQ(owners, (std::set<uint32_t>{2u, 0xffffffffu}));
    const Capture capture = image_of(*renderer, {&second, 1});
    EXPECT_EQ(covered(capture),
              static_cast<ptrdiff_t>(ids.size()) - std::ranges::count(ids, 0xffffffffu));
}

TEST_F(GlRendererTest, OwnersAloneMakeTheWholePicture)
{
    const Capture expected = image_of(*renderer, all);
    const std::vector<uint32_t> ids = renderer->render_ids(test_view(), all);
    std::vector<ItemId> owners;
    for (const ItemId item : all) {
        if (std::ranges::count(ids, item.value) > 0) {
            owners.push_back(item);
        }
    }
    EXPECT_LT(owners.size(), all.size()) << "something is hidden";
    EXPECT_GT(owners.size(), all.size() / 4);
    expect_same(image_of(*renderer, owners), expected);
}

TEST_F(GlRendererTest, FirstOfEqualsOwnsThePixel)
{
    SceneModel twins;
    twins.meshes = {ground()};
    twins.instances = {{"a", 0, glm::mat4{1.0f}, {}}, {"b", 0, glm::mat4{1.0f}, {}}};
    const std::vector<SceneModel::Item> two{{0, 0}, {1, 0}};
    auto made = make_gl_renderer(twins, two, kSize, 1);
    ASSERT_TRUE(made);
    const std::array<ItemId, 2> order{ItemId{1u}, ItemId{0u}};
    const std::vector<uint32_t> ids = (*made)->render_ids(test_view(), order);
    EXPECT_GT(std::ranges::count(ids, 1u), 0);
    EXPECT_EQ(std::ranges::count(ids, 0u), 0);
}

TEST_F(GlRendererTest, ItemColorsOverrideAndGoBack)
{
    const Capture expected = image_of(*renderer, all);
    std::vector<glm::vec4> colors(items.size(), glm::vec4{0, 1, 0, 1});
    colors[0] = {1, 0, 0, 1};
    renderer->set_item_colors(colors);
    const Capture colored = image_of(*renderer, all);
    EXPECT_EQ(colored.depth, expected.depth);
    const std::vector<uint32_t> ids = renderer->render_ids(test_view(), all);
    for (size_t i = 0; i < ids.size(); ++i) {
        const uint32_t pixel = colored.color.pixels[i];
        if (ids[i] == 0) {
            ASSERT_GT(pixel & 0xffu, 0u);
            ASSERT_EQ(pixel & 0xffff00u, 0u);
        } else if (ids[i] != 0xffffffffu) {
            ASSERT_EQ(pixel & 0xff00ffu, 0u);
        }
    }
    renderer->set_item_colors({});
    expect_same(image_of(*renderer, all), expected);
}

TEST_F(GlRendererTest, MovedInstancesAreDrawnWhereTheyAre)
{
    const Capture before = image_of(*renderer, all);
    for (Instance& instance : model.instances) {
        instance.world_from_mesh =
            glm::translate(glm::mat4{1.0f}, {0.5f, 0.0f, 0.25f}) * instance.world_from_mesh;
    }
    std::vector<glm::mat4> transforms;
    for (const Instance& instance : model.instances) {
        transforms.push_back(instance.world_from_mesh);
    }
    renderer->update_transforms(transforms);
    const Capture moved = image_of(*renderer, all);
    EXPECT_GT(count_differences(before.color, moved.color), 100u);
    const auto fresh = make(1);
    expect_same(moved, image_of(*fresh, all));
    EXPECT_EQ(renderer->render_ids(test_view(), all), fresh->render_ids(test_view(), all));
}

TEST_F(GlRendererTest, LinesAreHiddenByGeometryUnlessOnTop)
{
    const Capture before = image_of(*renderer, all);
    const std::array<glm::vec3, 2> under_ground{glm::vec3{-5, -1, 0}, glm::vec3{5, -1, 0}};
    renderer->draw_lines(test_view(), under_ground, {1, 0, 0, 1}, false);
    expect_same(renderer->capture(), before);
    renderer->draw_lines(test_view(), under_ground, {1, 0, 0, 1}, true);
    const Capture on_top = renderer->capture();
    EXPECT_GT(count_differences(on_top.color, before.color), 30u);
    EXPECT_EQ(on_top.depth, before.depth);
    const std::array<glm::vec3, 2> above{glm::vec3{-5, 2.5f, 4}, glm::vec3{5, 2.5f, 4}};
    image_of(*renderer, all);
    renderer->draw_lines(test_view(), above, {1, 0, 0, 1}, false);
    EXPECT_GT(count_differences(renderer->capture().color, before.color), 30u);
    expect_same(image_of(*renderer, all), before);
}

TEST_F(GlRendererTest, MultisampledPicturesAreSmootherAndRepeatable)
{
    const auto smooth = make(4);
    ASSERT_TRUE(smooth);
    const Capture first = image_of(*smooth, all);
    expect_same(image_of(*smooth, all), first);
    const uint64_t differing = count_differences(first.color, image_of(*renderer, all).color);
    EXPECT_GT(differing, 50u) << "edges";
    EXPECT_LT(differing, first.color.pixels.size() / 2);
    QueryDevice& device = smooth->device();
    device.begin_frame(test_view());
    device.draw(all, DrawPass::depth_only);
    device.draw(all, DrawPass::shade_equal);
    device.end_frame();
    expect_same(smooth->capture(), first);
}

TEST_F(GlRendererTest, ConventionsOfDepthDrawTheSamePicture)
{
    const Capture expected = image_of(*renderer, all);
    for (const ClipConvention convention :
         {ClipConvention{DepthRange::zero_to_one, DepthOrder::near_is_small},
          ClipConvention{DepthRange::zero_to_one, DepthOrder::near_is_large}}) {
        const Capture other = image_of(*renderer, all, test_view(kSize, convention));
        // A different rounding of depth may decide single pixels where surfaces cross.
        EXPECT_LE(count_differences(other.color, expected.color), 5u);
    }
}

TEST_F(GlRendererTest, ResizeChangesTheTargetAndRefusesNonsense)
{
    const auto resized = renderer->resize({64, 32}, 1);
    ASSERT_TRUE(resized) << resized.error().message;
    const View view = test_view({64, 32});
    EXPECT_EQ(image_of(*renderer, all, view).color.size, glm::ivec2(64, 32));
    EXPECT_EQ(renderer->render_ids(view, all).size(), 64u * 32u);
    for (const glm::ivec2 wrong : {glm::ivec2{0, 5}, glm::ivec2{5, -1}, glm::ivec2{1 << 24, 4}}) {
        EXPECT_FALSE(renderer->resize(wrong, 1));
    }
    const auto samples = renderer->resize({64, 32}, 1000);
    ASSERT_FALSE(samples);
    EXPECT_NE(samples.error().message.find("1000"), std::string::npos);
    EXPECT_FALSE(renderer->resize({64, 32}, 0));
    EXPECT_EQ(image_of(*renderer, all, view).color.size, glm::ivec2(64, 32)) << "the old one stays";
}

TEST_F(GlRendererTest, TwoRenderersTakeTurns)
{
    const auto other = make(1);
    ASSERT_TRUE(other);
    const Capture expected = image_of(*renderer, all);
    for (int i = 0; i < 3; ++i) {
        expect_same(image_of(*other, all), expected);
        expect_same(image_of(*renderer, all), expected);
    }
}

TEST_F(GlRendererTest, WarmUpLeavesTheNextFrameAsItIs)
{
    const auto warm = make(4);
    ASSERT_TRUE(warm);
    warm->warm_up();
    warm->finish();
    const Capture expected = image_of(*make(4), all);
    expect_same(image_of(*warm, all), expected);
}

TEST_F(GlRendererTest, HiddenSpheresAreFoundHidden)
{
    // Every sphere's box against the ground, from below: all are hidden.
    const View below = View::from_clip(
        glm::perspectiveRH_NO(1.0f, 1.0f, 0.1f, 100.0f) *
            glm::lookAt(glm::vec3{0, -4, 3}, glm::vec3{0, 0, -3}, glm::vec3{0, 1, 0}),
        kSize);
    QueryDevice& device = renderer->device();
    const ItemId ground_item{0u};
    device.begin_frame(below);
    device.draw({&ground_item, 1}, DrawPass::shade);
    const std::array<QueryBox, 2> boxes{
        {{{{-3, 0.5f, -3}, {3, 2, 0}}, nullptr, {}}, {{{-3, -0.5f, -3}, {3, 2, 0}}, nullptr, {}}}};
    const std::array<uint32_t, 2> ends{1, 2};
    std::array<Ticket, 2> tickets;
    device.query({boxes, ends, TestMethod::automatic}, tickets);
    EXPECT_EQ(device.wait(tickets[0]).samples, 0u);
    EXPECT_GT(device.wait(tickets[1]).samples, 0u);
    device.end_frame();
}

TEST(GlRendererScenes, EmptySceneIsAllBackground)
{
    const SceneModel empty;
    auto made = make_gl_renderer(empty, {}, {8, 4}, 1);
    ASSERT_TRUE(made) << made.error().message;
    (*made)->warm_up();
    (*made)->render(test_view({8, 4}), {});
    EXPECT_EQ((*made)->capture().depth, std::vector<float>(32, 1.0f));
    EXPECT_EQ((*made)->render_ids(test_view({8, 4}), {}), std::vector<uint32_t>(32, 0xffffffffu));
}

} // namespace
} // namespace occlude::tools