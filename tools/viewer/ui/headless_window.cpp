#include "viewer/ui/window.h"

#include <imgui.h>

#include <utility>

namespace occlude::tools::viewer {

namespace {

class HeadlessWindow final : public Window {
public:
    HeadlessWindow(std::shared_ptr<GlContext> context, glm::ivec2 size)
        : context_(std::move(context))
        , size_(size)
    {
        // The codes of keys.h, which are GLFW's.
        ImGuiIO& io = ImGui::GetIO();
        io.KeyMap[ImGuiKey_Escape] = 256;
        io.KeyMap[ImGuiKey_Enter] = 257;
        io.KeyMap[ImGuiKey_Tab] = 258;
        io.KeyMap[ImGuiKey_Backspace] = 259;
        io.KeyMap[ImGuiKey_Delete] = 261;
        io.KeyMap[ImGuiKey_RightArrow] = 262;
        io.KeyMap[ImGuiKey_LeftArrow] = 263;
        io.KeyMap[ImGuiKey_DownArrow] = 264;
        io.KeyMap[ImGuiKey_UpArrow] = 265;
        io.KeyMap[ImGuiKey_Home] = 268;
        io.KeyMap[ImGuiKey_End] = 269;
        io.KeyMap[ImGuiKey_Space] = ' ';
        io.KeyMap[ImGuiKey_A] = 'A';
        io.MousePos = {-1.0f, -1.0f};
    }

    std::shared_ptr<GlContext> context() override { return context_; }
    glm::ivec2 size() const override { return size_; }
    glm::ivec2 pixels() const override { return size_; }
    float scale() const override { return 1.0f; }
    std::vector<InputEvent> events() override { return std::exchange(events_, {}); }
    FlyInput gamepad() const override { return {}; }
    void present(const Canvas&) override {}
    bool closed() const override { return false; }

    void feed(const InputEvent& event) override
    {
        ImGuiIO& io = ImGui::GetIO();
        switch (event.kind) {
        case InputEvent::Kind::key:
            io.KeysDown[event.code] = event.down;
            io.KeyCtrl = event.control && event.down;
            break;
        case InputEvent::Kind::button:
            io.MouseDown[event.code] = event.down;
            break;
        case InputEvent::Kind::move:
            io.MousePos = {event.at.x, event.at.y};
            break;
        case InputEvent::Kind::scroll:
            io.MouseWheel += event.at.y;
            break;
        case InputEvent::Kind::character:
            io.AddInputCharacter(static_cast<unsigned>(event.code));
            break;
        case InputEvent::Kind::resize:
            size_ = glm::ivec2{event.at};
            break;
        case InputEvent::Kind::drop:
            break;
        }
        events_.push_back(event);
    }

    void begin_ui_frame(double seconds) override
    {
        ImGuiIO& io = ImGui::GetIO();
        io.DisplaySize = {static_cast<float>(size_.x), static_cast<float>(size_.y)};
        io.DeltaTime = static_cast<float>(seconds);
    }

private:
    std::shared_ptr<GlContext> context_;
    glm::ivec2 size_;
    std::vector<InputEvent> events_;
};

} // namespace

Result<std::unique_ptr<Window>> open_headless_window(glm::ivec2 size)
{
    auto context = make_headless_gl_context();
    if (!context) {
        return context.error();
    }
    return std::unique_ptr<Window>{std::make_unique<HeadlessWindow>(std::move(*context), size)};
}

} // namespace occlude::tools::viewer
