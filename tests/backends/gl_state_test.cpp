// The OpenGL state that tests change and need. docs/devices.md lists it, and these tests compare
// the device with that list.
#include "backends/gl_fixture.h"
#include "support/source_dir.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

namespace occlude {
namespace {

using State = std::map<std::string, std::string>;

std::string integers(GLenum name, size_t count)
{
    std::array<GLint, 4> values{};
    glGetIntegerv(name, values.data());
    std::string text;
    for (size_t i = 0; i < count; ++i) {
        text += std::to_string(values[i]) + " ";
    }
    return text;
}

#define STATE(name, count)                                                                         \
    {                                                                                              \
#name, integers(name, count)                                                               \
    }

// All the state that an engine may rely on and that a device of this kind could change.
State state_now()
{
    State state{STATE(GL_CURRENT_PROGRAM, 1),
                STATE(GL_VERTEX_ARRAY_BINDING, 1),
                STATE(GL_ARRAY_BUFFER_BINDING, 1),
                STATE(GL_SHADER_STORAGE_BUFFER_BINDING, 1),
                STATE(GL_COPY_READ_BUFFER_BINDING, 1),
                STATE(GL_PIXEL_PACK_BUFFER_BINDING, 1),
                STATE(GL_PIXEL_UNPACK_BUFFER_BINDING, 1),
                STATE(GL_DRAW_FRAMEBUFFER_BINDING, 1),
                STATE(GL_READ_FRAMEBUFFER_BINDING, 1),
                STATE(GL_RENDERBUFFER_BINDING, 1),
                STATE(GL_ACTIVE_TEXTURE, 1),
                STATE(GL_TEXTURE_BINDING_2D, 1),
                STATE(GL_TEXTURE_BINDING_2D_MULTISAMPLE, 1),
                STATE(GL_SAMPLER_BINDING, 1),
                STATE(GL_VIEWPORT, 4),
                STATE(GL_SCISSOR_BOX, 4),
                STATE(GL_COLOR_WRITEMASK, 4),
                STATE(GL_DEPTH_WRITEMASK, 1),
                STATE(GL_DEPTH_FUNC, 1),
                STATE(GL_DEPTH_TEST, 1),
                STATE(GL_DEPTH_CLAMP, 1),
                STATE(GL_CULL_FACE, 1),
                STATE(GL_BLEND, 1),
                STATE(GL_STENCIL_TEST, 1),
                STATE(GL_SCISSOR_TEST, 1),
                STATE(GL_POLYGON_OFFSET_FILL, 1),
                STATE(GL_RASTERIZER_DISCARD, 1),
                STATE(GL_PACK_ALIGNMENT, 1),
                STATE(GL_PACK_ROW_LENGTH, 1),
                STATE(GL_PACK_SKIP_ROWS, 1),
                STATE(GL_PACK_SKIP_PIXELS, 1)};
    return state;
}

#undef STATE

std::set<std::string> difference(const State& before, const State& after)
{
    std::set<std::string> names;
    for (const auto& [name, value] : before) {
        if (after.at(name) != value) {
            names.insert(name);
        }
    }
    return names;
}

// The names in the first column of the table below that heading of docs/devices.md.
std::set<std::string> documented(const std::string& heading)
{
    std::ifstream file(source_dir() + "/docs/devices.md");
    std::set<std::string> names;
    bool inside = false;
    for (std::string line; std::getline(file, line);) {
        if (line.starts_with("#")) {
            inside = line.find(heading) != std::string::npos;
        }
        const size_t begin = line.find("| `");
        if (inside && begin == 0) {
            std::istringstream cell(line.substr(2, line.find(" |") - 2));
            for (std::string word; cell >> word;) {
                std::erase_if(word, [](char c) { return c == '`' || c == ','; });
                names.insert(word);
            }
        }
    }
    return names;
}

class GlStateTest : public GlFixture {
protected:
    // Every value differs from the device's defaults.
    static void set_unusual_state()
    {
        glDisable(GL_DEPTH_TEST);
        glEnable(GL_BLEND);
        glActiveTexture(GL_TEXTURE3);
        glPixelStorei(GL_PACK_ROW_LENGTH, 77);
        glPixelStorei(GL_PACK_SKIP_ROWS, 1);
        glPixelStorei(GL_PACK_ALIGNMENT, 8);
    }
    static void set_usual_state()
    {
        glDisable(GL_BLEND);
        glActiveTexture(GL_TEXTURE0);
        glPixelStorei(GL_PACK_ROW_LENGTH, 0);
        glPixelStorei(GL_PACK_SKIP_ROWS, 0);
        glPixelStorei(GL_PACK_ALIGNMENT, 4);
    }
};

TEST_F(GlStateTest, TestsChangeTheStateThatTheManualListsAndNoOther)
{
    std::set<std::string> changed;
    for (const TestMethod method : {TestMethod::queries, TestMethod::raster, TestMethod::pyramid}) {
        device->begin_frame(kFlatView);
        draw(scene->add_quad(kLow, kHigh, 0.9f));
        set_unusual_state();
        const State before = state_now();
        const QueryBox box{kMiddle, nullptr, {}};
        const uint32_t end = 1;
        Ticket ticket;
        device->query({{&box, 1}, {&end, 1}, method}, {&ticket, 1});
        device->wait(ticket);
        changed.merge(difference(before, state_now()));
        set_usual_state();
        device->end_frame();
    }
    EXPECT_EQ(changed, documented("State that tests change"));
}

TEST_F(GlStateTest, ReadingDepthPutsBackAllState)
{
    for (const int samples : {1, 4}) {
        make_scene(kSize, samples);
        const GlRenderbuffer bound = GlRenderbuffer::make();
        device->begin_frame(kFlatView);
        draw(scene->add_quad(kLow, kHigh, 0.0f));
        glBindRenderbuffer(GL_RENDERBUFFER, bound.name());
        glEnable(GL_SCISSOR_TEST);
        for (const bool unusual : {false, true}) {
            unusual ? set_unusual_state() : glEnable(GL_DEPTH_TEST);
            const State before = state_now();
            EXPECT_EQ(depths(), std::vector<float>(64 * 64, 0.5f)) << samples;
            std::vector<float> tiles(4);
            EXPECT_TRUE(device->read_depth_tiles(32, tiles));
            EXPECT_EQ(tiles, std::vector<float>(4, 0.5f)) << samples;
            EXPECT_EQ(difference(before, state_now()), std::set<std::string>{}) << samples;
        }
        set_usual_state();
        glDisable(GL_SCISSOR_TEST);
        device->end_frame();
    }
}

TEST_F(GlStateTest, TheEngineIsAskedToPrepareOnceBetweenDrawingAndTests)
{
    device->begin_frame(kFlatView);
    EXPECT_EQ(scene->prepares, 0);
    const Ticket a = ask(kMiddle);
    const Ticket b = ask(kMiddle);
    EXPECT_EQ(scene->prepares, 1);
    draw(scene->add_quad(kLow, kHigh, 0.9f));
    const Ticket c = ask(kMiddle);
    EXPECT_EQ(scene->prepares, 2);
    device->end_frame();
    for (const Ticket ticket : {a, b, c}) {
        device->wait(ticket);
    }
}

// One mistake in an engine's state, and the message that must name it.
struct Mistake {
    const char* message;
    void (*make)();
    void (*undo)();
};

constexpr Mistake kMistakes[] = {
    {"gl.depth_function", [] { glDepthFunc(GL_GREATER); }, [] { glDepthFunc(GL_LESS); }},
    {"gl.depth_clear", [] { glClearDepth(0.0); }, [] { glClearDepth(1.0); }},
    {"gl.stencil_test", [] { glEnable(GL_STENCIL_TEST); }, [] { glDisable(GL_STENCIL_TEST); }},
    {"gl.rasterizer_discard", [] { glEnable(GL_RASTERIZER_DISCARD); },
     [] { glDisable(GL_RASTERIZER_DISCARD); }},
    {"gl.polygon_offset", [] { glEnable(GL_POLYGON_OFFSET_FILL); },
     [] { glDisable(GL_POLYGON_OFFSET_FILL); }},
    {"gl.alpha_to_coverage", [] { glEnable(GL_SAMPLE_ALPHA_TO_COVERAGE); },
     [] { glDisable(GL_SAMPLE_ALPHA_TO_COVERAGE); }},
    {"gl.sample_coverage", [] { glEnable(GL_SAMPLE_COVERAGE); },
     [] { glDisable(GL_SAMPLE_COVERAGE); }},
    {"gl.logic_op", [] { glEnable(GL_COLOR_LOGIC_OP); }, [] { glDisable(GL_COLOR_LOGIC_OP); }},
    {"gl.clip_distance", [] { glEnable(GL_CLIP_DISTANCE2); }, [] { glDisable(GL_CLIP_DISTANCE2); }},
    {"gl.primitive_restart",
     [] {
         glEnable(GL_PRIMITIVE_RESTART);
         glPrimitiveRestartIndex(3);
     },
     [] { glDisable(GL_PRIMITIVE_RESTART); }},
    {"gl.polygon_mode", [] { glPolygonMode(GL_FRONT_AND_BACK, GL_LINE); },
     [] { glPolygonMode(GL_FRONT_AND_BACK, GL_FILL); }},
    {"gl.scissor",
     [] {
         glEnable(GL_SCISSOR_TEST);
         glScissor(0, 0, 32, 64);
     },
     [] {
         glDisable(GL_SCISSOR_TEST);
         glScissor(0, 0, 64, 64);
     }},
    {"gl.error", [] { glEnable(GL_TEXTURE0); }, [] {}},
};

TEST_F(GlStateTest, TheFirstTestAfterADrawNamesEveryMistakeInTheState)
{
    for (const Mistake& mistake : kMistakes) {
        heard.clear();
        make_listening_device({.state_checks = GlStateChecks::after_draws});
        scene->after_draw = mistake.make;
        for (int frame = 0; frame < 2; ++frame) {
            device->begin_frame(kFlatView);
            device->wait(ask(kMiddle)); // no mistake yet
            device->draw({}, DrawPass::shade);
            device->wait(ask(kMiddle));
            device->end_frame();
            mistake.undo();
        }
        EXPECT_EQ(heard, std::vector<std::string>{mistake.message});
    }
}

TEST_F(GlStateTest, AGoodEngineHearsNothingInEitherConventionOfDepth)
{
    make_listening_device({.state_checks = GlStateChecks::after_draws});
    for (const ClipConvention convention :
         {ClipConvention{}, ClipConvention{DepthRange::zero_to_one, DepthOrder::near_is_large}}) {
        device->begin_frame(View::from_clip(glm::mat4{1.0f}, kSize, convention));
        device->draw({}, DrawPass::shade);
        device->wait(ask({{-0.5f, -0.5f, 0.2f}, {0.5f, 0.5f, 0.4f}}));
        device->end_frame();
    }
    EXPECT_EQ(heard, std::vector<std::string>{}) << text;
}

TEST_F(GlStateTest, AWrongDepthConventionIsNamed)
{
    make_listening_device({.state_checks = GlStateChecks::after_draws});
    // The engine draws with reversed Z in [0, 1], and the view does not say so.
    scene->after_begin = [] {
        glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
        glDepthFunc(GL_GREATER);
        glClearDepth(0.0);
    };
    device->begin_frame(kFlatView);
    device->wait(ask(kMiddle));
    device->end_frame();
    EXPECT_EQ(heard,
              (std::vector<std::string>{"gl.depth_function", "gl.depth_clear", "gl.clip_control"}));
}

TEST_F(GlStateTest, ConditionalRenderingIsNamedAndEnded)
{
    make_listening_device({.state_checks = GlStateChecks::after_draws});
    const GlQuery nothing_passed = GlQuery::make();
    glBeginQuery(GL_SAMPLES_PASSED, nothing_passed.name());
    glEndQuery(GL_SAMPLES_PASSED);
    scene->after_draw = [&] { glBeginConditionalRender(nothing_passed.name(), GL_QUERY_WAIT); };
    device->begin_frame(kFlatView);
    device->draw({}, DrawPass::shade);
    EXPECT_EQ(count(kMiddle), 2048u) << "not hidden by it";
    EXPECT_EQ(heard, std::vector<std::string>{"gl.conditional_rendering"});
    scene->after_draw = {};
    device->end_frame();
}

TEST_F(GlStateTest, ChecksThatAreOffAskNothingOfTheDriver)
{
    make_listening_device({.state_checks = GlStateChecks::off});
    glEnable(GL_TEXTURE0); // an error that the check would read
    device->begin_frame(kFlatView);
    device->wait(ask(kMiddle));
    device->end_frame();
    EXPECT_EQ(heard, std::vector<std::string>{});
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_INVALID_ENUM)) << "still the engine's";
}

} // namespace
} // namespace occlude
