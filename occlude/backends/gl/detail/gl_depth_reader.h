// Reads the depth of the bound framebuffer, with or without multisampling.
#pragma once

#include <occlude/backends/gl/detail/gl_object.h>
#include <occlude/core/query_device.h>

#include <glm/vec2.hpp>

#include <cstdint>
#include <memory>
#include <span>

namespace occlude::gl {

/// Which sample of a multisampled pixel is read.
enum class DepthSample : uint8_t { smallest, largest, first };

class GlDepthReader {
public:
    static Result<std::unique_ptr<GlDepthReader>> create();

    /// Reads raw window depth of `rect` of the framebuffer bound to GL_DRAW_FRAMEBUFFER, row by row
    /// from the bottom. Blocks. False, and `out` is untouched, if there is no depth attachment or
    /// it is a multisampled one whose samples OpenGL does not let one see: that of a window, a
    /// layered one. Changes the program, the vertex array, texture unit 0's multisample texture,
    /// the active texture unit, the pixel pack buffer, row length, skips and alignment, colour
    /// mask, depth test, blending, stencil test and culling; all other state is put back.
    bool read(const PixelRect& rect, DepthSample sample, std::span<float> out);

private:
    explicit GlDepthReader(GlProgram program);
    bool read_samples(const PixelRect& rect, DepthSample sample, int sample_count, GLuint source,
                      std::span<float> out);
    bool prepare_copy(GLint format, int sample_count, const PixelRect& rect);
    void reduce(const PixelRect& rect, DepthSample sample, int sample_count);

    GlProgram program_;
    GlVertexArray vertex_array_;
    GlTexture samples_;       ///< multisampled copy of the depth attachment
    GlFramebuffer copy_;      ///< ... and its framebuffer
    GlRenderbuffer reduced_;  ///< one float per pixel
    GlFramebuffer reduction_; ///< ... and its framebuffer
    GLint mode_location_ = -1;
    GLint sample_count_location_ = -1;
    GLint copy_format_ = 0;
    int copy_samples_ = 0;
    glm::ivec2 size_{0};
};

} // namespace occlude::gl
