// Where the engine shows its frames: a GLFW window with a report in it, or nothing at all.
#pragma once

#include <glm/vec2.hpp>

#include <memory>
#include <string>

namespace gl_engine {

/// What the user asks for, besides looking on.
struct Keys {
    bool cut = false;   ///< C: to another place at once
    bool pause = false; ///< P: the world stands still, or goes on
    bool quit = false;  ///< escape, or the window was closed
};

class Window {
public:
    /// An OpenGL 4.5 core context that is current from now on. Null, and a sentence on stderr, if
    /// there is none.
    static std::unique_ptr<Window> open(glm::ivec2 size_px);
    /// The same without a window or a display server.
    static std::unique_ptr<Window> open_headless();
    virtual ~Window() = default;

    /// Shows what is in the default framebuffer, and `report` over it. Returns the keys pressed
    /// since the last call.
    virtual Keys show(const std::string& report) = 0;
    virtual bool has_framebuffer() const = 0;

    /// Another context, as some engines make when the user changes settings. All OpenGL objects of
    /// the old one are gone.
    virtual bool recreate_context() = 0;
};

} // namespace gl_engine
