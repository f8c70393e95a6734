// Where the viewer is shown and where its input comes from: a window, or nothing at all.
#pragma once

#include "render/gl_context.h"
#include "viewer/canvas.h"
#include "viewer/state.h"

#include <occlude/core/result.h>

#include <glm/vec2.hpp>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace occlude::tools::viewer {

/// What the user did; from a real device or from a script, which take the same way.
struct InputEvent {
    enum class Kind : uint8_t { key, button, move, scroll, character, drop, resize };
    Kind kind = Kind::key;
    int code = 0;          ///< of the key (keys.h), the button (0: left, 1: right), the character
    bool down = false;     ///< keys and buttons
    bool control = false;  ///< held at that moment
    glm::vec2 at{0.0f};    ///< the mouse, from the upper left; the wheel's notches; the new size
    std::string text = {}; ///< the dropped file
};

class Window {
public:
    virtual ~Window() = default;

    virtual std::shared_ptr<GlContext> context() = 0;
    /// Of the window, in its own pixels, and of what is drawn into it.
    virtual glm::ivec2 size() const = 0;
    virtual glm::ivec2 pixels() const = 0;
    /// How much larger than usual panels should be.
    virtual float scale() const = 0;

    /// Everything that happened since the last call.
    virtual std::vector<InputEvent> events() = 0;
    /// Makes something happen, as if the user had done it.
    virtual void feed(const InputEvent& event) = 0;
    /// What a gamepad says now.
    virtual FlyInput gamepad() const = 0;

    /// Tells ImGui of the window, the time and the input. Between ImGui's context and NewFrame().
    virtual void begin_ui_frame(double seconds) = 0;
    /// Shows a finished picture of pixels() size.
    virtual void present(const Canvas& screen) = 0;
    /// The user closed it.
    virtual bool closed() const = 0;
};

/// A window on the desktop. Fails where there is none. ImGui must have a context.
Result<std::unique_ptr<Window>> open_desktop_window(glm::ivec2 size, const std::string& title);

/// No window: input comes from scripts alone. ImGui must have a context.
Result<std::unique_ptr<Window>> open_headless_window(glm::ivec2 size);

} // namespace occlude::tools::viewer
