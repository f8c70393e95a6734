// The program's renderer without a GPU: the CPU device draws, and the image is shaded afterwards
// from the triangle that each pixel shows. Slow, exact, and the same on every machine.
#pragma once

#include "render/scene_renderer.h"

#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/core/result.h>

#include <array>
#include <optional>

namespace occlude::tools {

/// A SceneModel in the form that the CPU device needs. Copies the transforms, so that they can
/// change.
class CpuModelScene final : public CpuScene {
public:
    /// Precondition: every item names an instance and a part that exist.
    CpuModelScene(const SceneModel& model, std::span<const SceneModel::Item> items);

    CpuItem item(ItemId item) const override;

    /// Takes over new transforms, one per instance and indexed by it.
    void set_transforms(std::span<const glm::mat4> world_from_mesh);
    /// Takes over what each item draws.
    void set_items(std::span<const SceneModel::Item> items);

    /// Corners of a triangle of an item, world space. Precondition: it exists.
    std::array<glm::vec3, 3> triangle(ItemId item, uint32_t triangle) const;
    /// The base colour of the item's instance.
    glm::vec3 color(ItemId item) const;
    float opacity(ItemId item) const;

private:
    const SceneModel& model_;
    std::vector<SceneModel::Item> items_;
    std::vector<glm::mat4> world_from_mesh_;
};

/// Lambert shading on the geometric normal, both sides lit alike. Deviation from SceneRenderer:
/// translucent fragments are blended in draw order when the image is captured, rounding to 8 bits
/// each time. Of equal depths, render_ids and frames show the smaller ItemId, whatever the order of
/// draws.
class CpuRenderer final : public SceneRenderer {
public:
    CpuRenderer(const SceneModel& model, std::span<const SceneModel::Item> items, glm::ivec2 size);

    std::string api() const override { return "cpu"; }
    std::string renderer_name() const override { return "scalar software rasteriser"; }
    QueryDevice& device() override { return device_; }
    Result<bool> use_test_method(TestMethod method) override { return device_.use_method(method); }

    /// Errors: invalid_argument for a size outside of [1, cpu::kMaxSide]; unsupported for more than
    /// one sample per pixel.
    Result<bool> resize(glm::ivec2 size, int samples) override;
    void finish() override {}
    void warm_up() override {}
    void render(const View& view, std::span<const ItemId> items) override;
    /// Shades the whole target, which takes about as long as drawing it. Its size is the size of
    /// the last frame's view; before the first frame, it is the background in the renderer's size.
    Capture capture() override;
    std::vector<uint32_t> render_ids(const View& view, std::span<const ItemId> items) override;
    void set_item_colors(std::span<const glm::vec4> colors) override;
    /// Lines are one pixel wide, blended by the alpha of `color`, and vanish with the next frame.
    void draw_lines(const View& view, std::span<const glm::vec3> points, glm::vec4 color,
                    bool on_top) override;
    void update_transforms(std::span<const glm::mat4> world_from_mesh) override;
    void update_items(std::span<const SceneModel::Item> items) override;

private:
    struct LineFragment {
        size_t pixel = 0;
        glm::vec3 color{0.0f};
        float alpha = 1.0f;
    };

    uint32_t shaded(const CpuDevice::Owner& owner) const;
    void draw_line(glm::dvec4 a, glm::dvec4 b, glm::vec4 color, bool on_top);

    CpuModelScene scene_;
    CpuDevice device_;
    std::optional<CpuDevice> id_device_; ///< made when first needed, because render_ids must not
                                         ///< touch the last frame
    glm::ivec2 size_px_;
    std::vector<glm::vec4> item_colors_;
    std::vector<LineFragment> lines_;
    uint64_t lines_frame_ = 0; ///< the frame of the device that lines_ were drawn over
};

} // namespace occlude::tools
