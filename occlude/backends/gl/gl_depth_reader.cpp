#include <occlude/backends/gl/detail/gl_depth_reader.h>

#include <occlude/backends/gl/detail/gl_saved_state.h>
#include <occlude/core/tiles.h>

#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace occlude {

namespace {

constexpr int kLargestStep = 8; // a fragment looks at up to 8x8 texels

constexpr const char* kVersion = "#version 330 core\n";

constexpr const char* kVertexShader = R"(
void main()
{
    vec2 corner = vec2((gl_VertexID & 1) * 4 - 1, (gl_VertexID & 2) * 2 - 1);
    gl_Position = vec4(corner, 0.0, 1.0);
}
)";

constexpr const char* kFragmentShader = R"(
#ifdef SAMPLES
uniform sampler2DMS depth;
#else
uniform sampler2D depth;
#endif
uniform int mode;         // DepthSample
uniform int sample_count;
uniform int side;         // of the block of texels that becomes one
uniform ivec2 origin;     // the first of the texels that count
uniform ivec2 extent;     // how many there are
uniform bool from_above;  // blocks are counted from the last row down
layout(location = 0) out float reduced;

float reduce(float a, float b)
{
    return mode == 0 ? min(a, b) : max(a, b);
}

float texel(ivec2 at)
{
    at.y = from_above ? extent.y - 1 - at.y : at.y;
    float result = texelFetch(depth, origin + at, 0).r;
#ifdef SAMPLES
    for (int i = 1; i < sample_count && mode != 2; ++i) {
        result = reduce(result, texelFetch(depth, origin + at, i).r);
    }
#endif
    return result;
}

void main()
{
    ivec2 first = ivec2(gl_FragCoord.xy) * side;
    ivec2 end = min(first + side, extent);
    float result = texel(first);
    for (int y = first.y; y < end.y; ++y) {
        for (int x = first.x; x < end.x; ++x) {
            result = reduce(result, texel(ivec2(x, y)));
        }
    }
    reduced = mode == 2 ? texel(first) : result;
}
)";

GLint depth_attachment(GLuint framebuffer, GLenum what)
{
    GLint value = 0;
    glGetFramebufferAttachmentParameteriv(
        GL_DRAW_FRAMEBUFFER, framebuffer == 0 ? GL_DEPTH : GL_DEPTH_ATTACHMENT, what, &value);
    return value;
}

// False if there is no depth to read, or if the attachment is layered.
bool has_readable_depth(GLuint framebuffer)
{
    const GLint type = depth_attachment(framebuffer, GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE);
    const bool texture = framebuffer != 0 && type == GL_TEXTURE;
    return type != GL_NONE &&
           !(texture && depth_attachment(framebuffer, GL_FRAMEBUFFER_ATTACHMENT_LAYERED) != 0);
}

// A format with as many bits as the bound framebuffer's depth; 0 if there is none.
GLenum depth_format(GLuint framebuffer)
{
    const GLint bits = depth_attachment(framebuffer, GL_FRAMEBUFFER_ATTACHMENT_DEPTH_SIZE);
    const bool stencil = depth_attachment(framebuffer, GL_FRAMEBUFFER_ATTACHMENT_STENCIL_SIZE) > 0;
    const bool real =
        depth_attachment(framebuffer, GL_FRAMEBUFFER_ATTACHMENT_COMPONENT_TYPE) == GL_FLOAT;
    if (real && bits == 32) {
        return stencil ? GL_DEPTH32F_STENCIL8 : GL_DEPTH_COMPONENT32F;
    }
    switch (bits) {
    case 16:
        return stencil ? 0 : GL_DEPTH_COMPONENT16;
    case 24:
        return stencil ? GL_DEPTH24_STENCIL8 : GL_DEPTH_COMPONENT24;
    case 32:
        return stencil ? 0 : GL_DEPTH_COMPONENT32;
    default:
        return 0;
    }
}

GLenum attachment_point(GLenum format)
{
    const bool with_stencil = format == GL_DEPTH24_STENCIL8 || format == GL_DEPTH32F_STENCIL8;
    return with_stencil ? GL_DEPTH_STENCIL_ATTACHMENT : GL_DEPTH_ATTACHMENT;
}

} // namespace

// One reduction of blocks of texels to single texels.
struct GlDepthReader::Pass {
    GLenum target = GL_TEXTURE_2D;
    GLuint source = 0;
    glm::ivec2 origin{0};
    glm::ivec2 extent{0};
    int side = 1;
    int sample_count = 1;
    bool from_above = false;
};

Result<std::unique_ptr<GlDepthReader>> GlDepthReader::create()
{
    const auto make = [](const char* name, const std::string& version) {
        return make_program(name, version + kVertexShader, version + kFragmentShader);
    };
    Result<GlProgram> pixels = make("occlude depth of pixels", kVersion);
    if (!pixels) {
        return pixels.error();
    }
    Result<GlProgram> samples =
        make("occlude depth of samples", std::string(kVersion) + "#define SAMPLES\n");
    if (!samples) {
        return samples.error();
    }
    return std::unique_ptr<GlDepthReader>(
        new GlDepthReader(std::move(*pixels), std::move(*samples)));
}

