#include "viewer/ui/app.h"

#include "render/image.h"
#include "viewer/numbered_file.h"

#include <epoxy/gl.h>

#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>
#include <imgui.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace occlude::tools::viewer {

App::App(std::unique_ptr<Window> window, StageOptions options, Settings settings, float scale,
         bool always_panels)
    : window_(std::move(window))
    , always_panels_(always_panels)
{
    const float wanted = scale > 0.0f            ? scale
                         : settings.scale > 0.0f ? settings.scale
                                                 : window_->scale();
    ImGui::GetIO().IniFilename = nullptr;
    set_up_style(wanted);
    window_->context()->make_current();
    ImGui_ImplOpenGL3_Init("#version 330 core");
    viewer_ = std::make_unique<Viewer>(window_->context(), std::move(options), std::move(settings));
}

App::~App()
{
    window_->context()->make_current();
    viewer_.reset();
    ImGui_ImplOpenGL3_Shutdown();
}

bool App::near_divider(glm::vec2 at) const
{
    constexpr float kReach = 8.0f;
    const PictureState& picture = viewer_->state().picture;
    const float x = layout_.picture_min.x + picture.divider * layout_.picture_size().x;
    return picture.split && !picture.difference && std::abs(at.x - x) < scaled(kReach);
}

void App::handle_key(const InputEvent& event)
{
    if (!event.down) {
        keys_down_.erase(event.code);
        return;
    }
    if (ImGui::GetIO().WantTextInput) {
        return; // somebody types
    }
    if (const auto command = command_of(event.code, event.control)) {
        viewer_->execute(*command);
    }
    if (!event.control) {
        keys_down_.insert(event.code);
    }
}

void App::handle_button(const InputEvent& event)
{
    constexpr float kClickReach = 4.0f; // pixels that the mouse may move in a click
    mouse_ = event.at;
    const ImVec2 at{mouse_.x, mouse_.y};
    if (event.down) {
        if (ImGui::GetIO().WantCaptureMouse || !layout_.in_picture(at)) {
            return;
        }
        dragged_ = 0.0f;
        drag_ = event.code == 1 ? Drag::orbit : near_divider(mouse_) ? Drag::divider : Drag::look;
        return;
    }
    if (drag_ == Drag::look && dragged_ < kClickReach) {
        const ImVec2 size = layout_.picture_size();
        const glm::vec2 pixels{picture_pixels()};
        viewer_->pick({static_cast<int>((at.x - layout_.picture_min.x) / size.x * pixels.x),
                       static_cast<int>((layout_.picture_max.y - at.y) / size.y * pixels.y)});
    }
    drag_ = Drag::none;
}

void App::handle_move(glm::vec2 at)
{
    constexpr float kRadiansPerPixel = 0.004f;
    const glm::vec2 by = at - mouse_;
    mouse_ = at;
    dragged_ += glm::length(by);
    switch (drag_) {
    case Drag::none:
        break;
    case Drag::look:
    case Drag::orbit:
        viewer_->look({kRadiansPerPixel * by.x, -kRadiansPerPixel * by.y}, drag_ == Drag::orbit);
        break;
    case Drag::divider:
        viewer_->state().picture.divider =
            std::clamp((at.x - layout_.picture_min.x) / layout_.picture_size().x, 0.02f, 0.98f);
        break;
    }
}

void App::handle(const InputEvent& event)
{
    constexpr float kFasterPerNotch = 1.15f;
    input_came_ = true;
    switch (event.kind) {
    case InputEvent::Kind::key:
        handle_key(event);
        break;
    case InputEvent::Kind::button:
        handle_button(event);
        break;
    case InputEvent::Kind::move:
        handle_move(event.at);
        break;
    case InputEvent::Kind::scroll:
        if (layout_.in_picture({mouse_.x, mouse_.y}) && !ImGui::GetIO().WantCaptureMouse) {
            float& speed = viewer_->state().camera.speed;
            speed = std::clamp(speed * std::pow(kFasterPerNotch, event.at.y), 0.05f, 20.0f);
            viewer_->say(fmt::format("speed {:.2f}", speed));
        }
        break;
    case InputEvent::Kind::drop:
        viewer_->open(event.text);
        break;
    case InputEvent::Kind::character:
    case InputEvent::Kind::resize:
        break;
    }
}

