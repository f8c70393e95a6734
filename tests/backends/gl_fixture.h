// A headless context and a tiny engine for tests of the GL backend: axis-aligned quads and boxes.
#pragma once

#include <occlude/backends/gl/detail/gl_object.h>
#include <occlude/backends/gl/gl_device.h>
#include <occlude/backends/gl/headless_context.h>
#include <occlude/core/query_device.h>

#include <gtest/gtest.h>

#include <glm/gtc/type_ptr.hpp>

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace occlude {

/// The engine: item i draws a run of triangles in one colour.
class QuadScene final : public GlScene {
public:
    QuadScene(glm::ivec2 size, int samples, GLenum depth_format = GL_DEPTH_COMPONENT32F)
        : size_(size)
        , samples_(samples)
    {
        auto program = make_program("test", R"(#version 330 core
layout(location = 0) in vec3 p;
uniform mat4 clip_from_world;
invariant gl_Position;
void main() { gl_Position = clip_from_world * vec4(p, 1.0); })",
                                    R"(#version 330 core
uniform vec4 color;
layout(location = 0) out vec4 result;
void main() { result = color; })");
        EXPECT_TRUE(program) << (program ? "" : program.error().message);
        program_ = std::move(*program);
        framebuffer_ = GlFramebuffer::make();
        color_ = GlRenderbuffer::make();
        depth_ = GlRenderbuffer::make();
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
        attach(color_, GL_RGBA8, GL_COLOR_ATTACHMENT0, samples);
        attach(depth_, depth_format,
               depth_format == GL_DEPTH24_STENCIL8 ? GL_DEPTH_STENCIL_ATTACHMENT
                                                   : GL_DEPTH_ATTACHMENT,
               samples);
        EXPECT_EQ(glCheckFramebufferStatus(GL_FRAMEBUFFER),
                  static_cast<GLenum>(GL_FRAMEBUFFER_COMPLETE));
        triangles_.buffer = GlBuffer::make();
        triangles_.vertex_array = GlVertexArray::make();
        glBindVertexArray(triangles_.vertex_array.name());
        glBindBuffer(GL_ARRAY_BUFFER, triangles_.buffer.name());
        glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(glm::vec3), nullptr);
        glEnableVertexAttribArray(0);
        glBindVertexArray(0);
    }

    /// A quad facing +-z at depth z.
    ItemId add_quad(glm::vec2 low, glm::vec2 high, float z)
    {
        return add_triangles(std::vector<glm::vec3>{
            {low, z}, {high.x, low.y, z}, {high, z}, {low, z}, {high, z}, {low.x, high.y, z}});
    }

    ItemId add_triangles(std::span<const glm::vec3> points)
    {
        triangles_.firsts.push_back(static_cast<GLint>(triangles_.points.size()));
        triangles_.counts.push_back(static_cast<GLsizei>(points.size()));
        triangles_.points.insert(triangles_.points.end(), points.begin(), points.end());
        glBindBuffer(GL_ARRAY_BUFFER, triangles_.buffer.name());
        glBufferData(GL_ARRAY_BUFFER,
                     static_cast<GLsizeiptr>(triangles_.points.size() * sizeof(glm::vec3)),
                     triangles_.points.data(), GL_STATIC_DRAW);
        return ItemId{triangles_.firsts.size() - 1};
    }

    /// Forgets all items.
    void clear()
    {
        triangles_.firsts.clear();
        triangles_.counts.clear();
        triangles_.points.clear();
    }

    void begin_frame(const View& view) override
    {
        view_ = view;
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
        glViewport(0, 0, size_.x, size_.y);
        if (split_screen) { // each view clears and draws its own part of the target
            const glm::ivec2 at = view.viewport_origin_px();
            glViewport(at.x, at.y, view.size_px().x, view.size_px().y);
            glEnable(GL_SCISSOR_TEST);
            glScissor(at.x, at.y, view.size_px().x, view.size_px().y);
        }
        restore_state();
        restores = 0;
        const bool reversed = view.convention().order == DepthOrder::near_is_large;
        const bool zero_to_one = view.convention().range == DepthRange::zero_to_one;
        glClipControl(GL_LOWER_LEFT, zero_to_one ? GL_ZERO_TO_ONE : GL_NEGATIVE_ONE_TO_ONE);
        glClearDepth(reversed ? 0.0 : 1.0);
        glClearColor(0.0f, 0.0f, 0.0f, 1.0f);
        glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
        call(after_begin);
    }

    void draw(std::span<const ItemId> items, DrawPass) override
    {
        for (const ItemId item : items) {
            const auto shade = static_cast<float>((item.value * 37 + 31) % 256) / 255.0f;
            glUniform4f(glGetUniformLocation(program_.name(), "color"), shade, 0.5f, 1.0f, 1.0f);
            glDrawArrays(GL_TRIANGLES, triangles_.firsts[item.value],
                         triangles_.counts[item.value]);
        }
        call(after_draw);
    }

    void restore_state() override
    {
        ++restores;
        glUseProgram(program_.name());
        glUniformMatrix4fv(glGetUniformLocation(program_.name(), "clip_from_world"), 1, GL_FALSE,
                           glm::value_ptr(view_.clip_from_world()));
        glBindVertexArray(triangles_.vertex_array.name());
        glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
        glDepthMask(GL_TRUE);
        glEnable(GL_DEPTH_TEST);
        glDepthFunc(view_.convention().order == DepthOrder::near_is_large ? GL_GREATER : GL_LESS);
        glDisable(GL_DEPTH_CLAMP);
        glEnable(GL_CULL_FACE); // on: a device that forgets to turn it off for boxes is noticed
        glFrontFace(GL_CCW);
        glDisable(GL_BLEND);
        glDisable(GL_STENCIL_TEST);
        call(after_restore);
    }

    void prepare_tests() override { ++prepares; }

    void end_frame() override { ++ended; }

    /// Colours of the target; of a multisampled one the means of each pixel.
    std::vector<uint32_t> colors() const
    {
        std::vector<uint32_t> pixels(static_cast<size_t>(size_.x * size_.y));
        glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_.name());
        const GlFramebuffer means = GlFramebuffer::make();
        const GlRenderbuffer means_color = GlRenderbuffer::make();
        if (samples_ > 1) {
            resolve_into(means, means_color);
        }
        glReadPixels(0, 0, size_.x, size_.y, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
        glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_.name());
        return pixels;
    }

    int restores = 0; ///< calls of restore_state() since begin_frame()
    int ended = 0;
    bool split_screen = false; ///< the viewport is that of the view
    int prepares = 0;          ///< calls of prepare_tests()

    // What an engine does besides, right or wrong.
    std::function<void()> after_begin;
    std::function<void()> after_draw;
    std::function<void()> after_restore;