GlDepthReader::Reduction::Reduction(GlProgram made)
    : program(std::move(made))
    , origin(glGetUniformLocation(program.name(), "origin"))
    , extent(glGetUniformLocation(program.name(), "extent"))
    , side(glGetUniformLocation(program.name(), "side"))
    , mode(glGetUniformLocation(program.name(), "mode"))
    , sample_count(glGetUniformLocation(program.name(), "sample_count"))
    , from_above(glGetUniformLocation(program.name(), "from_above"))
{
}

GlDepthReader::GlDepthReader(GlProgram pixels, GlProgram samples)
    : pixels_(std::move(pixels))
    , samples_(std::move(samples))
    , vertex_array_(GlVertexArray::make())
    , sampler_(GlSampler::make())
{
    for (const GLenum filter : {GLenum{GL_TEXTURE_MIN_FILTER}, GLenum{GL_TEXTURE_MAG_FILTER}}) {
        glSamplerParameteri(sampler_.name(), filter, GL_NEAREST);
    }
}

bool GlDepthReader::read(const PixelRect& rect, DepthSample sample, std::span<float> out)
{
    const GlSavedState saved;
    if (rect.width <= 0 || rect.height <= 0 || !has_readable_depth(saved.draw_framebuffer())) {
        return false;
    }
    GLint samples = 0;
    glGetIntegerv(GL_SAMPLES, &samples);
    if (samples <= 1) {
        return read_floats(saved.draw_framebuffer(), rect, GL_DEPTH_COMPONENT, out);
    }
    const glm::ivec2 size{rect.width, rect.height};
    if (!reduced_[0].prepare(size) || !copy(rect, samples, sample, saved.draw_framebuffer())) {
        return false;
    }
    reduce(samples_,
           {GL_TEXTURE_2D_MULTISAMPLE, copy_.name(), {rect.x, rect.y}, size, 1, samples, false},
           sample, reduced_[0]);
    return read_floats(reduced_[0].framebuffer.name(), {0, 0, rect.width, rect.height}, GL_RED,
                       out);
}

static bool is_float(GLenum depth_format)
{
    return depth_format == GL_DEPTH_COMPONENT32F || depth_format == GL_DEPTH32F_STENCIL8;
}

// Shaders and glReadPixels convert the integers of a depth buffer to floats with different
// rounding, but no tile may be nearer than what is read of its pixels.
static void round_toward_far(DepthSample sample, std::span<float> depths)
{
    constexpr float kRounding = 0x1p-23f;
    const float toward_far = sample == DepthSample::smallest ? -kRounding : kRounding;
    for (float& depth : depths) {
        depth = std::clamp(depth + toward_far, 0.0f, 1.0f);
    }
}

bool GlDepthReader::read_tiles(const PixelRect& rect, int tile_px, bool from_above,
                               DepthSample sample, std::span<float> out)
{
    const GlSavedState saved;
    if (rect.width <= 0 || rect.height <= 0 || !has_readable_depth(saved.draw_framebuffer())) {
        return false;
    }
    GLint samples = 0;
    glGetIntegerv(GL_SAMPLES, &samples);
    const bool multisampled = samples > 1;
    const bool exact = is_float(depth_format(saved.draw_framebuffer()));
    const int step = std::min(tile_px, kLargestStep);
    const glm::ivec2 size{rect.width, rect.height};
    const glm::ivec2 blocks = tiles_in(size, step);
    if (!reduced_[0].prepare(blocks) ||
        !copy(rect, multisampled ? samples : 0, sample, saved.draw_framebuffer())) {
        return false;
    }
    reduce(multisampled ? samples_ : pixels_,
           {multisampled ? GLenum{GL_TEXTURE_2D_MULTISAMPLE} : GLenum{GL_TEXTURE_2D},
            copy_.name(),
            {rect.x, rect.y},
            size,
            step,
            samples,
            from_above},
           sample, reduced_[0]);
    FloatTarget* last = &reduced_[0];
    if (tile_px > step) {
        if (!reduced_[1].prepare(tiles_in(size, tile_px))) {
            return false;
        }
        last = &reduced_[1];
        reduce(
            pixels_,
            {GL_TEXTURE_2D, reduced_[0].texture.name(), {0, 0}, blocks, tile_px / step, 1, false},
            sample, *last);
    }
    const glm::ivec2 tiles = tiles_in(size, tile_px);
    if (!read_floats(last->framebuffer.name(), {0, 0, tiles.x, tiles.y}, GL_RED, out)) {
        return false;
    }
    if (!exact) {
        round_toward_far(sample, out);
    }
    return true;
}

