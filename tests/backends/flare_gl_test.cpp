// Lens flares on OpenGL, where a flat box counts each sample of both its faces.
#include "backends/gl_fixture.h"

#include "support/flare_walk.h"

namespace occlude {
namespace {

constexpr glm::ivec2 kScreen{128, 96};

class FlareGlTest : public GlFixture {
protected:
    // Slides a wall past the lights. Returns the worst difference from the exact visible share.
    double worst_error()
    {
        make_scene(kScreen, 1);
        std::vector<ItemId> walls; // one per frame, since this engine's items do not move
        for (int frame = 0; frame < 80; ++frame) {
            const float x = -45.0f + static_cast<float>(frame);
            walls.push_back(scene->add_quad({x, -30.0f}, {x + 12.0f, 30.0f}, -20.0f));
        }
        const View view = test::look({0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -1.0f}, kScreen);
        const std::vector<FlareLight> lights = test::walk_lights();
        FlareVisibility flares({.max_latency = 1});
        flares.set_lights(lights);
        std::vector<double> expected;
        double worst = 0.0;
        for (const ItemId wall : walls) {
            device->begin_frame(view);
            flares.begin_frame(view, *device);
            draw(wall);
            flares.end_frame(*device);
            device->end_frame();
            for (size_t i = 0; i < expected.size(); ++i) {
                worst = std::max(worst, std::abs(flares.fraction(i) - expected[i]));
                partly_ += expected[i] > 0.0 && expected[i] < 1.0 ? 1 : 0;
            }
            const std::vector<float> depth = depths(kScreen);
            expected.clear();
            for (const FlareLight& light : lights) {
                expected.push_back(test::exact_fraction(
                    depth, kScreen, test::pixel_of(view, light.position_world),
                    double{light.radius_px}, test::depth01_of(view, light.position_world)));
            }
        }
        return worst;
    }

    int partly_ = 0;
};

TEST_F(FlareGlTest, FractionsAreExactToTwoPercentWhileAWallSlidesPast)
{
    EXPECT_LE(worst_error(), 0.02);
    EXPECT_GT(partly_, 40); // the wall covers discs in part, so that there is something to measure
}

TEST_F(FlareGlTest, WithFourSamplesPerPixelTheRatioIsTheSame)
{
    make_scene(kScreen, 4);
    const ItemId half = scene->add_quad({0.0f, -30.0f}, {30.0f, 30.0f}, -20.0f);
    const View view = test::look({0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -1.0f}, kScreen);
    FlareVisibility flares({.max_latency = 1});
    // The first is cut in half, the second is hidden, the third is visible.
    const std::vector<FlareLight> lights{{{0.0f, 0.0f, -40.0f, 1.0f}, 12.0f},
                                         {{20.0f, 0.0f, -40.0f, 1.0f}, 12.0f},
                                         {{-20.0f, 0.0f, -40.0f, 1.0f}, 12.0f}};
    flares.set_lights(lights);
    for (int frame = 0; frame < 2; ++frame) {
        device->begin_frame(view);
        flares.begin_frame(view, *device);
        draw(half);
        flares.end_frame(*device);
        device->end_frame();
    }
    EXPECT_NEAR(flares.fraction(0), 0.5, 0.02);
    EXPECT_EQ(flares.fraction(1), 0.0);
    EXPECT_EQ(flares.fraction(2), 1.0);
}

} // namespace
} // namespace occlude