private:
    static void call(const std::function<void()>& hook)
    {
        if (hook) {
            hook();
        }
    }

    // Leaves `means` bound for reading.
    void resolve_into(const GlFramebuffer& means, const GlRenderbuffer& color) const
    {
        const bool scissor = glIsEnabled(GL_SCISSOR_TEST) == GL_TRUE;
        glDisable(GL_SCISSOR_TEST); // it would cut off the copy, too
        glBindRenderbuffer(GL_RENDERBUFFER, color.name());
        glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, size_.x, size_.y);
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, means.name());
        glFramebufferRenderbuffer(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                                  color.name());
        glBlitFramebuffer(0, 0, size_.x, size_.y, 0, 0, size_.x, size_.y, GL_COLOR_BUFFER_BIT,
                          GL_NEAREST);
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer_.name());
        glBindFramebuffer(GL_READ_FRAMEBUFFER, means.name());
        if (scissor) {
            glEnable(GL_SCISSOR_TEST);
        }
    }

    void attach(GlRenderbuffer& buffer, GLenum format, GLenum point, int samples)
    {
        glBindRenderbuffer(GL_RENDERBUFFER, buffer.name());
        glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples > 1 ? samples : 0, format,
                                         size_.x, size_.y);
        glFramebufferRenderbuffer(GL_FRAMEBUFFER, point, GL_RENDERBUFFER, buffer.name());
    }

    /// Draws all triangles, item after item.
    struct Triangles {
        GlBuffer buffer;
        GlVertexArray vertex_array;
        std::vector<glm::vec3> points;
        std::vector<GLint> firsts;
        std::vector<GLsizei> counts;
    };

    glm::ivec2 size_;
    int samples_;
    View view_;
    GlProgram program_;
    GlFramebuffer framebuffer_;
    GlRenderbuffer color_;
    GlRenderbuffer depth_;
    Triangles triangles_;
};

