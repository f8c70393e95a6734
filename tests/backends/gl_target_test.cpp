// Where the view lies in the target: any viewport, origin and part of the depth buffer.
#include "backends/gl_fixture.h"

#include <algorithm>

namespace occlude {
namespace {

constexpr glm::ivec2 kViewSize{32, 32};
const View kSmallView = View::from_clip(glm::mat4{1.0f}, kViewSize);

// Left of the middle and right of it, behind z = 0.3.
constexpr Aabb kLeftBox{{-0.75f, -0.75f, 0.4f}, {-0.25f, 0.75f, 0.6f}};
constexpr Aabb kRightBox{{0.25f, -0.75f, 0.4f}, {0.75f, 0.75f, 0.6f}};
constexpr Aabb kLowBox{{-0.75f, -0.75f, 0.4f}, {-0.25f, -0.25f, 0.6f}};
constexpr Aabb kHighBox{{-0.75f, 0.25f, 0.4f}, {-0.25f, 0.75f, 0.6f}};

class GlTargetTest : public GlFixture {
protected:
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

    // Draws a quad over the lower left quarter of the view and looks at it in every way.
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

} // namespace
} // namespace occlude
