#include <occlude/backends/gl/detail/gl_depth_reader.h>

#include <glm/common.hpp>

#include <array>

namespace occlude::gl {

namespace {

constexpr const char* kVertexShader = R"(#version 330 core
void main()
{
    vec2 corner = vec2((gl_VertexID & 1) * 4 - 1, (gl_VertexID & 2) * 2 - 1);
    gl_Position = vec4(corner, 0.0, 1.0);
}
)";

constexpr const char* kFragmentShader = R"(#version 330 core
uniform sampler2DMS depth;
uniform int mode; // DepthSample
uniform int sample_count;
layout(location = 0) out float reduced;

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float result = texelFetch(depth, pixel, 0).r;
    for (int i = 1; i < sample_count && mode != 2; ++i) {
        float value = texelFetch(depth, pixel, i).r;
        result = mode == 0 ? min(result, value) : max(result, value);
    }
    reduced = result;
}
)";

// What reading changes and the engine set once for the frame: put back when this goes.
class SavedTargets {
public:
    SavedTargets()
    {
        glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &draw_);
        glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &read_);
        glGetIntegerv(GL_VIEWPORT, viewport_.data());
        scissor_ = glIsEnabled(GL_SCISSOR_TEST);
    }
    ~SavedTargets()
    {
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(draw_));
        glBindFramebuffer(GL_READ_FRAMEBUFFER, static_cast<GLuint>(read_));
        glViewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
        if (scissor_) {
            glEnable(GL_SCISSOR_TEST);
        }
    }
    SavedTargets(const SavedTargets&) = delete;
    SavedTargets& operator=(const SavedTargets&) = delete;

    GLuint draw() const { return static_cast<GLuint>(draw_); }

private:
    GLint draw_ = 0;
    GLint read_ = 0;
    std::array<GLint, 4> viewport_{};
    GLboolean scissor_ = GL_FALSE;
};

void reset_pixel_pack()
{
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glPixelStorei(GL_PACK_ROW_LENGTH, 0);
    glPixelStorei(GL_PACK_SKIP_ROWS, 0);
    glPixelStorei(GL_PACK_SKIP_PIXELS, 0);
}

GLint depth_attachment(GLenum what)
{
    GLint value = 0;
    glGetFramebufferAttachmentParameteriv(GL_DRAW_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, what, &value);
    return value;
}

bool has_depth(GLuint framebuffer)
{
    GLint type = GL_NONE;
    glGetFramebufferAttachmentParameteriv(GL_DRAW_FRAMEBUFFER,
                                          framebuffer == 0 ? GL_DEPTH : GL_DEPTH_ATTACHMENT,
                                          GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE, &type);
    return type != GL_NONE;
}

// The internal format of the bound framebuffer's multisampled depth attachment; 0 if unknown.
GLint multisampled_depth_format()
{
    const GLint type = depth_attachment(GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE);
    const auto name = static_cast<GLuint>(depth_attachment(GL_FRAMEBUFFER_ATTACHMENT_OBJECT_NAME));
    GLint format = 0;
    if (type == GL_RENDERBUFFER) {
        glBindRenderbuffer(GL_RENDERBUFFER, name);
        glGetRenderbufferParameteriv(GL_RENDERBUFFER, GL_RENDERBUFFER_INTERNAL_FORMAT, &format);
        glBindRenderbuffer(GL_RENDERBUFFER, 0);
    } else if (type == GL_TEXTURE && depth_attachment(GL_FRAMEBUFFER_ATTACHMENT_LAYERED) == 0) {
        glBindTexture(GL_TEXTURE_2D_MULTISAMPLE, name);
        glGetTexLevelParameteriv(GL_TEXTURE_2D_MULTISAMPLE, 0, GL_TEXTURE_INTERNAL_FORMAT, &format);
    }
    return format;
}

GLenum depth_attachment_point(GLint format)
{
    const bool with_stencil = format == GL_DEPTH24_STENCIL8 || format == GL_DEPTH32F_STENCIL8;
    return with_stencil ? GL_DEPTH_STENCIL_ATTACHMENT : GL_DEPTH_ATTACHMENT;
}

} // namespace

Result<std::unique_ptr<GlDepthReader>> GlDepthReader::create()
{
    Result<GlProgram> program =
        make_program("occlude depth reader", kVertexShader, kFragmentShader);
    if (!program) {
        return program.error();
    }
    return std::unique_ptr<GlDepthReader>(new GlDepthReader(std::move(*program)));
}

