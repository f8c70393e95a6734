// Where the view lies in the target: any viewport, origin and part of the depth buffer.
#include "backends/gl_fixture.h"

#include <occlude/core/rng.h>
#include <occlude/cull/registry.h>
#include <occlude/hierarchy/builders/bvh_builder.h>
#include <occlude/screen/depth_tiles.h>

#include <algorithm>

namespace occlude {
namespace {

constexpr glm::ivec2 kViewSize{32, 32};
constexpr float kStep = 0x1p-22f;
const View kSmallView = View::from_clip(glm::mat4{1.0f}, kViewSize);

// Left of the middle and right of it, behind z = 0.3.
constexpr Aabb kLeftBox{{-0.75f, -0.75f, 0.4f}, {-0.25f, 0.75f, 0.6f}};
constexpr Aabb kRightBox{{0.25f, -0.75f, 0.4f}, {0.75f, 0.75f, 0.6f}};
constexpr Aabb kLowBox{{-0.75f, -0.75f, 0.4f}, {-0.25f, -0.25f, 0.6f}};
constexpr Aabb kHighBox{{-0.75f, 0.25f, 0.4f}, {-0.25f, 0.75f, 0.6f}};

class GlTargetTest : public GlFixture {
protected:
    glm::ivec2 view_size = kViewSize;

    uint64_t samples_of(const Aabb& box, TestMethod method)
    {
        const QueryBox query{box, nullptr, {}};
        const uint32_t end = 1;
        Ticket ticket;
        device->query({{&query, 1}, {&end, 1}, method}, {&ticket, 1});
        const Answer answer = device->wait(ticket);
        EXPECT_EQ(answer.state, AnswerState::ready) << name(method);
        return answer.samples;
    }

    // For every tile size, a tile is the farthest of the pixels that read_depth gives, or farther
    // by rounding: shaders and reads convert the whole numbers of a 24-bit buffer differently.
    void expect_tiles_of(const std::vector<float>& depth)
    {
        for (const DepthReadCost& read : device->caps().depth_reads) {
            if (read.tile_px == 1) {
                continue;
            }
            const glm::ivec2 count = tiles_in(view_size, read.tile_px);
            std::vector<float> expected(static_cast<size_t>(count.x * count.y));
            farthest_of_tiles(depth, view_size, read.tile_px, expected);
            std::vector<float> tiles(expected.size(), -1.0f);
            EXPECT_TRUE(device->read_depth_tiles(read.tile_px, tiles));
            for (size_t i = 0; i < tiles.size(); ++i) {
                EXPECT_GE(tiles[i], expected[i]) << read.tile_px;
                EXPECT_LE(tiles[i], expected[i] + kStep) << read.tile_px;
            }
        }
    }

