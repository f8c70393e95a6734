// The program's OpenGL renderer, with its own surfaceless context.
#pragma once

#include "render/gl_context.h"
#include "render/gl_geometry.h"
#include "render/gl_target.h"
#include "render/scene_renderer.h"

#include <occlude/backends/gl/gl_device.h>
#include <occlude/backends/gl/gl_scene.h>
#include <occlude/core/result.h>

#include <memory>
#include <string>

namespace occlude::tools {

struct GlRendererOptions {
    /// Uses no feature newer than this version of OpenGL (10 * major + minor): 33 takes the oldest
    /// code path.
    int max_gl_version = 99;
    /// The context to draw in, shared with the code that shows the pictures; null: its own, without
    /// a window.
    std::shared_ptr<GlContext> context = {};
};

/// What an OpenGL renderer offers in addition to a SceneRenderer: pictures for others in its
/// context.
class GlPictureSource {
public:
    virtual ~GlPictureSource() = default;
    /// Copies the colours of the last frame into a framebuffer object of the same size. Changes
    /// framebuffer bindings and no other state.
    virtual void copy_color_to(unsigned framebuffer) = 0;
};

/// make_gl_renderer() with options. The renderer belongs to the thread that made it. Several may
/// exist at once, but the frames of their devices must not interleave.
Result<std::unique_ptr<SceneRenderer>> make_gl_renderer(const SceneModel& model,
                                                        std::span<const SceneModel::Item> items,
                                                        glm::ivec2 size, int samples,
                                                        const GlRendererOptions& options);

} // namespace occlude::tools