GlDepthReader::GlDepthReader(GlProgram program)
    : program_(std::move(program))
    , vertex_array_(GlVertexArray::make())
    , mode_location_(glGetUniformLocation(program_.name(), "mode"))
    , sample_count_location_(glGetUniformLocation(program_.name(), "sample_count"))
{
}

bool GlDepthReader::read(const PixelRect& rect, DepthSample sample, std::span<float> out)
{
    const SavedTargets saved;
    if (rect.width <= 0 || rect.height <= 0 || !has_depth(saved.draw())) {
        return false;
    }
    reset_pixel_pack();
    GLint samples = 0;
    glGetIntegerv(GL_SAMPLES, &samples);
    if (samples > 1) {
        return read_samples(rect, sample, samples, saved.draw(), out);
    }
    glBindFramebuffer(GL_READ_FRAMEBUFFER, saved.draw());
    glReadPixels(rect.x, rect.y, rect.width, rect.height, GL_DEPTH_COMPONENT, GL_FLOAT, out.data());
    return true;
}

// Copies the attachment into a texture, reduces each pixel's samples to one float, and reads those.
bool GlDepthReader::read_samples(const PixelRect& rect, DepthSample sample, int sample_count,
                                 GLuint source, std::span<float> out)
{
    glActiveTexture(GL_TEXTURE0);
    const GLint format = source == 0 ? 0 : multisampled_depth_format();
    if (format == 0 || !prepare_copy(format, sample_count, rect)) {
        return false;
    }
    const int right = rect.x + rect.width;
    const int top = rect.y + rect.height;
    glDisable(GL_SCISSOR_TEST);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, source);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, copy_.name());
    glBlitFramebuffer(rect.x, rect.y, right, top, rect.x, rect.y, right, top, GL_DEPTH_BUFFER_BIT,
                      GL_NEAREST);
    reduce(rect, sample, sample_count);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, reduction_.name());
    glReadPixels(rect.x, rect.y, rect.width, rect.height, GL_RED, GL_FLOAT, out.data());
    return true;
}

// Makes the copy and the reduction at least as large as needed, in the attachment's own format:
// depth can only be copied between equal ones.
bool GlDepthReader::prepare_copy(GLint format, int sample_count, const PixelRect& rect)
{
    const glm::ivec2 needed{rect.x + rect.width, rect.y + rect.height};
    if (format == copy_format_ && sample_count == copy_samples_ && needed.x <= size_.x &&
        needed.y <= size_.y) {
        return true;
    }
    size_ = glm::max(size_, needed);
    copy_format_ = format;
    copy_samples_ = sample_count;

    samples_ = GlTexture::make();
    glBindTexture(GL_TEXTURE_2D_MULTISAMPLE, samples_.name());
    glTexImage2DMultisample(GL_TEXTURE_2D_MULTISAMPLE, sample_count, static_cast<GLenum>(format),
                            size_.x, size_.y, GL_TRUE);
    copy_ = GlFramebuffer::make();
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, copy_.name());
    glFramebufferTexture2D(GL_DRAW_FRAMEBUFFER, depth_attachment_point(format),
                           GL_TEXTURE_2D_MULTISAMPLE, samples_.name(), 0);
    glDrawBuffer(GL_NONE);
    bool complete = glCheckFramebufferStatus(GL_DRAW_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;

    reduced_ = GlRenderbuffer::make();
    glBindRenderbuffer(GL_RENDERBUFFER, reduced_.name());
    glRenderbufferStorage(GL_RENDERBUFFER, GL_R32F, size_.x, size_.y);
    glBindRenderbuffer(GL_RENDERBUFFER, 0);
    reduction_ = GlFramebuffer::make();
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, reduction_.name());
    glFramebufferRenderbuffer(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                              reduced_.name());
    complete = complete && glCheckFramebufferStatus(GL_DRAW_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    if (!complete) {
        copy_format_ = 0;
    }
    return complete;
}

void GlDepthReader::reduce(const PixelRect& rect, DepthSample sample, int sample_count)
{
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, reduction_.name());
    glViewport(rect.x, rect.y, rect.width, rect.height);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_STENCIL_TEST);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glBindTexture(GL_TEXTURE_2D_MULTISAMPLE, samples_.name());
    glUseProgram(program_.name());
    glUniform1i(mode_location_, static_cast<GLint>(sample));
    glUniform1i(sample_count_location_, sample_count);
    glBindVertexArray(vertex_array_.name());
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

} // namespace occlude::gl
