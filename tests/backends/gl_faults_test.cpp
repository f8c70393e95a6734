// Faults of the engine, the context and the driver: nothing hangs, nothing is hidden, and each
// fault is reported once.
#include "backends/gl_fixture.h"

#include <algorithm>
#include <chrono>

namespace occlude {
namespace {

// Replaces one OpenGL function while it lives: libepoxy calls through pointers.
template <class Function>
class Instead {
public:
    Instead(Function& pointer, Function replacement)
        : pointer_(pointer)
        , original_(pointer)
    {
        pointer = replacement;
    }
    ~Instead() { pointer_ = original_; }
    Instead(const Instead&) = delete;
    Instead& operator=(const Instead&) = delete;

private:
    Function& pointer_;
    Function original_;
};

// An engine that never calls OpenGL.
class SilentScene final : public GlScene {
public:
    void begin_frame(const View&) override {}
    void draw(std::span<const ItemId>, DrawPass) override {}
    void restore_state() override {}
};

using Names = std::vector<std::string>;

class GlFaultsTest : public GlFixture {
protected:
    void SetUp() override
    {
        GlFixture::SetUp();
        if (context_) {
            make_listening_device();
        }
    }

    // Tests a visible box with every method: none may answer "hidden".
    void expect_nothing_hidden(const View& view = kFlatView)
    {
        device->begin_frame(view);
        device->draw({}, DrawPass::shade);
        for (const TestCost& cost : device->caps().methods) {
            const QueryBox box{kMiddle, nullptr, {}};
            const uint32_t end = 1;
            Ticket ticket;
            device->query({{&box, 1}, {&end, 1}, cost.method}, {&ticket, 1});
            device->flush();
            EXPECT_GT(device->wait(ticket).samples, 0u) << name(cost.method);
        }
        device->end_frame();
    }

    // All of them lose it.
    void expect_all_lost(const View& view = kFlatView)
    {
        device->begin_frame(view);
        device->draw({}, DrawPass::shade);
        for (const TestCost& cost : device->caps().methods) {
            const QueryBox box{kMiddle, nullptr, {}};
            const uint32_t end = 1;
            Ticket ticket;
            device->query({{&box, 1}, {&end, 1}, cost.method}, {&ticket, 1});
            device->flush();
            EXPECT_EQ(device->wait(ticket).state, AnswerState::lost) << name(cost.method);
        }
        std::array<float, 1> depth{0.25f};
        EXPECT_FALSE(device->read_depth({0, 0, 1, 1}, depth));
        EXPECT_EQ(depth[0], 0.25f) << "untouched";
        device->end_frame();
    }

    static void forget_errors()
    {
        while (glGetError() != GL_NO_ERROR) {
        }
    }
};

TEST_F(GlFaultsTest, AGoodEngineHearsNothing)
{
    expect_nothing_hidden();
    EXPECT_EQ(heard, Names{});
}

TEST_F(GlFaultsTest, AViewportOfAnotherSizeThanTheViewLosesAllTests)
{
    scene->after_begin = [] { glViewport(0, 0, 32, 48); };
    expect_all_lost();
    expect_all_lost();
    EXPECT_EQ(heard, Names{"gl.viewport"}) << "once";
    EXPECT_NE(text.find("32x48 pixels, the view 64x64"), std::string::npos) << text;
    EXPECT_NE(text.find("dynamic resolution"), std::string::npos) << text;
    expect_nothing_hidden(View::from_clip(glm::mat4{1.0f}, {32, 48}));
}

TEST_F(GlFaultsTest, SwappedWidthAndHeightAreNamed)
{
    scene->after_begin = [] { glViewport(0, 0, 48, 64); };
    expect_all_lost(View::from_clip(glm::mat4{1.0f}, {64, 48}));
    EXPECT_NE(text.find("width and height are swapped"), std::string::npos) << text;
}

TEST_F(GlFaultsTest, AnIncompleteTargetLosesAllTests)
{
    const GlFramebuffer empty = GlFramebuffer::make();
    scene->after_begin = [&] { glBindFramebuffer(GL_FRAMEBUFFER, empty.name()); };
    expect_all_lost();
    expect_all_lost();
    EXPECT_EQ(heard, Names{"gl.incomplete_target"});
    EXPECT_NE(text.find("nothing is attached"), std::string::npos) << text;
    forget_errors();
}

TEST_F(GlFaultsTest, AnotherContextOrNoneLosesAllTestsAndTouchesNothing)
{
    SilentScene silent;
    auto made = GlDevice::create(
        silent, {.on_message = [this](const Message& m) { heard.emplace_back(m.name); }});
    ASSERT_TRUE(made);
    std::swap(device, *made);
    {
        auto other = HeadlessContext::create(); // current from now on
        ASSERT_TRUE(other);
        expect_all_lost();
        EXPECT_EQ(heard, Names{"gl.other_context"});
        EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR)) << "of the other context";
    }
    expect_all_lost(); // no context at all
    EXPECT_EQ(heard, (Names{"gl.other_context", "gl.no_context"}));
    device.reset(); // does not delete its objects
    ASSERT_TRUE(context_->make_current());
    std::swap(device, *made);
    expect_nothing_hidden();
}