FlyInput App::fly_input() const
{
    constexpr float kFast = 4.0f;
    FlyInput input = window_->gamepad();
    const FlyKeys& keys = fly_keys();
    const auto held = [&](int more, int less) {
        return static_cast<float>(keys_down_.count(more)) -
               static_cast<float>(keys_down_.count(less));
    };
    input.move += glm::vec3{held(keys.right, keys.left), held(keys.up, keys.down),
                            held(keys.forward, keys.back)};
    input.turn +=
        glm::vec2{held(keys.look_right, keys.look_left), held(keys.look_up, keys.look_down)};
    input.pace *= std::pow(kFast, held(keys.fast, keys.slow));
    return input;
}

glm::ivec2 App::picture_pixels() const
{
    const glm::ivec2 window = window_->size();
    const glm::ivec2 pixels = window_->pixels();
    const float ratio = static_cast<float>(pixels.x) / static_cast<float>(std::max(window.x, 1));
    const ImVec2 size = layout_.picture_size();
    return {std::max(static_cast<int>(size.x * ratio), 1),
            std::max(static_cast<int>(size.y * ratio), 1)};
}

// The panels in front of the picture. Where nothing happened to them they stay as they are on the
// screen, and only the background, which has the picture, is drawn.
void App::draw_ui(double seconds)
{
    constexpr double kOldestPanels = 0.1; // seconds
    const ViewerState& state = viewer_->state();
    panels_age_s_ += seconds;
    // Windows, lists and hints that lie over the picture would vanish under it.
    const bool covered = state.panels.help || ImGui::GetIO().WantCaptureMouse;
    const bool moves = covered || drag_ != Drag::none || viewer_->loader().loading() ||
                       state.picture.flare || !viewer_->marks().empty();
    const bool renew = always_panels_ || input_came_ || moves || panels_age_s_ > kOldestPanels;
    const glm::ivec2 pixels = window_->pixels();
    if (renew) {
        input_came_ = false;
        screen_notes().clear();
        window_->begin_ui_frame(panels_age_s_);
        panels_age_s_ = 0.0;
        ImGui_ImplOpenGL3_NewFrame();
        ImGui::NewFrame();
        show_panels(*viewer_, layout_);
        ImGui::Render();
    }
    screen_.bind(pixels);
    ImDrawData data = *ImGui::GetDrawData();
    if (renew) {
        glDisable(GL_SCISSOR_TEST);
        glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
        glClearColor(0.06f, 0.07f, 0.08f, 1.0f);
        glClear(GL_COLOR_BUFFER_BIT);
    } else {
        data.CmdListsCount = std::min(data.CmdListsCount, 1);
    }
    ImGui_ImplOpenGL3_RenderDrawData(&data);
}

void App::write_screenshot()
{
    viewer_->requests().screenshot = false;
    const auto file = numbered_file("occlude-screenshot", "png");
    const auto written = write_png(file, screenshot());
    viewer_->say(written ? fmt::format("The screenshot is {}.", file.string())
                         : written.error().message,
                 !written);
}

void App::frame(double seconds)
{
    const SecondsClock clock = steady_seconds_clock();
    const double start = clock();
    const glm::ivec2 size = window_->size();
    for (const InputEvent& event : window_->events()) {
        handle(event);
    }
    layout_ = make_layout(viewer_->state().panels,
                          {static_cast<float>(size.x), static_cast<float>(size.y)});
    viewer_->advance(seconds, fly_input());
    viewer_->draw(picture_pixels());
    window_->context()->make_current();
    glFinish(); // what the frame took is not the panels' fault
    const double drawn = clock();
    draw_ui(seconds);
    while (glGetError() != GL_NO_ERROR) {
        ++gl_errors_;
    }
    glFinish();
    timing_.panels_s += clock() - drawn;
    if (viewer_->requests().screenshot) {
        write_screenshot();
    }
    window_->present(screen_);
    timing_.frames_s += clock() - start;
    ++timing_.frames;
}

} // namespace occlude::tools::viewer