// World space is clip space in most tests: x, y, z from -1 to 1, near at z = -1, and the quarter
// [-0.5, 0.5] in x and y is 32 x 32 = 1024 pixels.
inline const View kFlatView = View::from_clip(glm::mat4{1.0f}, {64, 64});
inline constexpr Aabb kMiddle{{-0.5f, -0.5f, 0.2f}, {0.5f, 0.5f, 0.4f}};
inline constexpr uint64_t kMiddlePixels = 1024;
inline constexpr Aabb kLeft{{-0.75f, -0.25f, 0.2f}, {-0.25f, 0.25f, 0.4f}};
inline constexpr Aabb kRight{{0.25f, -0.25f, 0.2f}, {0.75f, 0.25f, 0.4f}};
inline constexpr glm::vec2 kLow{-1.0f};
inline constexpr glm::vec2 kHigh{1.0f};

/// Three tests: of the left box, of both boxes, and of the left box again.
struct Unions {
    std::array<QueryBox, 4> boxes{
        {{kLeft, nullptr, {}}, {kLeft, nullptr, {}}, {kRight, nullptr, {}}, {kLeft, nullptr, {}}}};
    std::array<uint32_t, 3> ends{1, 3, 4};
};
inline const Unions kUnions;

/// Fails, and does not skip, without OpenGL. Every test must leave no OpenGL error behind.
class GlFixture : public testing::Test {
protected:
    static constexpr glm::ivec2 kSize{64, 64};

    void SetUp() override
    {
        auto context = HeadlessContext::create();
        ASSERT_TRUE(context) << context.error().message;
        context_ = std::move(*context);
        make_scene(kSize, 1);
    }

    void TearDown() override
    {
        if (context_) {
            EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
            device.reset();
            scene.reset();
        }
    }

    void make_scene(glm::ivec2 size, int samples, GLenum depth_format = GL_DEPTH_COMPONENT32F)
    {
        device.reset();
        scene = std::make_unique<QuadScene>(size, samples, depth_format);
        make_device({});
    }

    void make_device(const GlDeviceOptions& options)
    {
        auto made = GlDevice::create(*scene, options);
        ASSERT_TRUE(made) << made.error().message;
        device = std::move(*made);
    }

    /// A device that tells its faults to `heard`.
    void make_listening_device(GlDeviceOptions options = {})
    {
        options.on_message = [this](const Message& message) {
            heard.push_back(std::string(message.name));
            text += std::string(message.text) + "\n";
        };
        make_device(options);
    }

    Ticket ask(const Aabb& box, const glm::mat4* world_from_box = nullptr)
    {
        const QueryBox boxes[] = {{box, world_from_box, {}}};
        const uint32_t ends[] = {1};
        Ticket ticket;
        device->query({boxes, ends, TestMethod::automatic}, {&ticket, 1});
        return ticket;
    }

    uint64_t count(const Aabb& box, const glm::mat4* world_from_box = nullptr)
    {
        const Answer answer = device->wait(ask(box, world_from_box));
        EXPECT_EQ(answer.state, AnswerState::ready);
        return answer.samples;
    }

    void draw(ItemId item) { device->draw({&item, 1}, DrawPass::shade); }

    /// Runs `tests`; neither colour nor depth may change.
    template <class Tests>
    void expect_nothing_written_by(Tests tests)
    {
        const std::vector<float> depth_before = depths();
        const std::vector<uint32_t> colors_before = scene->colors();
        tests();
        EXPECT_EQ(depths(), depth_before);
        EXPECT_EQ(scene->colors(), colors_before);
    }

    std::vector<float> depths(glm::ivec2 size = kSize)
    {
        std::vector<float> out(static_cast<size_t>(size.x * size.y));
        EXPECT_TRUE(device->read_depth({0, 0, size.x, size.y}, out));
        return out;
    }

    std::unique_ptr<HeadlessContext> context_;
    std::unique_ptr<QuadScene> scene;
    std::unique_ptr<GlDevice> device;
    std::vector<std::string> heard; ///< names of messages
    std::string text;               ///< ... and their sentences
};

} // namespace occlude
