// The program's renderer behind one interface: GL or CPU. It draws items of a SceneModel with
// lambert shading for a QueryDevice, and renders references without any culling.
#pragma once

#include "model/scene_model.h"

#include <occlude/core/query_device.h>
#include <occlude/core/result.h>

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace occlude::tools {

/// 8-bit RGBA, row 0 at the bottom.
struct Image {
    glm::ivec2 size{0};
    std::vector<uint32_t> pixels; ///< 0xAABBGGRR
};

/// The content of the target after a frame: enough to compare two frames exactly.
struct Capture {
    Image color;
    std::vector<float> depth; ///< window depth, one value per pixel (MSAA: of sample 0)
};

class SceneRenderer {
public:
    virtual ~SceneRenderer() = default;

    /// "gl" or "cpu", the API version, and the driver's own name.
    virtual std::string api() const = 0;
    virtual std::string renderer_name() const = 0;

    /// The device whose draws this renderer executes. Lives as long as the renderer.
    virtual QueryDevice& device() = 0;

    /// Makes `method` the device's default. Fails and lists the available methods if it has none
    /// such.
    virtual Result<bool> use_test_method(TestMethod method) = 0;

    /// Changes the size of the target. Outside frames only.
    virtual Result<bool> resize(glm::ivec2 size, int samples) = 0;

    /// Waits until everything drawn is finished (for timing).
    virtual void finish() = 0;

    /// Compiles and warms up every shader variant, inside and outside of tests.
    virtual void warm_up() = 0;

    /// Draws `items` in exactly this order without tests, as one frame. Translucent ones are
    /// blended over everything drawn before them.
    virtual void render(const View& view, std::span<const ItemId> items) = 0;

    /// The target after the last frame, by whatever call it was drawn.
    virtual Capture capture() = 0;

    /// The item that owns each sample when `items` are drawn in this order without tests (the
    /// nearest opaque one, the first of equals); 0xffffffff where there is none. Pixel by pixel as
    /// images are; with several samples, the first of every pixel, then the second, and so on.
    /// Empty if the driver refuses the target.
    virtual std::vector<uint32_t> render_ids(const View& view, std::span<const ItemId> items) = 0;

    /// Overrides the base colours, indexed by ItemId (alpha unused); empty: the colours of the
    /// scene.
    virtual void set_item_colors(std::span<const glm::vec4> colors) = 0;

    /// Draws world-space line segments (pairs of points) over the last frame, tested against its
    /// depth unless `on_top`.
    virtual void draw_lines(const View& view, std::span<const glm::vec3> points, glm::vec4 color,
                            bool on_top) = 0;

    /// Takes over new transforms after objects moved; indexed by instance.
    virtual void update_transforms(std::span<const glm::mat4> world_from_mesh) = 0;

    /// Takes over what each item draws after ids were reused; as many items as when the renderer
    /// was made, all of them in its model.
    virtual void update_items(std::span<const SceneModel::Item> items) = 0;
};

/// An OpenGL renderer in a surfaceless EGL context (llvmpipe if there is no GPU). `model` and
/// `items` must outlive it.
Result<std::unique_ptr<SceneRenderer>> make_gl_renderer(const SceneModel& model,
                                                        std::span<const SceneModel::Item> items,
                                                        glm::ivec2 size, int samples);

/// A renderer on the CPU: slow, exact, and without a driver.
Result<std::unique_ptr<SceneRenderer>> make_cpu_renderer(const SceneModel& model,
                                                         std::span<const SceneModel::Item> items,
                                                         glm::ivec2 size);

} // namespace occlude::tools
