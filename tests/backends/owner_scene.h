// Boxes on either device, with the owner of every sample, for tests of all algorithms.
#pragma once

#include "backends/gl_fixture.h"
#include "support/box_scene.h"
#include "support/camera_worlds.h"

#include <occlude/backends/cpu/cpu_device.h>

#include <set>

namespace occlude {

/// An OpenGL engine that draws boxes in the colour of their id, relative to the camera or in world
/// coordinates, with vertices on the grid of 1/256 pixel (docs/conventions.md says why).
class IdScene final : public GlScene {
public:
    IdScene(glm::ivec2 size, int samples, std::span<const ItemBounds> items, test::Drawing drawing)
        : size_(size)
        , samples_(samples)
        , drawing_(drawing)
    {
        auto program = make_program("ids", R"(#version 330 core
layout(location = 0) in vec3 p;
uniform mat4 clip_from_start;
uniform vec3 start;       // rounded to float ...
uniform vec3 start_below; // ... and the rest
uniform vec2 snaps;
invariant gl_Position;
void main()
{
    gl_Position = clip_from_start * vec4((p - start) - start_below, 1.0);
    if (gl_Position.w > 0.0) {
        gl_Position.xy = round(gl_Position.xy / gl_Position.w * snaps) * (gl_Position.w / snaps);
    }
})",
                                    R"(#version 330 core
uniform vec4 color;
layout(location = 0) out vec4 result;
void main() { result = color; })");
        EXPECT_TRUE(program) << (program ? "" : program.error().message);
        program_ = std::move(*program);
        framebuffer_ = GlFramebuffer::make();
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
        color_ = attach(GL_RGBA8, GL_COLOR_ATTACHMENT0);
        depth_ = attach(GL_DEPTH_COMPONENT32F, GL_DEPTH_ATTACHMENT);
        EXPECT_EQ(glCheckFramebufferStatus(GL_FRAMEBUFFER),
                  static_cast<GLenum>(GL_FRAMEBUFFER_COMPLETE));
        std::vector<glm::vec3> points;
        for (const ItemBounds& item : items) {
            for (int i = 0; i < 8; ++i) {
                points.push_back(test::corner(item.box, i));
            }
        }
        constexpr std::array<uint16_t, 36> kIndices{0, 1, 3, 0, 3, 2, 4, 5, 7, 4, 7, 6,
                                                    0, 1, 5, 0, 5, 4, 2, 3, 7, 2, 7, 6,
                                                    0, 2, 6, 0, 6, 4, 1, 3, 7, 1, 7, 5};
        vertices_ = GlBuffer::make();
        indices_ = GlBuffer::make();
        vertex_array_ = GlVertexArray::make();
        glBindVertexArray(vertex_array_.name());
        glBindBuffer(GL_ARRAY_BUFFER, vertices_.name());
        glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(points.size() * sizeof(glm::vec3)),
                     points.data(), GL_STATIC_DRAW);
        glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.name());
        glBufferData(GL_ELEMENT_ARRAY_BUFFER, sizeof(kIndices), kIndices.data(), GL_STATIC_DRAW);
        glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(glm::vec3), nullptr);
        glEnableVertexAttribArray(0);
        glBindVertexArray(0);
    }

    void begin_frame(const View& view) override
    {
        view_ = view;
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
        glViewport(0, 0, size_.x, size_.y);
        restore_state();
        const bool reversed = view.convention().order == DepthOrder::near_is_large;
        const bool zero_to_one = view.convention().range == DepthRange::zero_to_one;
        glClipControl(GL_LOWER_LEFT, zero_to_one ? GL_ZERO_TO_ONE : GL_NEGATIVE_ONE_TO_ONE);
        glClearDepth(reversed ? 0.0 : 1.0);
        glClearColor(0.0f, 0.0f, 0.0f, 0.0f);
        glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    }

    void draw(std::span<const ItemId> items, DrawPass) override
    {
        for (const ItemId item : items) {
            const uint32_t id = item.value + 1;
            glUniform4f(glGetUniformLocation(program_.name(), "color"),
                        static_cast<float>(id & 255) / 255.0f,
                        static_cast<float>(id >> 8 & 255) / 255.0f, 0.0f, 1.0f);
            glDrawElementsBaseVertex(GL_TRIANGLES, 36, GL_UNSIGNED_SHORT, nullptr,
                                     static_cast<GLint>(8 * item.value));
        }
    }

    void restore_state() override
    {
        const bool relative = drawing_ == test::Drawing::relative;
        const glm::mat4 clip =
            relative ? glm::mat4{view_.clip_from_relative()} : view_.clip_from_world();
        const glm::dvec3 origin = relative ? view_.origin() : glm::dvec3{0.0};
        const glm::vec3 start{origin};
        const glm::vec3 start_below{origin - glm::dvec3{start}};
        const glm::vec2 snaps = 128.0f * glm::vec2{size_};
        glUseProgram(program_.name());
        glUniformMatrix4fv(glGetUniformLocation(program_.name(), "clip_from_start"), 1, GL_FALSE,
                           glm::value_ptr(clip));
        glUniform3fv(glGetUniformLocation(program_.name(), "start"), 1, &start.x);
        glUniform3fv(glGetUniformLocation(program_.name(), "start_below"), 1, &start_below.x);
        glUniform2fv(glGetUniformLocation(program_.name(), "snaps"), 1, &snaps.x);
        glBindVertexArray(vertex_array_.name());
        glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
        glDepthMask(GL_TRUE);
        glEnable(GL_DEPTH_TEST);
        glDepthFunc(view_.convention().order == DepthOrder::near_is_large ? GL_GREATER : GL_LESS);
        if (view_.ignores_near_plane()) {
            glEnable(GL_DEPTH_CLAMP);
        } else {
            glDisable(GL_DEPTH_CLAMP);
        }
        glDisable(GL_CULL_FACE);
    }

    /// The items that own a sample. One sample per pixel only.
    std::set<uint32_t> owners() const
    {
        EXPECT_EQ(samples_, 1);
        std::vector<uint32_t> pixels(static_cast<size_t>(size_.x * size_.y));
        glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_.name());
        glReadPixels(0, 0, size_.x, size_.y, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
        std::set<uint32_t> found;
        for (const uint32_t pixel : pixels) {
            if ((pixel & 0xffffu) != 0) {
                found.insert((pixel & 0xffffu) - 1);
            }
        }
        return found;
    }

private:
    GlRenderbuffer attach(GLenum format, GLenum point) const
    {
        GlRenderbuffer buffer = GlRenderbuffer::make();
        glBindRenderbuffer(GL_RENDERBUFFER, buffer.name());
        glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples_ > 1 ? samples_ : 0, format,
                                         size_.x, size_.y);
        glFramebufferRenderbuffer(GL_FRAMEBUFFER, point, GL_RENDERBUFFER, buffer.name());
        return buffer;
    }

    glm::ivec2 size_;
    int samples_ = 1;
    test::Drawing drawing_;
    View view_;
    GlProgram program_;
    GlFramebuffer framebuffer_;
    GlRenderbuffer color_;
    GlRenderbuffer depth_;
    GlBuffer vertices_;
    GlBuffer indices_;
    GlVertexArray vertex_array_;
};

} // namespace occlude