// Copies `rect` of the framebuffer's depth to the same place in copy_. The caller restores the
// state that this changes.
bool GlDepthReader::copy(const PixelRect& rect, int sample_count, DepthSample sample, GLuint source)
{
    const GLenum format = depth_format(source);
    if (format == 0 || !prepare_copy(format, sample_count, rect)) {
        return false;
    }
    const int right = rect.x + rect.width;
    const int top = rect.y + rect.height;
    glDisable(GL_SCISSOR_TEST);
    glDepthMask(GL_TRUE);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, source);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, copy_framebuffer_.name());
    const GLfloat far_value = sample == DepthSample::smallest ? 0.0f : 1.0f;
    glClearBufferfv(GL_DEPTH, 0, &far_value);
    glBlitFramebuffer(rect.x, rect.y, right, top, rect.x, rect.y, right, top, GL_DEPTH_BUFFER_BIT,
                      GL_NEAREST);
    return true;
}

// Makes the copy large enough, in the attachment's own format, because depth can only be copied
// between equal formats.
bool GlDepthReader::prepare_copy(GLenum format, int sample_count, const PixelRect& rect)
{
    const glm::ivec2 needed{rect.x + rect.width, rect.y + rect.height};
    if (format == copy_format_ && sample_count == copy_samples_ && needed.x <= copy_size_.x &&
        needed.y <= copy_size_.y) {
        return true;
    }
    const bool multisampled = sample_count > 1;
    const GLenum target = multisampled ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D;
    const glm::ivec2 size = glm::max(copy_size_, needed);
    const bool stencil = attachment_point(format) == GL_DEPTH_STENCIL_ATTACHMENT;
    const bool real = format == GL_DEPTH32F_STENCIL8;
    copy_ = GlTexture::make();
    glBindTexture(target, copy_.name());
    if (multisampled) {
        glTexImage2DMultisample(target, sample_count, format, size.x, size.y, GL_TRUE);
    } else {
        glTexImage2D(target, 0, static_cast<GLint>(format), size.x, size.y, 0,
                     stencil ? GL_DEPTH_STENCIL : GL_DEPTH_COMPONENT,
                     real      ? GL_FLOAT_32_UNSIGNED_INT_24_8_REV
                     : stencil ? GL_UNSIGNED_INT_24_8
                               : GL_FLOAT,
                     nullptr);
        glTexParameteri(target, GL_TEXTURE_MAX_LEVEL, 0);
    }
    copy_framebuffer_ = GlFramebuffer::make();
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, copy_framebuffer_.name());
    glFramebufferTexture2D(GL_DRAW_FRAMEBUFFER, attachment_point(format), target, copy_.name(), 0);
    glDrawBuffer(GL_NONE);
    const bool complete = glCheckFramebufferStatus(GL_DRAW_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    copy_format_ = complete ? format : 0;
    copy_samples_ = sample_count;
    copy_size_ = size;
    return complete;
}

bool GlDepthReader::FloatTarget::prepare(glm::ivec2 needed)
{
    if (needed.x <= size.x && needed.y <= size.y) {
        return true;
    }
    const glm::ivec2 larger = glm::max(size, needed);
    texture = GlTexture::make();
    glBindTexture(GL_TEXTURE_2D, texture.name());
    glTexImage2D(GL_TEXTURE_2D, 0, GL_R32F, larger.x, larger.y, 0, GL_RED, GL_FLOAT, nullptr);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    GLint draw_framebuffer = 0;
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &draw_framebuffer);
    framebuffer = GlFramebuffer::make();
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer.name());
    glFramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture.name(),
                           0);
    const bool complete = glCheckFramebufferStatus(GL_DRAW_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(draw_framebuffer));
    size = complete ? larger : glm::ivec2{0};
    return complete;
}

void GlDepthReader::reduce(const Reduction& reduction, const Pass& pass, DepthSample sample,
                           FloatTarget& into)
{
    const glm::ivec2 size = tiles_in(pass.extent, pass.side);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, into.framebuffer.name());
    glViewport(0, 0, size.x, size.y);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_STENCIL_TEST);
    glDisablei(GL_BLEND, 0);
    glDisable(GL_CULL_FACE);
    glColorMaski(0, GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glBindTexture(pass.target, pass.source);
    glBindSampler(0, sampler_.name());
    glUseProgram(reduction.program.name());
    glUniform1i(reduction.mode, static_cast<GLint>(sample));
    glUniform1i(reduction.sample_count, pass.sample_count);
    glUniform1i(reduction.side, pass.side);
    glUniform2i(reduction.origin, pass.origin.x, pass.origin.y);
    glUniform2i(reduction.extent, pass.extent.x, pass.extent.y);
    glUniform1i(reduction.from_above, pass.from_above ? 1 : 0);
    glBindVertexArray(vertex_array_.name());
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

// Reads, and detects by a mark on the first and the last value whether the driver has written.
bool GlDepthReader::read_floats(GLuint framebuffer, const PixelRect& rect, GLenum format,
                                std::span<float> out) const
{
    const float first = out.front();
    const float last = out.back();
    out.front() = out.back() = std::numeric_limits<float>::quiet_NaN();
    glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
    glReadPixels(rect.x, rect.y, rect.width, rect.height, format, GL_FLOAT, out.data());
    if (!std::isnan(out.front()) && !std::isnan(out.back())) {
        return true;
    }
    out.front() = first;
    out.back() = last;
    return false;
}

} // namespace occlude
