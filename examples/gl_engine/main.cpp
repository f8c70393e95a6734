// A typical OpenGL engine with occlusion culling: reversed Z, multisampling, a shadow map, draws
// sorted by material, moving objects, and a key that cuts to another place.
//
//   gl_engine                              in a window
//   gl_engine --headless --frames 8        without a window; checks itself and reports faults
//   gl_engine --headless --bug NAME        the same with a common mistake of integrations
//
// Exit code 0: all frames are right and nothing was reported; 1: something was; 2: no OpenGL.
#include "bugs.h"
#include "renderer.h"
#include "town.h"
#include "window.h"
#include "writing_device.h"

#include <occlude/backends/gl/gl_device.h>
#include <occlude/cull/adaptive.h>
#include <occlude/cull/chc_plus_plus.h>
#include <occlude/device/validating_device.h>
#include <occlude/hierarchy/builders/bvh_builder.h>
#include <occlude/integration/audit.h>
#include <occlude/integration/verify_frame.h>

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/matrix.hpp>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

using namespace occlude;
using namespace gl_engine;

namespace {

constexpr ClipConvention kReversedZ{DepthRange::zero_to_one, DepthOrder::near_is_large};

struct Arguments {
    bool headless = false;
    int frames = 8; ///< headless only
    Bug bug = Bug::none;
};

// Messages of the library, and findings of the engine's own checks.
int problems = 0;

void say(const std::string& text)
{
    std::fprintf(stderr, "%s\n", text.c_str());
    ++problems;
}

void hear(const Message& message)
{
    say(std::string(name(message.severity)) + " " + std::string(message.name) + ": " +
        std::string(message.text));
}

// Reversed Z, and no far plane.
glm::mat4 camera(glm::vec3 eye, glm::vec3 target, float aspect)
{
    const float f = 1.0f / std::tan(0.5f * glm::radians(65.0f));
    glm::mat4 clip_from_eye{0.0f};
    clip_from_eye[0][0] = f / aspect;
    clip_from_eye[1][1] = f;
    clip_from_eye[2][3] = -1.0f;
    clip_from_eye[3][2] = 0.2f; // near
    return clip_from_eye * glm::lookAt(eye, target, {0.0f, 1.0f, 0.0f});
}

glm::mat4 light()
{
    const float r = 0.75f * Town::kSide;
    const glm::mat4 clip_from_eye = glm::orthoRH_ZO(-r, r, -r, r, 2.0f * r, -r); // reversed
    return clip_from_eye *
           glm::lookAt(glm::vec3{40.0f, 80.0f, 30.0f}, {0.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f});
}

Result<std::unique_ptr<GlDevice>> make_device(GlScene& scene)
{
    return GlDevice::create(scene,
                            {.on_message = hear, .state_checks = GlStateChecks::after_draws});
}

class Engine {
public:
    Engine(const Arguments& arguments, Window& window, glm::ivec2 size_px)
        : arguments_(arguments)
        , window_(window)
        , renderer_(town_, size_px)
        , camera_pass_(renderer_, arguments.bug)
        , shadow_pass_(renderer_)
        , hierarchy_(build_bvh(town_.bounds(), {.leaf_triangles = 400}))
        , shadow_culler_(hierarchy_)
    {
        if (arguments.bug == Bug::standing_clock) {
            camera_culler_ =
                std::make_unique<Adaptive>(hierarchy_, AdaptiveOptions{}, [] { return 1.0; });
        } else {
            camera_culler_ = std::make_unique<ChcPlusPlus>(hierarchy_);
        }
    }

    bool make_devices()
    {
        auto for_camera = make_device(camera_pass_);
        auto for_shadow = make_device(shadow_pass_);
        if (!for_camera || !for_shadow) {
            say((for_camera ? for_shadow : for_camera).error().message);
            return false;
        }
        camera_device_ = std::move(*for_camera);
        shadow_device_ = std::move(*for_shadow);
        return true;
    }

    /// One frame. False to quit.
    bool frame(int number);

private:
    void update(int number);
    View camera_view() const;
    View shadow_view() const
    {
        return View::from_clip(light(), glm::ivec2{Renderer::kShadowSize}, kReversedZ);
    }
    void check(const View& view, int number);
    std::string report_text(const FrameReport& camera, const FrameReport& shadow) const;

