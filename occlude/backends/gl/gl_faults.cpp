#include <occlude/backends/gl/detail/gl_faults.h>

#include <array>
#include <cstdio>
#include <string>
#include <utility>

namespace occlude {

namespace {

constexpr int kConservativeQueryVersion = 43;
constexpr int kResetStatusVersion = 45;

std::string text(glm::ivec2 size)
{
    return std::to_string(size.x) + "x" + std::to_string(size.y);
}

std::string place(glm::ivec2 pixel)
{
    return std::string{"("} + std::to_string(pixel.x) + ", " + std::to_string(pixel.y) + ")";
}

const char* cause_of(GLenum framebuffer_status)
{
    switch (framebuffer_status) {
    case GL_FRAMEBUFFER_UNDEFINED:
        return "there is no default framebuffer";
    case GL_FRAMEBUFFER_INCOMPLETE_ATTACHMENT:
        return "an attachment is incomplete";
    case GL_FRAMEBUFFER_INCOMPLETE_MISSING_ATTACHMENT:
        return "nothing is attached";
    case GL_FRAMEBUFFER_INCOMPLETE_MULTISAMPLE:
        return "the attachments differ in their number of samples";
    case GL_FRAMEBUFFER_UNSUPPORTED:
        return "the driver does not support these formats together";
    default:
        return "glCheckFramebufferStatus says so";
    }
}

} // namespace

GlFaults::GlFaults(MessageHandler on_message, int gl_version)
    : messages_(std::move(on_message))
    , own_context_(watch_.current())
    , gl_version_(gl_version)
{
}

GlFaults::Context GlFaults::look_at_context()
{
    void* current = watch_.current();
    if (watch_.known() && current != own_context_) {
        messages_.report(
            Severity::warning, current == nullptr ? "gl.no_context" : "gl.other_context",
            current == nullptr
                ? "no OpenGL context is current in this thread, so nothing is culled: make "
                  "the context current in which the GlDevice was created"
                : "the current OpenGL context is not the one in which the GlDevice was "
                  "created, so nothing is culled: after recreating a context, create the "
                  "device and all other objects in it again");
        return Context::other;
    }
    if (!lost_ && gl_version_ >= kResetStatusVersion && glGetGraphicsResetStatus() != GL_NO_ERROR) {
        lost_ = true;
        messages_.report(Severity::warning, "gl.context_lost",
                         "the OpenGL context was lost (the device was reset), so nothing is "
                         "culled: create the context, the engine's objects and the GlDevice again");
    }
    return lost_ ? Context::lost : Context::own;
}

bool GlFaults::can_test(const View& view, const GlTargetState& target)
{
    const GLenum status = glCheckFramebufferStatus(GL_DRAW_FRAMEBUFFER);
    if (status != GL_FRAMEBUFFER_COMPLETE) {
        if (messages_.due("gl.incomplete_target")) {
            messages_.report(Severity::warning, "gl.incomplete_target",
                             std::string("the framebuffer that GlScene::begin_frame() bound is "
                                         "incomplete (") +
                                 cause_of(status) + "), so nothing is culled");
        }
        return false;
    }
    const glm::ivec2 viewport{target.viewport.width, target.viewport.height};
    if (viewport != view.size_px()) {
        const bool swapped = viewport == glm::ivec2{view.size_px().y, view.size_px().x};
        if (messages_.due("gl.viewport")) {
            messages_.report(
                Severity::warning, "gl.viewport",
                "the viewport is " + text(viewport) + " pixels, the view " + text(view.size_px()) +
                    (swapped ? ": width and height are swapped"
                             : ": with a dynamic resolution, make a new view with the size of "
                               "the viewport in every frame") +
                    "; nothing is culled until they agree");
        }
        return false;
    }
    const glm::ivec2 origin{target.viewport.x, target.viewport.y};
    // Engines that place their viewports themselves need not tell the view.
    if (origin != view.viewport_origin_px() && view.viewport_origin_px() != glm::ivec2{0} &&
        messages_.due("gl.viewport_origin")) {
        messages_.report(Severity::error, "gl.viewport_origin",
                         "the view's viewport begins at pixel " + place(view.viewport_origin_px()) +
                             " of the target, but glViewport at " + place(origin) +
                             ": set it in GlScene::begin_frame() from view.viewport_origin_px()");
    }
    if (!(target.depth_extent() > 0.0f)) {
        messages_.report(Severity::warning, "gl.depth_range",
                         "glDepthRange has made all depths equal, so nothing is culled: set "
                         "the range of the geometry in GlScene::begin_frame()");
        return false;
    }
    return true;
}

void GlFaults::report_pool(GlQueryPool::Faults faults, uint32_t capacity, double wait_budget_ms)
{
    if (faults.full && messages_.due("gl.pool_full")) {
        messages_.report(Severity::note, "gl.pool_full",
                         "more than " + std::to_string(capacity) +
                             " tests were unanswered at a time, and the rest counts as visible: "
                             "raise GlDeviceOptions::max_outstanding");
    }
    if (faults.no_query) {
        messages_.report(Severity::warning, "gl.no_query",
                         "the driver gives no more query objects, and tests without one count "
                         "as visible: is it out of memory?");
    }
    if (faults.timed_out && messages_.due("gl.wait_budget")) {
        std::array<char, 32> ms{};
        std::snprintf(ms.data(), ms.size(), "%g", wait_budget_ms);
        messages_.report(Severity::warning, "gl.wait_budget",
                         std::string("the driver did not answer a test within ") + ms.data() +
                             " ms (GlDeviceOptions::wait_budget_ms): it counts as visible, and "
                             "this frame waits for no other answer");
    }
}

void GlFaults::report_no_memory()
{
    messages_.report(Severity::warning, "gl.out_of_memory",
                     "the driver has no memory for the boxes of tests: they count as visible");
}

void GlFaults::report_no_depth()
{
    messages_.report(Severity::warning, "gl.read_depth",
                     "depth cannot be read back: the framebuffer has no depth attachment, a "
                     "layered one, or the driver failed; everything that depth would be tested for "
                     "counts as visible");
}

bool GlFaults::query_is_open()
{
    struct Target {
        GLenum target;
        const char* name;
        int version;
    };
    constexpr std::array<Target, 3> kTargets{
        {{GL_SAMPLES_PASSED, "GL_SAMPLES_PASSED", 0},
         {GL_ANY_SAMPLES_PASSED, "GL_ANY_SAMPLES_PASSED", 0},
         {GL_ANY_SAMPLES_PASSED_CONSERVATIVE, "GL_ANY_SAMPLES_PASSED_CONSERVATIVE",
          kConservativeQueryVersion}}};
    for (const Target& target : kTargets) {
        GLint open = 0;
        if (gl_version_ >= target.version) {
            glGetQueryiv(target.target, GL_CURRENT_QUERY, &open);
        }
        if (open != 0) {
            if (messages_.due("gl.query_open")) {
                messages_.report(Severity::warning, "gl.query_open",
                                 "query " + std::to_string(open) + " of the engine (" +
                                     target.name +
                                     ") is still open when boxes must be tested, which count as "
                                     "visible: end it before GlScene::draw() returns");
            }
            return true;
        }
    }
    return false;
}

} // namespace occlude
