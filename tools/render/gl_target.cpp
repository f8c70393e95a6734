#include "render/gl_target.h"

#include <algorithm>
#include <string>

namespace occlude::tools {

static const char* const kWholeTargetVertex = R"(#version 330 core
void main()
{
    vec2 corner = vec2((gl_VertexID & 1) * 4 - 1, (gl_VertexID & 2) * 2 - 1);
    gl_Position = vec4(corner, 0.0, 1.0);
}
)";

static const char* const kSampleFragment = R"(#version 330 core
uniform sampler2DMS samples;
uniform int which;
layout(location = 0) out vec4 color;
void main() { color = texelFetch(samples, ivec2(gl_FragCoord.xy), which); }
)";

bool GlTarget::make_attachments(Attachments& made, GLenum color_format, glm::ivec2 size,
                                int samples)
{
    const auto allocate = [&](GlRenderbuffer& buffer, GLenum format) {
        buffer = GlRenderbuffer::make();
        glBindRenderbuffer(GL_RENDERBUFFER, buffer.name());
        glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples > 1 ? samples : 0, format, size.x,
                                         size.y);
    };
    allocate(made.color, color_format);
    // Float depth, because reading it back is six times cheaper than 24-bit depth with llvmpipe.
    allocate(made.depth, GL_DEPTH_COMPONENT32F);
    glBindRenderbuffer(GL_RENDERBUFFER, 0);
    made.framebuffer = GlFramebuffer::make();
    glBindFramebuffer(GL_FRAMEBUFFER, made.framebuffer.name());
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                              made.color.name());
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER,
                              made.depth.name());
    return glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
}

// Drivers may give more samples than requested: llvmpipe gives four for two.
static int given_samples(GLuint framebuffer)
{
    GLint samples = 0;
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glGetIntegerv(GL_SAMPLES, &samples);
    return std::max(samples, 1);
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
    samples_ = given_samples(main_.framebuffer.name());
    return true;
}

void GlTarget::bind() const
{
    glBindFramebuffer(GL_FRAMEBUFFER, main_.framebuffer.name());
    glViewport(0, 0, size_.x, size_.y);
}

bool GlTarget::bind_ids()
{
    if (ids_.framebuffer.name() == 0 && (!make_attachments(ids_, GL_RGBA8, size_, samples_) ||
                                         (samples_ > 1 && !make_sample_reader()))) {
        ids_ = {};
        return false;
    }
    glBindFramebuffer(GL_FRAMEBUFFER, ids_.framebuffer.name());
    glViewport(0, 0, size_.x, size_.y);
    return true;
}

bool GlTarget::make_sample_reader()
{
    auto program = make_program("samples", kWholeTargetVertex, kSampleFragment);
    if (!program) {
        return false;
    }
    sample_program_ = std::move(*program);
    sample_vertices_ = GlVertexArray::make();
    id_samples_ = GlTexture::make();
    glBindTexture(GL_TEXTURE_2D_MULTISAMPLE, id_samples_.name());
    glTexImage2DMultisample(GL_TEXTURE_2D_MULTISAMPLE, samples_, GL_RGBA8, size_.x, size_.y,
                            GL_TRUE);
    id_copy_ = GlFramebuffer::make();
    glBindFramebuffer(GL_FRAMEBUFFER, id_copy_.name());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D_MULTISAMPLE,
                           id_samples_.name(), 0);
    return glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
}

// Copies one sample of every pixel from id_samples_ to resolved_.
void GlTarget::draw_sample(int sample) const
{
    glBindFramebuffer(GL_FRAMEBUFFER, resolved_.framebuffer.name());
    glViewport(0, 0, size_.x, size_.y);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D_MULTISAMPLE, id_samples_.name());
    glUseProgram(sample_program_.name());
    glUniform1i(glGetUniformLocation(sample_program_.name(), "which"), sample);
    glBindVertexArray(sample_vertices_.name());
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

std::vector<uint32_t> GlTarget::read_ids() const
{
    const size_t pixel_count = static_cast<size_t>(size_.x) * static_cast<size_t>(size_.y);
    std::vector<uint32_t> ids(pixel_count * static_cast<size_t>(samples_));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, ids_.framebuffer.name());
    if (samples_ > 1) {
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, id_copy_.name());
        glBlitFramebuffer(0, 0, size_.x, size_.y, 0, 0, size_.x, size_.y, GL_COLOR_BUFFER_BIT,
                          GL_NEAREST);
    }
    for (int sample = 0; sample < samples_; ++sample) {
        if (samples_ > 1) {
            draw_sample(sample);
        }
        uint32_t* const first = ids.data() + static_cast<size_t>(sample) * pixel_count;
        glReadPixels(0, 0, size_.x, size_.y, GL_RGBA, GL_UNSIGNED_BYTE, first);
    }
    return ids;
}

Capture GlTarget::capture(GlDepthReader& reader) const
{
    Capture capture;
    capture.color.size = size_;
    const size_t pixel_count = static_cast<size_t>(size_.x) * static_cast<size_t>(size_.y);
    capture.color.pixels.resize(pixel_count);
    capture.depth.resize(pixel_count);

    bind();
    reader.read({0, 0, size_.x, size_.y}, DepthSample::first, capture.depth);
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

void GlTarget::copy_color_to(GLuint framebuffer) const
{
    glBindFramebuffer(GL_READ_FRAMEBUFFER, main_.framebuffer.name());
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
    glDisable(GL_SCISSOR_TEST); // a blit obeys the scissor test
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glBlitFramebuffer(0, 0, size_.x, size_.y, 0, 0, size_.x, size_.y, GL_COLOR_BUFFER_BIT,
                      GL_NEAREST);
    bind();
}

} // namespace occlude::tools
