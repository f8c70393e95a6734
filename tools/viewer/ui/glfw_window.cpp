#include "viewer/keys.h"
#include "viewer/ui/window.h"

#include <epoxy/gl.h>

// After epoxy, which stands in for the OpenGL header that GLFW would include.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace occlude::tools::viewer {

namespace {

static_assert(GLFW_KEY_ESCAPE == 256 && GLFW_KEY_ENTER == 257 && GLFW_KEY_DELETE == 261 &&
                  GLFW_KEY_HOME == 268 && GLFW_KEY_F1 == 290 && GLFW_KEY_LEFT_SHIFT == 340 &&
                  GLFW_KEY_LEFT_ALT == 342 && GLFW_KEY_PERIOD == '.',
              "keys.cpp has the codes of GLFW");

// Ends GLFW when the last owner is gone: the context may outlive the window object.
struct Library {
    Library() { ready = glfwInit() == GLFW_TRUE; }
    ~Library() { glfwTerminate(); }
    Library(const Library&) = delete;
    Library& operator=(const Library&) = delete;
    bool ready = false;
};

class WindowContext final : public GlContext {
public:
    WindowContext(std::unique_ptr<Library> library, GLFWwindow* window)
        : library_(std::move(library))
        , window_(window)
    {
    }
    ~WindowContext() override { glfwDestroyWindow(window_); }
    void make_current() override
    {
        if (glfwGetCurrentContext() != window_) {
            glfwMakeContextCurrent(window_);
        }
    }
    GLFWwindow* window() const { return window_; }

private:
    std::unique_ptr<Library> library_;
    GLFWwindow* window_;
};

class GlfwWindow final : public Window {
public:
    explicit GlfwWindow(std::shared_ptr<WindowContext> context)
        : context_(std::move(context))
        , window_(context_->window())
    {
        glfwSetWindowUserPointer(window_, this);
        glfwSetKeyCallback(window_, on_key);
        glfwSetCharCallback(window_, on_character);
        glfwSetMouseButtonCallback(window_, on_button);
        glfwSetCursorPosCallback(window_, on_move);
        glfwSetScrollCallback(window_, on_scroll);
        glfwSetDropCallback(window_, on_drop);
        glfwSetWindowFocusCallback(window_, ImGui_ImplGlfw_WindowFocusCallback);
        glfwSetCursorEnterCallback(window_, ImGui_ImplGlfw_CursorEnterCallback);
        ImGui_ImplGlfw_InitForOpenGL(window_, false);
    }
    ~GlfwWindow() override { ImGui_ImplGlfw_Shutdown(); }

    std::shared_ptr<GlContext> context() override { return context_; }
    glm::ivec2 size() const override
    {
        glm::ivec2 size{0};
        glfwGetWindowSize(window_, &size.x, &size.y);
        return size;
    }
    glm::ivec2 pixels() const override
    {
        glm::ivec2 size{0};
        glfwGetFramebufferSize(window_, &size.x, &size.y);
        return size;
    }
    float scale() const override
    {
        float x = 1.0f;
        float y = 1.0f;
        glfwGetWindowContentScale(window_, &x, &y);
        // Where pixels of the window are larger than those of the framebuffer, they scale already.
        const float own =
            static_cast<float>(pixels().x) / static_cast<float>(std::max(size().x, 1));
        return std::max(x / std::max(own, 1.0f), 1.0f);
    }

    std::vector<InputEvent> events() override
    {
        glfwPollEvents();
        return std::exchange(events_, {});
    }

    void feed(const InputEvent& event) override
    {
        const int action = event.down ? GLFW_PRESS : GLFW_RELEASE;
        const int mods = event.control ? GLFW_MOD_CONTROL : 0;
        switch (event.kind) {
        case InputEvent::Kind::key:
            on_key(window_, event.code, 0, action, mods);
            break;
        case InputEvent::Kind::button:
            on_button(window_, event.code, action, mods);
            break;
        case InputEvent::Kind::move:
            glfwSetCursorPos(window_, event.at.x, event.at.y);
            on_move(window_, event.at.x, event.at.y);
            break;
        case InputEvent::Kind::scroll:
            on_scroll(window_, event.at.x, event.at.y);
            break;
        case InputEvent::Kind::character:
            on_character(window_, static_cast<unsigned>(event.code));
            break;
        case InputEvent::Kind::resize:
            glfwSetWindowSize(window_, static_cast<int>(event.at.x), static_cast<int>(event.at.y));
            break;
        case InputEvent::Kind::drop:
            events_.push_back(event);
            break;
        }
    }

    FlyInput gamepad() const override;

    void begin_ui_frame(double) override { ImGui_ImplGlfw_NewFrame(); }

