// The engine's OpenGL: one draw loop in two passes, for the camera into a multisampled target and
// for the light into a shadow map. Each pass is the GlScene of its own GlDevice.
#pragma once

#include "bugs.h"
#include "town.h"

#include <occlude/backends/gl/gl_scene.h>

#include <epoxy/gl.h>

#include <glm/mat4x4.hpp>

#include <span>
#include <vector>

namespace gl_engine {

/// Shared by both passes: meshes, program, the shadow map.
class Renderer {
public:
    static constexpr int kShadowSize = 512;
    static constexpr int kSamples = 4;

    Renderer(const Town& town, glm::ivec2 size_px);

    /// Creates all objects in the current context. Call it again after the context was recreated.
    void create_objects();

    glm::ivec2 size_px() const { return size_px_; }
    /// The target's colours of the last frame without multisampling, for the window.
    void present(GLuint framebuffer);

private:
    friend class CameraPass;
    friend class ShadowPass;
    void set_camera(const glm::mat4& clip_from_world, const glm::mat4& clip_from_light) const;
    void draw_sorted(std::span<const occlude::ItemId> items);

    const Town& town_;
    glm::ivec2 size_px_;
    GLuint program_ = 0;
    GLuint vertex_array_ = 0;
    GLuint target_ = 0;
    GLuint shadow_target_ = 0;
    GLuint shadow_map_ = 0;
    std::vector<uint64_t> order_; ///< of one batch: material, mesh, item
};

/// Reversed Z in [0, 1], so near is 1 and the clear value 0.
class CameraPass final : public occlude::GlScene {
public:
    CameraPass(Renderer& renderer, Bug bug)
        : renderer_(renderer)
        , bug_(bug)
    {
    }
    /// The light's matrix of this frame, for the shadows.
    glm::mat4 clip_from_light{1.0f};
    /// The engine's camera, which should be the view's.
    glm::mat4 clip_from_world{1.0f};
    int frame = 0;

private:
    void begin_frame(const occlude::View& view) override;
    void draw(std::span<const occlude::ItemId> items, occlude::DrawPass pass) override;
    void restore_state() override;
    void leave_something_on();

    Renderer& renderer_;
    Bug bug_;
    GLuint query_ = 0;
};

/// The light's depth, with polygon offset: state that tests do not allow.
class ShadowPass final : public occlude::GlScene {
public:
    explicit ShadowPass(Renderer& renderer)
        : renderer_(renderer)
    {
    }

private:
    void begin_frame(const occlude::View& view) override;
    void draw(std::span<const occlude::ItemId> items, occlude::DrawPass pass) override;
    void prepare_tests() override { glDisable(GL_POLYGON_OFFSET_FILL); }
    void restore_state() override;

    Renderer& renderer_;
    glm::mat4 clip_from_world_{1.0f};
};

} // namespace gl_engine