TEST_F(GlFaultsTest, ALostContextAnswersNothingEverAgain)
{
    device->begin_frame(kFlatView);
    const Ticket before = ask(kMiddle);
    device->end_frame();
    {
        const Instead reset(
            epoxy_glGetGraphicsResetStatus,
            PFNGLGETGRAPHICSRESETSTATUSPROC{[]() -> GLenum { return GL_GUILTY_CONTEXT_RESET; }});
        expect_all_lost();
    }
    expect_all_lost();
    EXPECT_EQ(device->wait(before).state, AnswerState::lost);
    EXPECT_EQ(heard, Names{"gl.context_lost"});
}

TEST_F(GlFaultsTest, AQueryOfTheEngineThatIsLeftOpenLosesQueriesAndIsNotEnded)
{
    const GlQuery query = GlQuery::make();
    const ItemId quad = scene->add_quad(kLow, kHigh, 0.9f);
    scene->after_draw = [&] { glBeginQuery(GL_ANY_SAMPLES_PASSED, query.name()); };
    for (int frame = 0; frame < 2; ++frame) {
        device->begin_frame(kFlatView);
        draw(quad);
        EXPECT_EQ(device->wait(ask(kMiddle)).state, AnswerState::lost);
        EXPECT_EQ(device->wait(ask(kMiddle)).state, AnswerState::lost) << "another batch";
        GLint open = 0;
        glGetQueryiv(GL_ANY_SAMPLES_PASSED, GL_CURRENT_QUERY, &open);
        EXPECT_EQ(open, static_cast<GLint>(query.name()));
        glEndQuery(GL_ANY_SAMPLES_PASSED);
        device->end_frame();
    }
    EXPECT_EQ(heard, Names{"gl.query_open"});
}

TEST_F(GlFaultsTest, AFullPoolIsReported)
{
    make_listening_device({.max_outstanding = 1});
    for (int frame = 0; frame < 2; ++frame) {
        device->begin_frame(kFlatView);
        const Ticket first = ask(kMiddle);
        EXPECT_EQ(device->wait(ask(kMiddle)).state, AnswerState::lost);
        EXPECT_EQ(device->wait(first).state, AnswerState::ready);
        device->end_frame();
    }
    EXPECT_EQ(heard, Names{"gl.pool_full"});
}

TEST_F(GlFaultsTest, WithoutMemoryForBoxesTestsReadAsVisible)
{
    {
        const Instead no_memory(
            epoxy_glMapBufferRange,
            PFNGLMAPBUFFERRANGEPROC{
                [](GLenum, GLintptr, GLsizeiptr, GLbitfield) -> void* { return nullptr; }});
        expect_nothing_hidden();
        expect_nothing_hidden();
    }
    EXPECT_EQ(heard, Names{"gl.out_of_memory"});
    expect_nothing_hidden();
}

PFNGLGETQUERYOBJECTUIVPROC g_real_query_object = nullptr;

