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
    /// Makes the target anew. Fails, and leaves the old one, if the driver does not have the size
    /// or the number of samples (1 is no multisampling).
    Result<bool> resize(glm::ivec2 size, int samples);

    glm::ivec2 size() const { return size_; }

    /// Binds the target for drawing and sets the viewport to all of it.
    void bind() const;

    /// Binds a target of the same size, without multisampling, for one 32-bit id per pixel; made at
    /// the first use.
    void bind_ids();

    /// The pixels of the last bind_ids().
    std::vector<uint32_t> read_ids() const;

    /// Resolved colour and depth. Changes the state that GlDepthReader::read names.
    Capture capture(gl::GlDepthReader& reader) const;

private:
    struct Attachments {
        gl::GlFramebuffer framebuffer;
        gl::GlRenderbuffer color;
        gl::GlRenderbuffer depth;
    };
    static bool make_attachments(Attachments& made, GLenum color_format, glm::ivec2 size,
                                 int samples);

    glm::ivec2 size_{0};
    int samples_ = 1;
    Attachments main_;
    Attachments resolved_; ///< multisampled targets only
    Attachments ids_;      ///< made when needed
};

} // namespace occlude::tools
