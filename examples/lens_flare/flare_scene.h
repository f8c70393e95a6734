// The example's scene: columns on a ground, shaded in software, and the flares over them.
#pragma once

#include "render/scene_renderer.h"

#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/backends/cpu/cpu_scene.h>
#include <occlude/effects/flare_visibility.h>
#include <occlude/hierarchy/hierarchy.h>

#include <vector>

namespace occlude::lens_flare {

/// Boxes of twelve triangles: a ground and three rows of columns with lintels.
class Columns final : public CpuScene {
public:
    Columns();

    CpuItem item(ItemId item) const override;
    std::span<const ItemBounds> bounds() const { return bounds_; }
    /// The outward normal of a triangle of a box.
    static glm::vec3 normal(uint32_t triangle);

private:
    void add(const glm::vec3& low, const glm::vec3& high);

    std::vector<ItemBounds> bounds_;
    std::vector<std::vector<glm::vec3>> corners_;
};

/// The visible share of a light's disc in the frame in `device`, counted pixel by pixel.
double exact_fraction(const CpuDevice& device, const View& view, const FlareLight& light);

/// The frame in `device` with an evening light.
tools::Image shaded_image(const CpuDevice& device, const Columns& columns);

/// Adds the glow of a light, and its ghosts across the middle of the picture.
void add_flare(tools::Image& image, const View& view, const FlareLight& light, double brightness);

} // namespace occlude::lens_flare
