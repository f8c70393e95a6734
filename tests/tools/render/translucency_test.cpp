// Translucent items from the material to the image, on both renderers.
#include "tools/tiny_scenes.h"

#include "measure/verify.h"
#include "render/gl_renderer.h"

#include <gtest/gtest.h>

#include <set>

namespace occlude::tools {

using namespace test;

namespace {

constexpr glm::ivec2 kSize{48, 32};

// The wall with two panes before it that overlap (items 6, nearer, and 7), and one behind it (8).
SceneModel glass_model()
{
    SceneModel model = wall_model();
    add_quad(model, {-3.0f, -2.0f}, {1.0f, 2.0f}, -3.5f, {0.9f, 0.1f, 0.1f});
    add_quad(model, {-1.0f, -2.0f}, {3.0f, 2.0f}, -3.8f, {0.1f, 0.1f, 0.9f});
    add_quad(model, {-1.0f, -1.0f}, {1.0f, 1.0f}, -8.0f, {0.1f, 0.9f, 0.1f});
    for (const size_t pane : {6u, 7u, 8u}) {
        model.instances[pane].opacity = 0.5f;
    }
    return model;
}

struct GlassStage {
    explicit GlassStage(const std::string& renderer_name)
        : model(glass_model())
        , scene(make_cull_scene(model))
        , hierarchy(build_bvh(scene.scene.item_bounds(), {.leaf_triangles = 0}))
        , renderer(
              std::move(*(renderer_name == "gl" ? make_gl_renderer(model, scene.items, kSize, 1)
                                                : make_cpu_renderer(model, scene.items, kSize))))
    {
    }
    Stage stage() { return {hierarchy, scene.scene.item_bounds(), *renderer}; }

    Capture drawn(std::vector<uint32_t> items)
    {
        std::vector<ItemId> ids;
        for (const uint32_t item : items) {
            ids.push_back(ItemId{item});
        }
        renderer->render(look_along_z(), ids);
        return renderer->capture();
    }

    SceneModel model;
    CullScene scene;
    Hierarchy hierarchy;
    std::unique_ptr<SceneRenderer> renderer;
};

class Translucency : public ::testing::TestWithParam<std::string> {
protected:
    static constexpr size_t kMiddle = 16 * 48 + 24; ///< where both panes are

    GlassStage made{GetParam()};
};

INSTANTIATE_TEST_SUITE_P(OnBothRenderers, Translucency, ::testing::Values("cpu", "gl"));

TEST_P(Translucency, APaneMixesItsColourWithWhatIsBehindAndWritesNoDepth)
{
    const Capture wall = made.drawn({0});
    const Capture seen = made.drawn({0, 6});
    EXPECT_EQ(seen.depth, wall.depth);
    GlassStage opaque(GetParam());
    opaque.model.instances[6].opacity = 1.0f;
    const auto renderer = std::move(
        *(GetParam() == "gl" ? make_gl_renderer(opaque.model, opaque.scene.items, kSize, 1)
                             : make_cpu_renderer(opaque.model, opaque.scene.items, kSize)));
    const std::vector<ItemId> pane{ItemId{6u}};
    renderer->render(look_along_z(), pane);
    const uint32_t pane_color = renderer->capture().color.pixels[kMiddle];
    for (int shift = 0; shift < 24; shift += 8) {
        const auto channel = [shift](uint32_t pixel) {
            return static_cast<double>((pixel >> shift) & 0xffu);
        };
        EXPECT_NEAR(channel(seen.color.pixels[kMiddle]),
                    0.5 * (channel(wall.color.pixels[kMiddle]) + channel(pane_color)), 1.0);
    }
}

TEST_P(Translucency, TheOrderOfPanesShowsAndTheHiddenPaneDoesNot)
{
    const Capture back_to_front = made.drawn({0, 7, 6});
    EXPECT_NE(back_to_front.color.pixels, made.drawn({0, 6, 7}).color.pixels);
    EXPECT_EQ(back_to_front.color.pixels, made.drawn({0, 8, 7, 6}).color.pixels);
}

TEST_P(Translucency, PanesOwnNoPixels)
{
    const std::vector<ItemId> items{ItemId{0u}, ItemId{6u}, ItemId{7u}};
    const std::vector<uint32_t> ids = made.renderer->render_ids(look_along_z(), items);
    const std::set<uint32_t> owners(ids.begin(), ids.end());
    EXPECT_TRUE(owners.contains(0u));
    EXPECT_FALSE(owners.contains(6u) || owners.contains(7u));
}

TEST_P(Translucency, PanesWriteNothingInADepthOnlyPassNorInItsShading)
{
    QueryDevice& device = made.renderer->device();
    const std::vector<ItemId> items{ItemId{0u}, ItemId{6u}};
    device.begin_frame(look_along_z());
    device.draw(items, DrawPass::depth_only);
    device.draw(items, DrawPass::shade_equal);
    device.end_frame();
    const Capture drawn = made.renderer->capture();
    const Capture wall = made.drawn({0});
    EXPECT_EQ(drawn.depth, wall.depth);
    EXPECT_EQ(drawn.color.pixels, wall.color.pixels);
}

TEST_P(Translucency, EveryExactAlgorithmDrawsTheReferenceImage)
{
    std::vector<Contender> contenders;
    for (const AlgorithmInfo& info : algorithms()) {
        if (info.exact) {
            contenders.push_back(registered(info.name));
        }
    }
    std::vector<View> views;
    for (int i = 0; i < 6; ++i) {
        const auto t = static_cast<float>(i);
        views.push_back(look_along_z({0.3f * t - 0.8f, 0.1f * t, 0.2f * t}, 3.0f * t));
    }
    const auto runs = verify(made.stage(), contenders, views, {});
    ASSERT_TRUE(runs) << runs.error().message;
    for (const AlgorithmRun& run : *runs) {
        for (const FrameFigures& frame : run.frames) {
            EXPECT_EQ(frame.verdict->differing_pixels, 0u) << run.algorithm;
        }
    }
}

TEST_P(Translucency, AMissingPaneIsFound)
{
    const std::vector<Contender> contenders{dropping(ItemId{6u})};
    const std::vector<View> views{look_along_z()};
    const auto runs = verify(made.stage(), contenders, views, {});
    ASSERT_TRUE(runs);
    EXPECT_GT((*runs)[0].frames[0].verdict->differing_pixels, 50u);
}

} // namespace
} // namespace occlude::tools
