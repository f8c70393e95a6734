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

namespace {

// ImGui shows some changes, an opened list for one, a frame after the input.
constexpr int kFramesAfterInput = 2;

// Cuts a list of panels down to what lies over a rectangle; false if that is nothing.
bool clip_to(ImDrawList& list, ImVec2 low, ImVec2 high)
{
    bool any = false;
    for (ImDrawCmd& command : list.CmdBuffer) {
        ImVec4& clip = command.ClipRect;
        clip = {std::max(clip.x, low.x), std::max(clip.y, low.y), std::min(clip.z, high.x),
                std::min(clip.w, high.y)};
        any = any || (clip.z > clip.x && clip.w > clip.y && command.ElemCount > 0);
    }
    return any;
}

} // namespace

App::App(std::unique_ptr<Window> window, StageOptions options, Settings settings, float scale)
    : window_(std::move(window))
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
    picture_list_.reset();
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

// Everything but a mouse that moves over the picture alone.
bool App::concerns_panels(const InputEvent& event) const
{
    const auto over_picture = [&](glm::vec2 at) { return layout_.in_picture({at.x, at.y}); };
    return event.kind != InputEvent::Kind::move || ImGui::GetIO().WantCaptureMouse ||
           (drag_ == Drag::none && !(over_picture(event.at) && over_picture(mouse_)));
}

void App::handle(const InputEvent& event)
{
    constexpr float kFasterPerNotch = 1.15f;
    if (concerns_panels(event)) {
        panel_clock_.frames_due = kFramesAfterInput;
    }
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

// Panels keep their pixels on the screen until something happens to them, or until making them
// again takes at most kShareOfTime of the time.
bool App::panels_need_renewal(double seconds)
{
    constexpr double kShareOfTime = 0.03;
    constexpr double kLeastAge = 0.1; // seconds
    constexpr double kMostAge = 1.0;
    PanelClock& clock = panel_clock_;
    clock.age_s += seconds;
    const glm::vec2 picture_min{layout_.picture_min.x, layout_.picture_min.y};
    const glm::vec2 picture_max{layout_.picture_max.x, layout_.picture_max.y};
    const bool moved = window_->pixels() != clock.screen || picture_min != clock.picture_min ||
                       picture_max != clock.picture_max;
    const bool old = clock.age_s >= std::clamp(clock.cost_s / kShareOfTime, kLeastAge, kMostAge);
    if (!moved && !old && clock.frames_due == 0 && !screen_notes().reading) {
        return false;
    }
    clock.frames_due = std::max(clock.frames_due - 1, 0);
    clock.screen = window_->pixels();
    clock.picture_min = picture_min;
    clock.picture_max = picture_max;
    return true;
}

void App::render(std::span<ImDrawList*> lists)
{
    ImDrawData data;
    data.Valid = true;
    data.CmdLists = lists.data();
    data.CmdListsCount = static_cast<int>(lists.size());
    for (const ImDrawList* list : lists) {
        data.TotalIdxCount += list->IdxBuffer.Size;
        data.TotalVtxCount += list->VtxBuffer.Size;
    }
    data.DisplaySize = ImGui::GetIO().DisplaySize;
    data.FramebufferScale = ImGui::GetIO().DisplayFramebufferScale;
    ImGui_ImplOpenGL3_RenderDrawData(&data);
}

void App::make_panels()
{
    window_->begin_ui_frame(panel_clock_.age_s);
    panel_clock_.age_s = 0.0;
    ImGui_ImplOpenGL3_NewFrame();
    ImGui::NewFrame();
    show_panels(*viewer_, layout_);
    ImGui::Render();
}

// The place of the picture while there is no scene.
void App::clear_picture() const
{
    const float ratio = static_cast<float>(screen_.size().x) / std::max(layout_.window.x, 1.0f);
    const auto pixel = [&](float at) { return static_cast<int>(at * ratio); };
    const ImVec2 size = layout_.picture_size();
    glEnable(GL_SCISSOR_TEST);
    glScissor(pixel(layout_.picture_min.x), screen_.size().y - pixel(layout_.picture_max.y),
              pixel(size.x) + 1, pixel(size.y) + 1);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glClearColor(0.06f, 0.07f, 0.08f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT);
    glDisable(GL_SCISSOR_TEST);
}

// What is written over the picture, then the panels: all of them if they were made again, otherwise
// the windows, lists and hints that reach over the picture.
void App::draw_panels(bool renewed)
{
    if (!picture_list_) {
        picture_list_ = std::make_unique<ImDrawList>(ImGui::GetDrawListSharedData());
    }
    picture_list_->_ResetForNewFrame();
    picture_list_->PushTextureID(ImGui::GetIO().Fonts->TexID);
    picture_list_->PushClipRectFullScreen();
    picture_layer(*viewer_, layout_, *picture_list_);
    std::vector<ImDrawList*> lists{picture_list_.get()};
    if (renewed) {
        const ImDrawData& panels = *ImGui::GetDrawData();
        lists.insert(lists.end(), panels.CmdLists, panels.CmdLists + panels.CmdListsCount);
    } else {
        lists.insert(lists.end(), lists_over_picture_.begin(), lists_over_picture_.end());
    }
    screen_.bind(window_->pixels());
    render(lists);
    if (renewed) {
        lists_over_picture_.clear();
        std::copy_if(lists.begin() + 1, lists.end(), std::back_inserter(lists_over_picture_),
                     [&](ImDrawList* list) {
                         const ImVec2 high{layout_.picture_max.x,
                                           layout_.picture_max.y + layout_.legend_height};
                         return clip_to(*list, layout_.picture_min, high);
                     });
    }
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
                          {static_cast<float>(size.x), static_cast<float>(size.y)},
                          viewer_->legend_lines());
    viewer_->state().panels.narrow = layout_.narrow;
    viewer_->advance(seconds, fly_input());
    viewer_->draw(picture_pixels());
    window_->context()->make_current();
    screen_.bind(window_->pixels());
    if (viewer_->session() != nullptr) {
        copy_pictures(*viewer_, layout_, screen_);
    } else {
        clear_picture();
    }
    glFinish(); // what the frame took is not the panels' fault
    const double drawn = clock();
    screen_notes().clear();
    const bool renewed = panels_need_renewal(seconds);
    if (renewed) {
        make_panels();
    }
    draw_panels(renewed);
    while (glGetError() != GL_NO_ERROR) {
        ++gl_errors_;
    }
    glFinish();
    const double panels_s = clock() - drawn;
    panel_clock_.cost_s = renewed ? panels_s : panel_clock_.cost_s;
    if (viewer_->requests().screenshot) {
        write_screenshot();
    }
    window_->present(screen_);
    if (viewer_->session() != nullptr && !viewer_->loader().loading()) {
        timing_.frames_s += clock() - start;
        timing_.panels_s += panels_s;
        timing_.panel_frames += renewed ? 1 : 0;
        ++timing_.frames;
    }
}

} // namespace occlude::tools::viewer