TEST_F(GlFaultsTest, AnswersThatNeverComeAreWaitedForWithABudget)
{
    make_listening_device({.wait_budget_ms = 20.0});
    device->begin_frame(kFlatView);
    glFinish();
    {
        const Instead never(
            epoxy_glGetQueryObjectuiv,
            PFNGLGETQUERYOBJECTUIVPROC{[](GLuint, GLenum, GLuint* out) { *out = GL_FALSE; }});
        const auto start = std::chrono::steady_clock::now();
        for (int i = 0; i < 50; ++i) {
            EXPECT_EQ(device->wait(ask(kMiddle)).state, AnswerState::lost);
        }
        const auto taken = std::chrono::steady_clock::now() - start;
        EXPECT_LT(std::chrono::duration<double>(taken).count(), 1.0) << "one budget for all";
    }
    device->end_frame();
    device->begin_frame(kFlatView);
    EXPECT_EQ(count(kMiddle), 2048u) << "the next frame waits again";
    device->end_frame();
    EXPECT_EQ(heard, Names{"gl.wait_budget"});
}

TEST_F(GlFaultsTest, ADriverThatSaysReadyTooEarlyIsWaitedFor)
{
    const ItemId wall = scene->add_quad(kLow, kHigh, 0.1f);
    g_real_query_object = epoxy_glGetQueryObjectuiv;
    const Instead early(epoxy_glGetQueryObjectuiv,
                        PFNGLGETQUERYOBJECTUIVPROC{[](GLuint query, GLenum what, GLuint* out) {
                            what == GL_QUERY_RESULT_AVAILABLE
                                ? static_cast<void>(*out = GL_TRUE)
                                : g_real_query_object(query, what, out);
                        }});
    device->begin_frame(kFlatView);
    const Ticket visible = ask(kMiddle);
    draw(wall);
    const Ticket hidden = ask(kMiddle);
    EXPECT_EQ(device->poll(visible).samples, 2048u);
    EXPECT_EQ(device->poll(hidden).samples, 0u);
    device->end_frame();
}

TEST_F(GlFaultsTest, ADepthReadThatFailsNowAndThenHidesNothingAndLeavesTheBufferAlone)
{
    const ItemId wall = scene->add_quad(kLow, kHigh, 0.1f);
    device->begin_frame(kFlatView); // fills the pyramid with a wall
    draw(wall);
    const QueryBox box{kMiddle, nullptr, {}};
    const uint32_t end = 1;
    Ticket ticket;
    device->query({{&box, 1}, {&end, 1}, TestMethod::pyramid}, {&ticket, 1});
    EXPECT_EQ(device->wait(ticket).samples, 0u);
    device->end_frame();
    {
        const Instead fails(
            epoxy_glReadPixels,
            PFNGLREADPIXELSPROC{[](GLint, GLint, GLsizei, GLsizei, GLenum, GLenum, void*) {}});
        device->begin_frame(kFlatView); // nothing is drawn: the wall is gone
        device->query({{&box, 1}, {&end, 1}, TestMethod::pyramid}, {&ticket, 1});
        EXPECT_EQ(device->wait(ticket).state, AnswerState::lost);
        std::array<float, 2> out{0.25f, 0.5f};
        EXPECT_FALSE(device->read_depth({0, 0, 2, 1}, out));
        EXPECT_EQ(out, (std::array<float, 2>{0.25f, 0.5f}));
        device->end_frame();
    }
    EXPECT_EQ(heard, Names{"gl.read_depth"});
    expect_nothing_hidden();
}

TEST_F(GlFaultsTest, ADriverWhoseQueriesCountNothingIsTestedInOtherWays)
{
    const Instead no_counter(epoxy_glGetQueryiv,
                             PFNGLGETQUERYIVPROC{[](GLenum, GLenum, GLint* out) { *out = 0; }});
    make_listening_device();
    EXPECT_EQ(device->caps().find_method(TestMethod::queries), nullptr);
    EXPECT_FALSE(device->caps().draw_and_query);
    expect_nothing_hidden();
    device->begin_frame(kFlatView);
    const ItemId quad = scene->add_quad(kLow, kHigh, 0.1f);
    EXPECT_EQ(device->wait(device->draw_and_query({&quad, 1}, DrawPass::shade)).state,
              AnswerState::lost);
    device->end_frame();
}

} // namespace
} // namespace occlude
