#include <occlude/effects/flare_visibility.h>

#include "support/flare_walk.h"

#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/cull/frustum_culler.h>
#include <occlude/device/delaying_device.h>
#include <occlude/device/flare_device.h>
#include <occlude/device/scripted_device.h>
#include <occlude/device/validating_device.h>

#include <gtest/gtest.h>

#include <array>

namespace occlude {
namespace {

using test::look_ahead;

constexpr glm::ivec2 kSize{128, 96};

View camera()
{
    return test::look({0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -1.0f}, kSize);
}

// A slanted wall that slides along x, in one triangle pair: item 0.
class SlidingWall final : public CpuScene {
public:
    void slide_to(float x)
    {
        corners_ = {glm::vec3{x, -30.0f, -20.0f}, glm::vec3{x + 12.0f, -30.0f, -20.0f},
                    glm::vec3{x + 20.0f, 30.0f, -20.0f}, glm::vec3{x + 8.0f, 30.0f, -20.0f}};
    }
    Aabb box() const { return merge({corners_[0], corners_[2]}, {corners_[0], corners_[2]}); }
    CpuItem item(ItemId) const override
    {
        static const std::vector<uint32_t> kIndices{0, 1, 2, 0, 2, 3};
        return {.positions = corners_, .indices = kIndices};
    }

private:
    std::array<glm::vec3, 4> corners_{};
};

void draw_frame(QueryDevice& device, FlareVisibility& flares, const View& view)
{
    const std::array items{ItemId{0u}};
    device.begin_frame(view);
    flares.begin_frame(view, device);
    device.draw(items, DrawPass::shade);
    flares.end_frame(device);
    device.end_frame();
}

TEST(FlareVisibility, IsTheExactFractionOfVisiblePixelsOfTheLastFrame)
{
    SlidingWall wall;
    CpuDevice cpu(wall);
    ValidatingDevice device(cpu); // asserts the contract
    const std::vector<FlareLight> lights = test::walk_lights();
    FlareVisibility flares;
    flares.set_lights(lights);
    const View view = camera();
    std::vector<double> expected;
    std::vector<int> partly(lights.size(), 0);
    double worst = 0.0;
    for (int frame = 0; frame < 160; ++frame) {
        wall.slide_to(-45.0f + 0.5f * static_cast<float>(frame));
        draw_frame(device, flares, view);
        for (size_t i = 0; i < expected.size(); ++i) {
            worst = std::max(worst, std::abs(flares.fraction(i) - expected[i]));
            partly[i] += expected[i] > 0.0 && expected[i] < 1.0 ? 1 : 0;
        }
        expected.clear();
        for (const FlareLight& light : lights) {
            expected.push_back(test::exact_fraction(
                cpu.depth(), kSize, test::pixel_of(view, light.position_world),
                double{light.radius_px}, test::depth01_of(view, light.position_world)));
        }
    }
    EXPECT_LE(worst, 0.02);
    for (const size_t i : {0u, 1u, 3u, 4u}) {
        EXPECT_GT(partly[i], 5) << "light " << i; // the wall did slide past
    }
    EXPECT_EQ(partly[2], 0); // it stands before the wall
}

TEST(FlareVisibility, DoesNotBlinkWhileAnOccluderSlidesPast)
{
    SlidingWall wall;
    CpuDevice device(wall);
    FlareVisibility flares;
    flares.set_lights(test::walk_lights());
    int turns = 0;
    double last = 1.0;
    bool falling = true;
    for (int frame = 0; frame < 320; ++frame) {
        wall.slide_to(-45.0f + 0.25f * static_cast<float>(frame));
        draw_frame(device, flares, camera());
        if (frame < 2) {
            last = flares.brightness(0);
            continue;
        }
        const double now = flares.brightness(0);
        EXPECT_LT(std::abs(now - last), 0.12) << "frame " << frame;
        if (std::abs(now - last) > 1e-9 && (now < last) != falling) {
            falling = !falling;
            ++turns;
        }
        last = now;
    }
    EXPECT_EQ(turns, 1); // dark once, bright again
    EXPECT_GT(last, 0.99);
}

TEST(FlareVisibility, FadesOutWhileItsLightLeavesTheScreen)
{
    const View view = camera();
    std::vector<double> shares;
    for (int step = 0; step <= 40; ++step) {
        // At depth 30 the screen's right edge is at x = 40.
        const FlareLight light{{36.0f + 0.2f * static_cast<float>(step), 0.0f, -30.0f, 1.0f}, 6.0f};
        shares.push_back(make_flare_disc(view, light).on_screen);
    }
    EXPECT_EQ(shares.front(), 1.0);
    EXPECT_EQ(shares.back(), 0.0);
    EXPECT_NEAR(shares[20], 0.5, 0.02); // its centre on the edge
    EXPECT_TRUE(std::is_sorted(shares.rbegin(), shares.rend()));
}

TEST(FlareVisibility, ALightBehindTheCameraOrOffTheScreenIsDarkAndAsksNothing)
{
    ScriptedDevice device;
    FlareVisibility flares;
    const std::array lights{FlareLight{{0.0f, 0.0f, 10.0f, 1.0f}},
                            FlareLight{{0.0f, 0.0f, 1.0f, 0.0f}},
                            FlareLight{{90.0f, 0.0f, -10.0f, 1.0f}}};
    flares.set_lights(lights);
    for (int frame = 0; frame < 3; ++frame) {
        draw_frame(device, flares, look_ahead());
    }
    EXPECT_EQ(device.frame_text(1), "draw 0\n");
    for (size_t i = 0; i < lights.size(); ++i) {
        EXPECT_EQ(flares.fraction(i), 0.0);
    }
}

TEST(FlareVisibility, ALightAtTheNearPlaneIsSeenUntested)
{
    ScriptedDevice device({.boxes = [](auto) { return uint64_t{0}; }});
    FlareVisibility flares;
    const std::array lights{FlareLight{{0.0f, 0.0f, -0.1f, 1.0f}}};
    flares.set_lights(lights);
    draw_frame(device, flares, look_ahead());
    draw_frame(device, flares, look_ahead());
    EXPECT_EQ(flares.fraction(0), 1.0);
}

TEST(FlareVisibility, AllLightsAreTestedInOneBatchAndReadInTheNextFrame)
{
    ScriptedDevice device({.boxes = [](auto boxes) { return 10 * boxes.size(); }});
    FlareVisibility flares;
    const std::array lights{FlareLight{{0.0f, 0.0f, -40.0f, 1.0f}, 2.0f},
                            FlareLight{{5.0f, 0.0f, -40.0f, 1.0f}, 2.0f}};
    flares.set_lights(lights);
    draw_frame(device, flares, look_ahead());
    const auto& trace = device.trace();
    std::vector<size_t> tests_per_batch;
    for (const auto& event : trace) {
        if (event.verb == ScriptedDevice::Verb::query) {
            tests_per_batch.push_back(event.test_ends.size());
        }
    }
    EXPECT_EQ(tests_per_batch, (std::vector<size_t>{2, 2})); // the references, then the tests
    EXPECT_EQ(flares.fraction(0), 0.0);
    draw_frame(device, flares, look_ahead());
    EXPECT_EQ(flares.fraction(0), 1.0);
}

TEST(FlareVisibility, LateAnswersKeepTheOldValueAndLostOnesToo)
{
    SlidingWall wall;
    wall.slide_to(100.0f);
    CpuDevice cpu(wall);
    DelayingDevice late(cpu, {.seed = 5, .min_frames = 2, .max_frames = 2});
    FlareVisibility flares;
    const std::array lights{FlareLight{{0.0f, 0.0f, -40.0f, 1.0f}}};
    flares.set_lights(lights);
    std::vector<double> fractions;
    for (int frame = 0; frame < 6; ++frame) {
        draw_frame(late, flares, camera());
        fractions.push_back(flares.fraction(0));
    }
    EXPECT_EQ(fractions[1], 0.0);
    EXPECT_EQ(fractions[2], 1.0);
    EXPECT_EQ(fractions[5], 1.0);

    DelayingDevice losing(cpu, {.seed = 5, .lose_every = 1});
    draw_frame(losing, flares, camera());
    draw_frame(losing, flares, camera());
    EXPECT_EQ(flares.fraction(0), 1.0);
}

TEST(FlareVisibility, TimeComesFromTheClock)
{
    SlidingWall wall;
    wall.slide_to(100.0f);
    CpuDevice device(wall);
    double now = 0.0;
    FlareVisibility flares({.fade_time = 1.0, .clock = [&] { return now; }});
    const std::array lights{FlareLight{{0.0f, 0.0f, -40.0f, 1.0f}}};
    flares.set_lights(lights);
    draw_frame(device, flares, camera());
    draw_frame(device, flares, camera());
    EXPECT_EQ(flares.brightness(0), 1.0); // the first answer counts at once
    wall.slide_to(-10.0f);
    draw_frame(device, flares, camera());
    draw_frame(device, flares, camera());
    EXPECT_EQ(flares.fraction(0), 0.0);
    EXPECT_EQ(flares.brightness(0), 1.0); // no time has passed
    now += std::log(2.0);
    draw_frame(device, flares, camera());
    EXPECT_NEAR(flares.brightness(0), 0.5, 1e-9);
    flares.reset();
    EXPECT_EQ(flares.brightness(0), 0.0);
}

TEST(FlareVisibility, WorksAroundACullerThroughAFlareDevice)
{
    SlidingWall wall;
    wall.slide_to(100.0f);
    CpuDevice cpu(wall);
    FlareVisibility flares;
    const std::array lights{FlareLight{{0.0f, 0.0f, -40.0f, 1.0f}}};
    flares.set_lights(lights);
    FlareDevice device(cpu, flares);
    const std::vector<ItemBounds> bounds{{{{-50.0f, -30.0f, -21.0f}, {50.0f, 30.0f, -19.0f}}, 2}};
    const Hierarchy tree = build_bvh(bounds);
    FrustumCuller culler{tree};
    culler.cull(camera(), device);
    culler.cull(camera(), device);
    EXPECT_EQ(flares.fraction(0), 1.0);
    wall.slide_to(-10.0f);
    culler.cull(camera(), device);
    culler.cull(camera(), device);
    EXPECT_EQ(flares.fraction(0), 0.0);
}

TEST(FlareDisc, CoversThePixelsOfTheDiscInEveryProjection)
{
    SlidingWall nothing;
    CpuDevice device(nothing);
    const glm::mat4 eye = glm::lookAtRH(glm::vec3{3.0f, 2.0f, 5.0f}, glm::vec3{-2.0f, 1.0f, -9.0f},
                                        glm::vec3{0.1f, 1.0f, 0.0f});
    const std::array projections{
        View::from_clip(glm::perspectiveRH_NO(1.2f, 4.0f / 3.0f, 0.1f, 100.0f) * eye, kSize),
        View::from_clip(glm::perspectiveRH_ZO(1.2f, 4.0f / 3.0f, 0.1f, 100.0f) * eye, kSize,
                        {DepthRange::zero_to_one, DepthOrder::near_is_small}),
        View::from_clip(glm::perspectiveRH_ZO(1.2f, 4.0f / 3.0f, 100.0f, 0.1f) * eye, kSize,
                        {DepthRange::zero_to_one, DepthOrder::near_is_large}),
        View::from_clip(glm::infinitePerspectiveRH(1.2f, 4.0f / 3.0f, 0.1f) * eye, kSize),
        View::from_clip(glm::frustumRH_NO(-0.1f, 0.06f, -0.02f, 0.09f, 0.1f, 100.0f) * eye, kSize),
        View::from_clip(glm::orthoRH_NO(-8.0f, 8.0f, -6.0f, 6.0f, 0.1f, 100.0f) * eye, kSize)};
    for (const View& view : projections) {
        const FlareLight light{{-1.5f, 1.0f, -8.0f, 1.0f}, 10.0f};
        const FlareDisc disc = make_flare_disc(view, light);
        ASSERT_FALSE(disc.strips.empty());
        EXPECT_EQ(disc.on_screen, 1.0);
        std::vector<QueryBox> boxes;
        for (const Aabb& strip : disc.strips) {
            boxes.push_back({strip, &disc.world_from_disc, NodeId{}});
        }
        const auto end = static_cast<uint32_t>(boxes.size());
        Ticket ticket;
        device.begin_frame(view);
        device.query({boxes, {&end, 1}, TestMethod::automatic}, {&ticket, 1});
        const double pixels = static_cast<double>(device.wait(ticket).samples);
        device.end_frame();
        EXPECT_NEAR(pixels, 314.159, 6.0);
    }
}

// Light and box lie where floats are coarse, and the eye lies between two floats.
TEST(FlareDisc, CoversThePixelsOfTheDiscFarFromTheOrigin)
{
    SlidingWall nothing;
    CpuDevice device(nothing);
    const glm::dvec3 eye{1e7 + 0.375, -3e6 + 0.25, 2e6 - 0.4375};
    const View view =
        View::camera_relative(glm::perspectiveRH_NO(1.2f, 4.0f / 3.0f, 0.1f, 100.0f), eye, kSize);
    const FlareLight light{glm::vec4{glm::vec3{eye + glm::dvec3{-3.0, 2.0, -20.0}}, 1.0f}, 10.0f};
    const FlareDisc disc = make_flare_disc(view, light);
    ASSERT_FALSE(disc.strips.empty());
    EXPECT_EQ(disc.on_screen, 1.0);
    const glm::dvec3 relative = glm::dvec3{light.position_world} - eye;
    const glm::dvec4 clip = view.clip_from_relative() * glm::dvec4{relative, 1.0};
    const glm::dvec4 center =
        view.clip_from_relative() * glm::dvec4{glm::dvec3{disc.world_from_disc[3]} - eye, 1.0};
    EXPECT_NEAR(center.x / center.w, clip.x / clip.w, 1e-6);
    EXPECT_NEAR(center.y / center.w, clip.y / clip.w, 1e-6);
    std::vector<QueryBox> boxes;
    for (const Aabb& strip : disc.strips) {
        boxes.push_back({strip, &disc.world_from_disc, NodeId{}});
    }
    const auto end = static_cast<uint32_t>(boxes.size());
    Ticket ticket;
    device.begin_frame(view);
    device.query({boxes, {&end, 1}, TestMethod::automatic}, {&ticket, 1});
    EXPECT_NEAR(static_cast<double>(device.wait(ticket).samples), 314.159, 6.0);
    device.end_frame();
    EXPECT_NEAR(flare_radius_px(view, glm::vec3{light.position_world}, 2.0f, 1.0f, 50.0f),
                2.0 * 0.5 * kSize.y / std::tan(0.6) / -relative.z, 1e-3);
}

TEST(FlareDisc, LargeDiscsHaveFewStripsAndOddViewsNone)
{
    const FlareLight light{{0.0f, 0.0f, -10.0f, 1.0f}, 45.0f};
    EXPECT_LE(make_flare_disc(camera(), {light.position_world, 400.0f}).strips.size(),
              size_t{kMaxFlareStrips});
    EXPECT_TRUE(make_flare_disc(View::from_clip(glm::mat4{0.0f}, kSize), light).strips.empty());
    EXPECT_TRUE(make_flare_disc(View{}, light).strips.empty());
}

TEST(FlareRadius, FollowsTheSizeOnTheScreen)
{
    const View view = camera(); // 48 pixels per unit at depth 1
    EXPECT_NEAR(flare_radius_px(view, {0.0f, 0.0f, -10.0f}, 2.0f, 1.0f, 50.0f), 9.6f, 1e-3f);
    EXPECT_EQ(flare_radius_px(view, {0.0f, 0.0f, -1000.0f}, 2.0f, 1.0f, 50.0f), 1.0f);
    EXPECT_EQ(flare_radius_px(view, {0.0f, 0.0f, -0.5f}, 2.0f, 1.0f, 50.0f), 50.0f);
    EXPECT_EQ(flare_radius_px(view, {0.0f, 0.0f, 5.0f}, 2.0f, 1.0f, 50.0f), 1.0f);
}

} // namespace
} // namespace occlude