    // Draws a quad over the lower left quarter of the view and reads its depth with every method.
    void expect_lower_left_quarter(float tolerance = 0.0f)
    {
        const ItemId quad = scene->add_quad(kLow, {0.0f, 0.0f}, 0.0f);
        device->begin_frame(kSmallView);
        draw(quad);
        const std::vector<float> depth = depths(kViewSize);
        int wrong = 0;
        for (int y = 0; y < kViewSize.y; ++y) {
            for (int x = 0; x < kViewSize.x; ++x) {
                const float d = depth[static_cast<size_t>(y * kViewSize.x + x)];
                const bool covered = x < 16 && y < 16;
                wrong += covered ? d < 0.5f || d > 0.5f + tolerance : d != 1.0f;
            }
        }
        EXPECT_EQ(wrong, 0) << "pixels";
        expect_tiles_of(depth);
        for (const TestCost& cost : device->caps().methods) {
            EXPECT_EQ(samples_of(kLowBox, cost.method), 0u) << name(cost.method);
            EXPECT_GT(samples_of(kHighBox, cost.method), 0u) << name(cost.method);
            EXPECT_GT(samples_of(kLeftBox, cost.method), 0u) << name(cost.method);
            EXPECT_GT(samples_of(kRightBox, cost.method), 0u) << name(cost.method);
        }
        device->end_frame();
        EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    }
};

TEST_F(GlTargetTest, AViewportAnywhereInTheTargetIsReadAndTestedThere)
{
    for (const int samples : {1, 4}) {
        make_scene(kSize, samples);
        scene->after_begin = [] { glViewport(24, 8, 32, 32); };
        expect_lower_left_quarter();
    }
}

TEST_F(GlTargetTest, AnOriginAtTheUpperLeftIsReadFromTheBottomOfTheView)
{
    for (const int samples : {1, 4}) {
        make_scene(kSize, samples);
        scene->after_begin = [] {
            glViewport(24, 8, 32, 32);
            glClipControl(GL_UPPER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
        };
        expect_lower_left_quarter();
    }
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
}

TEST_F(GlTargetTest, APartOfTheDepthBufferIsTheWholeDepthOfTheView)
{
    for (const GLenum format : {GLenum{GL_DEPTH_COMPONENT32F}, GLenum{GL_DEPTH24_STENCIL8}}) {
        make_scene(kSize, 1, format);
        scene->after_begin = [] {
            glViewport(0, 0, 32, 32);
            glDepthRange(0.25, 0.75);
        };
        expect_lower_left_quarter(1e-5f);
    }
    glDepthRange(0.0, 1.0);
}

TEST_F(GlTargetTest, ASwappedDepthRangeReversesTheComparison)
{
    scene->after_begin = [] {
        glViewport(0, 0, 32, 32);
        glDepthRange(1.0, 0.0); // reversed depth without glClipControl
        glDepthFunc(GL_GREATER);
        glClearDepth(0.0);
        glClear(GL_DEPTH_BUFFER_BIT);
    };
    scene->after_restore = [] { glDepthFunc(GL_GREATER); };
    expect_lower_left_quarter(1e-5f);
    glDepthRange(0.0, 1.0);
}

TEST_F(GlTargetTest, TilesAreTheFarthestOfTheirPixelsInTargetsOfAnySizeAndConvention)
{
    Rng rng{11};
    for (const glm::ivec2 size : {glm::ivec2{1, 1}, glm::ivec2{63, 17}, glm::ivec2{130, 65}}) {
        for (const int samples : {1, 4}) {
            for (const bool reversed : {false, true}) {
                make_scene(size, samples, GL_DEPTH24_STENCIL8);
                view_size = size;
                std::vector<ItemId> quads;
                for (int i = 0; i < 12; ++i) {
                    const glm::vec2 low{rng.range(-1.0f, 0.8f), rng.range(-1.0f, 0.8f)};
                    quads.push_back(
                        scene->add_quad(low, low + rng.range(0.2f, 1.0f), rng.range(0.1f, 0.9f)));
                }
                device->begin_frame(View::from_clip(
                    glm::mat4{1.0f}, size,
                    reversed ? ClipConvention{DepthRange::zero_to_one, DepthOrder::near_is_large}
                             : ClipConvention{}));
                device->draw(quads, DrawPass::shade);
                expect_tiles_of(depths(size));
                device->end_frame();
            }
        }
    }
}

// Three views of one scene in one target, each with a culler of its own.
class GlSplitScreenTest : public GlFixture {
protected:
    static constexpr glm::ivec2 kTarget{150, 90};

    void SetUp() override
    {
        GlFixture::SetUp();
        make_split_scene(1);
    }

    void make_split_scene(int samples)
    {
        make_scene(kTarget, samples);
        scene->split_screen = true;
        bounds.clear();
        Rng rng{5};
        for (int i = 0; i < 60; ++i) {
            const glm::vec2 low{rng.range(-1.0f, 0.7f), rng.range(-1.0f, 0.7f)};
            const glm::vec2 high = low + (i < 6 ? 0.9f : 0.3f);
            const float z = i < 6 ? rng.range(-0.9f, -0.6f) : rng.range(-0.5f, 0.9f);
            scene->add_quad(low, high, z);
            bounds.push_back({{{low, z}, {high, z}}, 2});
        }
    }

    void TearDown() override
    {
        glDisable(GL_SCISSOR_TEST);
        GlFixture::TearDown();
    }

    // At the left, at the right and, small, above it; the camera of `frame`.
    static std::vector<View> views(int frame)
    {
        const float t = 0.05f * static_cast<float>(frame);
        const auto view = [&](glm::vec2 by, glm::ivec2 at, glm::ivec2 size) {
            glm::mat4 clip{1.0f};
            clip[3] = {by, 0.0f, 1.0f};
            return View::from_clip(clip, size, {}, {.viewport_origin_px = at});
        };
        return {view({t, 0.0f}, {0, 0}, {75, 90}), view({0.3f, -t}, {75, 0}, {75, 50}),
                view({-t, t}, {83, 53}, {61, 33})};
    }

    // The target after all views of some frames, culled by algorithm `name`.
    std::vector<uint32_t> colors_by(const std::string& name, std::vector<OptionValue> options)
    {
        const Hierarchy tree = build_bvh(bounds, {.max_leaf_items = 1, .leaf_triangles = 0});
        std::vector<std::unique_ptr<Culler>> cullers;
        for (int i = 0; i < 3; ++i) {
            cullers.push_back(std::move(make_culler(name, tree, options).value()));
        }
        drawn = 0;
        for (int frame = 0; frame < 4; ++frame) {
            for (size_t i = 0; i < cullers.size(); ++i) {
                drawn += cullers[i]->cull(views(frame)[i], *device).counters.items_drawn;
            }
        }
        return scene->colors();
    }

    std::vector<ItemBounds> bounds;
    uint64_t drawn = 0;
};

TEST_F(GlSplitScreenTest, EachViewIsExactInItsPartOfTheTargetByEveryMethodAndNumberOfSamples)
{
    for (const int samples : {1, 4}) {
        SCOPED_TRACE(samples);
        glDisable(GL_SCISSOR_TEST);
        make_split_scene(samples);
        make_listening_device({.state_checks = GlStateChecks::after_draws});
        const std::vector<uint32_t> expected = colors_by("frustum", {});
        const uint64_t drawn_by_frustum = drawn;
        const std::vector<TestCost> methods{device->caps().methods.begin(),
                                            device->caps().methods.end()};
        for (const TestCost& cost : methods) {
            ASSERT_TRUE(device->use_method(cost.method));
            EXPECT_EQ(colors_by("stop_and_wait", {}), expected) << name(cost.method);
            EXPECT_LT(drawn, drawn_by_frustum) << name(cost.method) << ": nothing was hidden";
            make_listening_device({.state_checks = GlStateChecks::after_draws});
        }
        for (const char* tile : {"1", "4"}) {
            EXPECT_EQ(colors_by("two_phase", {{"tile", tile}}), expected) << tile;
            EXPECT_LT(drawn, drawn_by_frustum) << tile << ": nothing was hidden";
        }
        EXPECT_TRUE(heard.empty()) << text;
    }
}

TEST_F(GlSplitScreenTest, AViewportElsewhereThanTheViewSaysIsReportedOnce)
{
    make_listening_device();
    scene->after_begin = [] { glViewport(0, 0, 61, 33); };
    device->begin_frame(views(0)[2]);
    device->end_frame();
    device->begin_frame(views(0)[2]);
    device->end_frame();
    EXPECT_EQ(heard, std::vector<std::string>{"gl.viewport_origin"});
    EXPECT_NE(text.find("(83, 53)"), std::string::npos) << text;
}

} // namespace
} // namespace occlude
