// The renderer's off-screen target: colour and float depth, multisampled or not.
#pragma once

#include "render/scene_renderer.h"

#include <occlude/backends/gl/detail/gl_depth_reader.h>
#include <occlude/backends/gl/detail/gl_object.h>
#include <occlude/core/result.h>

#include <glm/vec2.hpp>

namespace occlude::tools {

class GlTarget {
public:
    /// Makes a new target. Fails and keeps the old one if the driver does not support the size or
    /// the number of samples (1: no multisampling).
    Result<bool> resize(glm::ivec2 size, int samples);

    glm::ivec2 size() const { return size_; }

    /// Binds the target for drawing and sets the viewport to all of it.
    void bind() const;

    /// Binds a target of the same size and number of samples for one 32-bit id per sample, as four
    /// bytes of colour; made at the first use. False if the driver refuses it.
    bool bind_ids();

    /// The ids drawn since the last bind_ids(): of the first sample of every pixel, then of the
    /// second, and so on. Leaves depth test, blending and face culling off, and the program, vertex
    /// array and texture bindings undefined.
    std::vector<uint32_t> read_ids() const;

    /// Resolved colour and depth. Changes the state that GlDepthReader::read documents.
    Capture capture(GlDepthReader& reader) const;

    /// Copies the resolved colours to a framebuffer of the same size and leaves the target bound.
    void copy_color_to(GLuint framebuffer) const;

private:
    struct Attachments {
        GlFramebuffer framebuffer;
        GlRenderbuffer color;
        GlRenderbuffer depth;
    };
    static bool make_attachments(Attachments& made, GLenum color_format, glm::ivec2 size,
                                 int samples);
    bool make_sample_reader();
    void draw_sample(int sample) const;

    glm::ivec2 size_{0};
    int samples_ = 1;
    Attachments main_;
    Attachments resolved_; ///< multisampled targets only
    Attachments ids_;      ///< made when needed

    // Reads the samples of ids_ one by one: a texture of the same samples, and a program that draws
    // one.
    GlTexture id_samples_;
    GlFramebuffer id_copy_;
    GlProgram sample_program_;
    GlVertexArray sample_vertices_;
};

} // namespace occlude::tools