    void present(const Canvas& screen) override
    {
        const glm::ivec2 to = pixels();
        screen.copy_to(0, to);
        glfwSwapBuffers(window_);
    }
    bool closed() const override { return glfwWindowShouldClose(window_) == GLFW_TRUE; }

private:
    static GlfwWindow& self(GLFWwindow* window)
    {
        return *static_cast<GlfwWindow*>(glfwGetWindowUserPointer(window));
    }
    static void on_key(GLFWwindow* window, int key, int scancode, int action, int mods)
    {
        ImGui_ImplGlfw_KeyCallback(window, key, scancode, action, mods);
        if (key != GLFW_KEY_UNKNOWN && action != GLFW_REPEAT) {
            self(window).events_.push_back({.kind = InputEvent::Kind::key,
                                            .code = key,
                                            .down = action == GLFW_PRESS,
                                            .control = (mods & GLFW_MOD_CONTROL) != 0});
        }
    }
    static void on_character(GLFWwindow* window, unsigned character)
    {
        ImGui_ImplGlfw_CharCallback(window, character);
        self(window).events_.push_back(
            {.kind = InputEvent::Kind::character, .code = static_cast<int>(character)});
    }
    static void on_button(GLFWwindow* window, int button, int action, int mods)
    {
        ImGui_ImplGlfw_MouseButtonCallback(window, button, action, mods);
        double x = 0.0;
        double y = 0.0;
        glfwGetCursorPos(window, &x, &y);
        self(window).events_.push_back({.kind = InputEvent::Kind::button,
                                        .code = button,
                                        .down = action == GLFW_PRESS,
                                        .control = (mods & GLFW_MOD_CONTROL) != 0,
                                        .at = {static_cast<float>(x), static_cast<float>(y)}});
    }
    static void on_move(GLFWwindow* window, double x, double y)
    {
        self(window).events_.push_back(
            {.kind = InputEvent::Kind::move, .at = {static_cast<float>(x), static_cast<float>(y)}});
    }
    static void on_scroll(GLFWwindow* window, double x, double y)
    {
        ImGui_ImplGlfw_ScrollCallback(window, x, y);
        self(window).events_.push_back({.kind = InputEvent::Kind::scroll,
                                        .at = {static_cast<float>(x), static_cast<float>(y)}});
    }
    static void on_drop(GLFWwindow* window, int count, const char** paths)
    {
        if (count > 0) {
            self(window).events_.push_back({.kind = InputEvent::Kind::drop, .text = paths[0]});
        }
    }

    std::shared_ptr<WindowContext> context_;
    GLFWwindow* window_;
    std::vector<InputEvent> events_;
};

// The left stick flies, the right one looks, the triggers sink and rise; a bumper is faster.
FlyInput GlfwWindow::gamepad() const
{
    constexpr float kDeadZone = 0.15f;
    constexpr float kFast = 4.0f;
    FlyInput input;
    GLFWgamepadstate pad;
    if (glfwJoystickIsGamepad(GLFW_JOYSTICK_1) != GLFW_TRUE ||
        glfwGetGamepadState(GLFW_JOYSTICK_1, &pad) != GLFW_TRUE) {
        return input;
    }
    const auto axis = [&](int index) {
        const float value = pad.axes[index];
        return std::abs(value) < kDeadZone ? 0.0f : value;
    };
    const float rise = 0.5f * (pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER] -
                               pad.axes[GLFW_GAMEPAD_AXIS_LEFT_TRIGGER]);
    input.move = {axis(GLFW_GAMEPAD_AXIS_LEFT_X), rise, -axis(GLFW_GAMEPAD_AXIS_LEFT_Y)};
    input.turn = {axis(GLFW_GAMEPAD_AXIS_RIGHT_X), -axis(GLFW_GAMEPAD_AXIS_RIGHT_Y)};
    input.pace = pad.buttons[GLFW_GAMEPAD_BUTTON_RIGHT_BUMPER] != 0 ? kFast : 1.0f;
    return input;
}

Error no_window()
{
    const char* reason = nullptr;
    glfwGetError(&reason);
    return {ErrorCode::unsupported,
            std::string{"no window: "} +
                (reason != nullptr ? reason : "the desktop gives no OpenGL 3.3") +
                "; 'occlude view --headless' and 'occlude render' need none"};
}

} // namespace

Result<std::unique_ptr<Window>> open_desktop_window(glm::ivec2 size, const std::string& title)
{
    auto library = std::make_unique<Library>();
    if (!library->ready) {
        return no_window();
    }
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_DEPTH_BITS, 0); // pictures have depth buffers of their own
    glfwWindowHint(GLFW_STENCIL_BITS, 0);
    GLFWwindow* window = nullptr;
    constexpr std::array<std::pair<int, int>, 3> kVersions = {{{4, 5}, {4, 3}, {3, 3}}};
    for (const auto& [major, minor] : kVersions) {
        glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, major);
        glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, minor);
        window = glfwCreateWindow(size.x, size.y, title.c_str(), nullptr, nullptr);
        if (window != nullptr) {
            break;
        }
    }
    if (window == nullptr) {
        return no_window();
    }
    auto context = std::make_shared<WindowContext>(std::move(library), window);
    context->make_current();
    glfwSwapInterval(1);
    return std::unique_ptr<Window>{std::make_unique<GlfwWindow>(std::move(context))};
}

} // namespace occlude::tools::viewer
