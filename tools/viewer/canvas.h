// Pictures that stay on the GPU: copies of a renderer's last frame as textures, and what is made of
// two of them.
#pragma once

#include "render/scene_renderer.h"

#include <occlude/backends/gl/detail/gl_object.h>
#include <occlude/core/result.h>

#include <glm/vec2.hpp>

#include <cstdint>

namespace occlude::tools::viewer {

/// One texture, 8-bit RGBA, row 0 at the bottom. All calls with the same context current.
class Canvas {
public:
    /// Copies the renderer's last frame. Its size becomes the canvas's.
    void take(SceneRenderer& renderer, glm::ivec2 size);
    /// Makes room for a picture of this size and binds it for drawing.
    void bind(glm::ivec2 size);

    uint32_t texture() const { return texture_.name(); }
    glm::ivec2 size() const { return size_; }
    bool empty() const { return size_.x == 0; }
    Image read() const;
    /// Copies the picture to the lower left of a framebuffer (0: the window's).
    void copy_to(uint32_t framebuffer, glm::ivec2 size) const;
    /// Copies a rectangle of the picture into one of `target`, larger or smaller if need be.
    /// Cheaper than drawing a textured rectangle, which matters without a graphics card.
    void copy_part(const PixelRect& from, const Canvas& target, const PixelRect& to) const;

private:
    void resize(glm::ivec2 size);

    GlTexture texture_;
    GlFramebuffer framebuffer_;
    glm::ivec2 size_{0};
};

/// Draws one canvas from two of the same size.
class Compositor {
public:
    enum class Mode : int {
        difference = 0,    ///< dim grey where `a` and `b` are equal, a loud colour elsewhere
        shine_through = 1, ///< `a`, with `b` mixed in wherever it is not empty sky
    };
    static Result<Compositor> create();
    void compose(Mode mode, const Canvas& a, const Canvas& b, Canvas& result) const;

private:
    GlProgram program_;
    GlVertexArray nothing_;
};

} // namespace occlude::tools::viewer
