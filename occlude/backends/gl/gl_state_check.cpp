#include <occlude/backends/gl/detail/gl_state_check.h>

#include <algorithm>
#include <array>
#include <string>

namespace occlude {

namespace {

constexpr int kClipControlVersion = 45;
constexpr GLuint kMostBoxIndex = 7; // indices of the corners of a box
constexpr int kMostErrors = 16;     // of OpenGL, kept for us by the driver

// A switch that must be off while boxes are drawn.
struct Switch {
    GLenum name;
    Severity severity;
    const char* message;
    const char* text;
};

constexpr std::array<Switch, 6> kMustBeOff{{
    {GL_STENCIL_TEST, Severity::error, "gl.stencil_test",
     "the stencil test is on while boxes are tested, and the samples that it rejects count as "
     "hidden: disable "
     "GL_STENCIL_TEST in GlScene::prepare_tests()"},
    {GL_RASTERIZER_DISCARD, Severity::error, "gl.rasterizer_discard",
     "GL_RASTERIZER_DISCARD is on while boxes are tested, so that everything counts as hidden: "
     "disable it in GlScene::prepare_tests()"},
    {GL_POLYGON_OFFSET_FILL, Severity::error, "gl.polygon_offset",
     "GL_POLYGON_OFFSET_FILL is on while boxes are tested and moves them in depth: disable it in "
     "GlScene::prepare_tests()"},
    {GL_SAMPLE_ALPHA_TO_COVERAGE, Severity::error, "gl.alpha_to_coverage",
     "GL_SAMPLE_ALPHA_TO_COVERAGE is on while boxes are tested, and samples get lost: disable it "
     "in GlScene::prepare_tests()"},
    {GL_SAMPLE_COVERAGE, Severity::error, "gl.sample_coverage",
     "GL_SAMPLE_COVERAGE is on while boxes are tested, and samples get lost: disable it in "
     "GlScene::prepare_tests()"},
    {GL_COLOR_LOGIC_OP, Severity::note, "gl.logic_op",
     "GL_COLOR_LOGIC_OP is on while boxes are tested: harmless, and slow with some drivers"},
}};

GLint integer(GLenum name)
{
    GLint value = 0;
    glGetIntegerv(name, &value);
    return value;
}

void check_switches(Messages& messages)
{
    for (const Switch& must_be_off : kMustBeOff) {
        if (glIsEnabled(must_be_off.name)) {
            messages.report(must_be_off.severity, must_be_off.message, must_be_off.text);
        }
    }
    GLint planes = 0;
    glGetIntegerv(GL_MAX_CLIP_DISTANCES, &planes);
    for (int i = 0; i < planes; ++i) {
        if (glIsEnabled(GL_CLIP_DISTANCE0 + static_cast<GLenum>(i))) {
            messages.report(Severity::error, "gl.clip_distance",
                            "GL_CLIP_DISTANCE" + std::to_string(i) +
                                " is on while boxes are tested, but their shader writes no clip "
                                "distance: disable "
                                "it in GlScene::prepare_tests()");
        }
    }
    if (glIsEnabled(GL_PRIMITIVE_RESTART) &&
        static_cast<GLuint>(integer(GL_PRIMITIVE_RESTART_INDEX)) <= kMostBoxIndex) {
        messages.report(Severity::error, "gl.primitive_restart",
                        "GL_PRIMITIVE_RESTART is on with an index below 8, which boxes use: "
                        "disable it in GlScene::prepare_tests()");
    }
    if (integer(GL_TRANSFORM_FEEDBACK_ACTIVE) != 0 && integer(GL_TRANSFORM_FEEDBACK_PAUSED) == 0) {
        messages.report(Severity::error, "gl.transform_feedback",
                        "transform feedback is active while boxes are tested, so that they cannot "
                        "be drawn: end or pause it before GlScene::draw() returns");
    }
}

void check_polygon_mode(Messages& messages)
{
    std::array<GLint, 2> mode{GL_FILL, GL_FILL}; // compatibility profiles have two polygon modes
    glGetIntegerv(GL_POLYGON_MODE, mode.data());
    if (mode[0] != GL_FILL) {
        messages.report(Severity::error, "gl.polygon_mode",
                        "glPolygonMode is not GL_FILL while boxes are tested, so that only their "
                        "edges count: set GL_FILL in GlScene::prepare_tests()");
    }
}

void check_scissor(const GlTargetState& target, Messages& messages)
{
    if (!glIsEnabled(GL_SCISSOR_TEST)) {
        return;
    }
    std::array<GLint, 4> box{};
    glGetIntegerv(GL_SCISSOR_BOX, box.data());
    const PixelRect& viewport = target.viewport;
    const bool holds_viewport = box[0] <= viewport.x && box[1] <= viewport.y &&
                                box[0] + box[2] >= viewport.x + viewport.width &&
                                box[1] + box[3] >= viewport.y + viewport.height;
    if (!holds_viewport) {
        messages.report(Severity::error, "gl.scissor",
                        "the scissor test is on with " + std::to_string(box[2]) + "x" +
                            std::to_string(box[3]) + " pixels of a viewport of " +
                            std::to_string(viewport.width) + "x" + std::to_string(viewport.height) +
                            ": boxes elsewhere count as hidden. Disable GL_SCISSOR_TEST in "
                            "GlScene::prepare_tests() unless all of the frame is drawn with it");
    }
}

void check_depth(const View& view, const GlTargetState& target, int gl_version, Messages& messages)
{
    const ClipConvention convention = view.convention();
    const bool near_is_large = target.near_is_large(convention.order);
    const GLint function = integer(GL_DEPTH_FUNC);
    const bool greater = function == GL_GREATER || function == GL_GEQUAL;
    const bool less = function == GL_LESS || function == GL_LEQUAL;
    if (near_is_large ? less : greater) {
        messages.report(Severity::error, "gl.depth_function",
                        std::string("geometry is drawn with a depth function of the ") +
                            (less ? "GL_LESS" : "GL_GREATER") + " kind, but the view says that " +
                            (near_is_large ? "near is large (reversed Z)" : "near is small") +
                            ": give View::from_clip the ClipConvention that you draw with");
    }
    GLdouble cleared = 1.0;
    glGetDoublev(GL_DEPTH_CLEAR_VALUE, &cleared);
    if (cleared != (near_is_large ? 0.0 : 1.0)) {
        messages.report(Severity::note, "gl.depth_clear",
                        std::string("glClearDepth is ") + (near_is_large ? "not 0" : "not 1") +
                            ", the far end of the view's depth: is the ClipConvention of the view "
                            "the one that you draw with?");
    }
    const bool zero_to_one = convention.range == DepthRange::zero_to_one;
    if (target.zero_to_one != zero_to_one) {
        messages.report(Severity::error, "gl.clip_control",
                        std::string("the view says that clip z goes from ") +
                            (zero_to_one ? "0" : "-w") + " to w, but OpenGL " +
                            (gl_version >= kClipControlVersion
                                 ? "is set to the other range: call glClipControl in "
                                   "GlScene::begin_frame(), or change the ClipConvention"
                                 : "has no glClipControl before 4.5: use minus_one_to_one"));
    }
}

// OpenGL has no query for this: ending it is an error if it is not active.
void check_conditional_rendering(Messages& messages)
{
    for (int i = 0; i < kMostErrors && glGetError() != GL_NO_ERROR; ++i) {
        messages.report(Severity::note, "gl.error",
                        "an OpenGL error was pending when the first box was tested; the check has "
                        "read it");
    }
    glEndConditionalRender();
    if (glGetError() == GL_NO_ERROR) {
        messages.report(Severity::error, "gl.conditional_rendering",
                        "conditional rendering was active when boxes were to be tested, which "
                        "hides them at random: call glEndConditionalRender before "
                        "GlScene::draw() returns. The check has ended it this time");
    }
}

} // namespace

void check_gl_state(const View& view, const GlTargetState& target, int gl_version,
                    Messages& messages)
{
    check_conditional_rendering(messages);
    check_depth(view, target, gl_version, messages);
    check_switches(messages);
    check_polygon_mode(messages);
    check_scissor(target, messages);
}

} // namespace occlude
