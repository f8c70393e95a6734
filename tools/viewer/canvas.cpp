#include "viewer/canvas.h"

#include "render/gl_renderer.h"
#include "render/palette.h"

namespace occlude::tools::viewer {

namespace {

constexpr const char* kVertex = R"(#version 330 core
void main()
{
    vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
    gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
}
)";

// The sky of both renderers is the colour of pixels that nothing was drawn into.
constexpr const char* kFragment = R"(#version 330 core
uniform sampler2D a;
uniform sampler2D b;
uniform int mode;
uniform vec3 loud;
layout(location = 0) out vec4 color;
const vec3 sky = vec3(0.55, 0.68, 0.82);
void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec3 first = texelFetch(a, at, 0).rgb;
    vec3 second = texelFetch(b, at, 0).rgb;
    if (mode == 0) {
        float grey = dot(first, vec3(0.3, 0.59, 0.11));
        color = vec4(first == second ? vec3(0.35 * grey) : loud, 1.0);
    } else {
        bool empty = all(lessThan(abs(second - sky), vec3(0.004)));
        color = vec4(empty ? first : mix(first, second, 0.625), 1.0);
    }
}
)";

} // namespace

void Canvas::resize(glm::ivec2 size)
{
    if (size == size_) {
        return;
    }
    texture_ = GlTexture::make();
    glBindTexture(GL_TEXTURE_2D, texture_.name());
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, size.x, size.y, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    framebuffer_ = GlFramebuffer::make();
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture_.name(), 0);
    glBindTexture(GL_TEXTURE_2D, 0);
    size_ = size;
}

void Canvas::bind(glm::ivec2 size)
{
    resize(size);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
    glViewport(0, 0, size.x, size.y);
}

void Canvas::take(SceneRenderer& renderer, glm::ivec2 size)
{
    resize(size);
    if (auto* source = dynamic_cast<GlPictureSource*>(&renderer)) {
        source->copy_color_to(framebuffer_.name());
        return;
    }
    const Image image = renderer.capture().color;
    if (image.size == size) {
        glBindTexture(GL_TEXTURE_2D, texture_.name());
        glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
        glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, size.x, size.y, GL_RGBA, GL_UNSIGNED_BYTE,
                        image.pixels.data());
        glBindTexture(GL_TEXTURE_2D, 0);
    }
}

Image Canvas::read() const
{
    Image image{size_,
                std::vector<uint32_t>(static_cast<size_t>(size_.x) * static_cast<size_t>(size_.y))};
    if (!empty()) {
        glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_.name());
        glReadPixels(0, 0, size_.x, size_.y, GL_RGBA, GL_UNSIGNED_BYTE, image.pixels.data());
    }
    return image;
}

void Canvas::copy_to(uint32_t framebuffer, glm::ivec2 size) const
{
    glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_.name());
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
    glDisable(GL_SCISSOR_TEST); // a blit obeys it
    glBlitFramebuffer(0, 0, size_.x, size_.y, 0, 0, size.x, size.y, GL_COLOR_BUFFER_BIT,
                      GL_NEAREST);
}

void Canvas::copy_part(const PixelRect& from, const Canvas& target, const PixelRect& to) const
{
    if (empty() || from.width < 1 || from.height < 1 || to.width < 1 || to.height < 1) {
        return;
    }
    glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_.name());
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.framebuffer_.name());
    glDisable(GL_SCISSOR_TEST); // a blit obeys it
    const bool same_size = from.width == to.width && from.height == to.height;
    glBlitFramebuffer(from.x, from.y, from.x + from.width, from.y + from.height, to.x, to.y,
                      to.x + to.width, to.y + to.height, GL_COLOR_BUFFER_BIT,
                      same_size ? GL_NEAREST : GL_LINEAR);
}

Result<Compositor> Compositor::create()
{
    auto program = make_program("compositor", kVertex, kFragment);
    if (!program) {
        return program.error();
    }
    Compositor made;
    made.program_ = std::move(*program);
    made.nothing_ = GlVertexArray::make();
    glUseProgram(made.program_.name());
    glUniform1i(glGetUniformLocation(made.program_.name(), "a"), 0);
    glUniform1i(glGetUniformLocation(made.program_.name(), "b"), 1);
    glUniform3fv(glGetUniformLocation(made.program_.name(), "loud"), 1, &palette::kOrange.color.x);
    return made;
}

void Compositor::compose(Mode mode, const Canvas& a, const Canvas& b, Canvas& result) const
{
    result.bind(a.size());
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_CULL_FACE);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glUseProgram(program_.name());
    glUniform1i(glGetUniformLocation(program_.name(), "mode"), static_cast<int>(mode));
    glActiveTexture(GL_TEXTURE1);
    glBindTexture(GL_TEXTURE_2D, b.texture());
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, a.texture());
    glBindVertexArray(nothing_.name());
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glBindVertexArray(0);
    glBindTexture(GL_TEXTURE_2D, 0);
}

} // namespace occlude::tools::viewer
