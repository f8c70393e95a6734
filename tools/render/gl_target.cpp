#include "render/gl_target.h"

#include <string>

namespace occlude::tools {

bool GlTarget::make_attachments(Attachments& made, GLenum color_format, glm::ivec2 size,
                                int samples)
{
    const auto allocate = [&](gl::GlRenderbuffer& buffer, GLenum format) {
        buffer = gl::GlRenderbuffer::make();
        glBindRenderbuffer(GL_RENDERBUFFER, buffer.name());
        glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples > 1 ? samples : 0, format, size.x,
                                         size.y);
    };
    allocate(made.color, color_format);
    // Float depth: reading it back is six times cheaper than 24-bit depth with llvmpipe.
    allocate(made.depth, GL_DEPTH_COMPONENT32F);
    glBindRenderbuffer(GL_RENDERBUFFER, 0);
    made.framebuffer = gl::GlFramebuffer::make();
    glBindFramebuffer(GL_FRAMEBUFFER, made.framebuffer.name());
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                              made.color.name());
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER,
                              made.depth.name());
    return glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
}

Result<bool> GlTarget::resize(glm::ivec2 size, int samples)
{
    GLint largest = 0;
    GLint most_samples = 0;
    glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &largest);
    glGetIntegerv(GL_MAX_SAMPLES, &most_samples);
    if (size.x < 1 || size.y < 1 || size.x > largest || size.y > largest) {
        return Error{ErrorCode::invalid_argument, "a target of " + std::to_string(size.x) + "x" +
                                                      std::to_string(size.y) +
                                                      " pixels is not possible; choose 1 to " +
                                                      std::to_string(largest) + " on each side"};
    }
    if (samples < 1 || samples > most_samples) {
        return Error{ErrorCode::invalid_argument,
                     "this driver cannot do " + std::to_string(samples) +
                         " samples per pixel; choose 1 to " + std::to_string(most_samples)};
    }
    Attachments main;
    Attachments resolved;
    if (!make_attachments(main, GL_RGBA8, size, samples) ||
        (samples > 1 && !make_attachments(resolved, GL_RGBA8, size, 1))) {
        return Error{ErrorCode::device_failed, "the OpenGL driver refused a target of " +
                                                   std::to_string(size.x) + "x" +
                                                   std::to_string(size.y) + " pixels, " +
                                                   std::to_string(samples) + " samples"};
    }
    main_ = std::move(main);
    resolved_ = std::move(resolved);
    ids_ = {};
    size_ = size;
    samples_ = samples;
    return true;
}

void GlTarget::bind() const
{
    glBindFramebuffer(GL_FRAMEBUFFER, main_.framebuffer.name());
    glViewport(0, 0, size_.x, size_.y);
}

void GlTarget::bind_ids()
{
    if (ids_.framebuffer.name() == 0) {
        make_attachments(ids_, GL_R32UI, size_, 1);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, ids_.framebuffer.name());
    glViewport(0, 0, size_.x, size_.y);
}

std::vector<uint32_t> GlTarget::read_ids() const
{
    std::vector<uint32_t> ids(static_cast<size_t>(size_.x) * static_cast<size_t>(size_.y));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, ids_.framebuffer.name());
    glReadPixels(0, 0, size_.x, size_.y, GL_RED_INTEGER, GL_UNSIGNED_INT, ids.data());
    return ids;
}

Capture GlTarget::capture(gl::GlDepthReader& reader) const
{
    Capture capture;
    capture.color.size = size_;
    const size_t pixel_count = static_cast<size_t>(size_.x) * static_cast<size_t>(size_.y);
    capture.color.pixels.resize(pixel_count);
    capture.depth.resize(pixel_count);

    bind();
    reader.read({0, 0, size_.x, size_.y}, gl::DepthSample::first, capture.depth);
    if (samples_ > 1) {
        glBindFramebuffer(GL_READ_FRAMEBUFFER, main_.framebuffer.name());
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved_.framebuffer.name());
        glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
        glBlitFramebuffer(0, 0, size_.x, size_.y, 0, 0, size_.x, size_.y, GL_COLOR_BUFFER_BIT,
                          GL_NEAREST);
        glBindFramebuffer(GL_READ_FRAMEBUFFER, resolved_.framebuffer.name());
    }
    glReadPixels(0, 0, size_.x, size_.y, GL_RGBA, GL_UNSIGNED_BYTE, capture.color.pixels.data());
    bind();
    return capture;
}

} // namespace occlude::tools
