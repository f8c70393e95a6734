// Where the engine shows its frames: a GLFW window with a report in it, or nothing at all.
#pragma once

#include <glm/vec2.hpp>

#include <memory>
#include <string>

namespace gl_engine {

/// Input of the user.
struct Keys {
    bool cut = false;   ///< C: cut to another place
    bool pause = false; ///< P: stop the world, or let it go on
    bool quit = false;  ///< escape, or the window was closed
};

class Window {
public:
    /// Creates an OpenGL 4.5 core context and makes it current. Returns null, with a sentence on
    /// stderr, if that fails.
    static std::unique_ptr<Window> open(glm::ivec2 size_px);
    /// The same without a window or a display server.
    static std::unique_ptr<Window> open_headless();
    virtual ~Window() = default;

    /// Shows the default framebuffer, with `report` over it. Returns the keys pressed since the
    /// last call.
    virtual Keys show(const std::string& report) = 0;
    virtual bool has_framebuffer() const = 0;

    /// Creates another context, as some engines do when the user changes settings. All OpenGL
    /// objects of the old one are lost.
    virtual bool recreate_context() = 0;
};

} // namespace gl_engine