    Arguments arguments_;
    Window& window_;
    Town town_;
    Renderer renderer_;
    CameraPass camera_pass_;
    ShadowPass shadow_pass_;
    Hierarchy hierarchy_;
    std::unique_ptr<Culler> camera_culler_; ///< one culler per view
    ChcPlusPlus shadow_culler_;
    std::unique_ptr<GlDevice> camera_device_;
    std::unique_ptr<GlDevice> shadow_device_;
    double seconds_ = 0.0;
    double place_ = 0.0; ///< distance of the camera along its way
    bool paused_ = false;
};

// Moves the objects and updates the tree: once a frame, before any view is culled.
void Engine::update(int number)
{
    seconds_ += paused_ ? 0.0 : 1.0 / 60.0;
    place_ += paused_ ? 0.0 : 0.01;
    town_.move_to(seconds_ + (number >= 2 ? 3.0 : 0.0));
    std::vector<ItemBounds> bounds = town_.bounds();
    if (arguments_.bug == Bug::box_too_small) {
        bounds[1].box.max.y -= 2.0f; // as if the roof were forgotten
    }
    if (arguments_.bug != Bug::forgotten_refit) {
        hierarchy_.refit(bounds);
    }
    if (arguments_.bug == Bug::recreated_context && number == 2) {
        window_.recreate_context();
        renderer_.create_objects(); // and the devices are forgotten
    }
}

View Engine::camera_view() const
{
    const glm::ivec2 size = renderer_.size_px();
    switch (arguments_.bug) {
    case Bug::depth_convention:
        return View::from_clip(camera_pass_.clip_from_world, size);
    case Bug::swapped_size:
        return View::from_clip(camera_pass_.clip_from_world, {size.y, size.x}, kReversedZ);
    case Bug::transposed_matrix:
        return View::from_clip(glm::transpose(camera_pass_.clip_from_world), size, kReversedZ);
    default:
        return View::from_clip(camera_pass_.clip_from_world, size, kReversedZ);
    }
}

bool Engine::frame(int number)
{
    update(number);
    const auto angle = static_cast<float>(place_);
    const float radius = 0.4f * Town::kSide;
    const glm::vec3 eye{radius * std::sin(angle), 2.0f, radius * std::cos(angle)};
    const glm::ivec2 size = renderer_.size_px();
    camera_pass_.frame = number;
    camera_pass_.clip_from_light = light();
    camera_pass_.clip_from_world =
        camera(eye, {0.0f, 3.0f, 0.0f}, static_cast<float>(size.x) / static_cast<float>(size.y));

    const FrameReport shadow = shadow_culler_.cull(shadow_view(), *shadow_device_);
    const View view = camera_view();
    WritingDevice writing{*camera_device_, arguments_.bug == Bug::depth_writes_in_tests};
    FrameReport report;
    if (arguments_.headless) {
        // Slow: checks the contract between culler and device, and that tests write nothing.
        ValidatingDevice checked{writing,
                                 {.on_violation =
                                      [](std::string_view rule, std::string_view text) {
                                          say("contract " + std::string(rule) + ": " +
                                              std::string(text));
                                      },
                                  .depth_checks = ValidatingDevice::DepthChecks::around_batches}};
        report = camera_culler_->cull(view, checked);
        if (report.plan.reason == FramePlan::Reason::useless_clock &&
            number + 1 == arguments_.frames) {
            say("plan: " + to_string(report.plan));
        }
        check(view, number);
    } else {
        report = camera_culler_->cull(view, writing);
        renderer_.present(0);
    }
    if (!arguments_.headless || number + 1 == arguments_.frames) {
        const std::string text = report_text(report, shadow);
        if (arguments_.headless) {
            std::printf("%s\n", text.c_str());
        }
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
        const Keys keys = window_.show(text);
        paused_ = keys.pause ? !paused_ : paused_;
        if (keys.cut) {
            place_ += 2.0;
            camera_culler_->reset(); // without this one frame takes longer, and no pixel changes
        }
        return !keys.quit;
    }
    return true;
}

// For a new integration: asks the library whether its input matches what the engine draws.
void Engine::check(const View& view, int number)
{
    if (number != 3) {
        return;
    }
    const std::vector<ItemBounds> bounds = town_.bounds();
    for (const ItemId stale : stale_items(hierarchy_, bounds)) {
        say("item " + std::to_string(stale.value) +
            " has another box than the hierarchy knows: refit() was forgotten, or given other "
            "boxes");
        break; // one is enough
    }
    std::vector<ItemBounds> told(bounds.size());
    for (size_t i = 0; i < hierarchy_.items().size(); ++i) {
        told[hierarchy_.items()[i].value] = hierarchy_.item_bounds()[i];
    }
    const auto audit = audit_item_bounds(*camera_device_, view, told);
    if (audit && !audit->verdict.empty()) {
        say("audit: " + audit->verdict);
    }
    const auto verified = verify_frame(*camera_culler_, view, *camera_device_);
    if (verified) {
        for (const MissedItem& missed : verified->missing) {
            say("verify: " + missed.text);
        }
    }
}

std::string Engine::report_text(const FrameReport& camera, const FrameReport& shadow) const
{
    const auto line = [&](const char* view, const FrameReport& report) {
        const FrameCounters& c = report.counters;
        return std::string(view) + ": " + std::to_string(c.items_drawn) + " of " +
               std::to_string(hierarchy_.items().size()) + " items, " +
               std::to_string(c.triangles_drawn) + " triangles, " + std::to_string(c.queries) +
               " tests, " + std::to_string(c.waits) + " waits, " + to_string(report.guarantee);
    };
    return line("camera", camera) + "\n" + line("shadow", shadow);
}

Arguments parse(int argc, char** argv)
{
    Arguments arguments;
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        const bool has_value = i + 1 < argc;
        if (argument == "--headless") {
            arguments.headless = true;
        } else if (argument == "--frames" && has_value) {
            arguments.frames = std::atoi(argv[++i]);
        } else if (const auto bug =
                       argument == "--bug" && has_value ? bug_by_name(argv[i + 1]) : std::nullopt) {
            arguments.bug = *bug;
            ++i;
        } else {
            std::fprintf(stderr, "usage: gl_engine [--headless] [--frames N] [--bug NAME]\nbugs:");
            for (const std::string_view known : kBugNames) {
                std::fprintf(stderr, " %s", std::string(known).c_str());
            }
            std::fprintf(stderr, "\n");
            std::exit(2);
        }
    }
    return arguments;
}

} // namespace

int main(int argc, char** argv)
{
    const Arguments arguments = parse(argc, argv);
    const glm::ivec2 size = arguments.headless ? glm::ivec2{320, 180} : glm::ivec2{1280, 720};
    const std::unique_ptr<Window> window =
        arguments.headless ? Window::open_headless() : Window::open(size);
    if (window == nullptr) {
        return 2;
    }
    Engine engine(arguments, *window, size);
    if (!engine.make_devices()) {
        return 2;
    }
    for (int number = 0; !arguments.headless || number < arguments.frames; ++number) {
        if (!engine.frame(number)) {
            break;
        }
    }
    return problems == 0 ? 0 : 1;
}
