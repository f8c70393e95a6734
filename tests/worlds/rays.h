// An independent check of a picture: Embree's rays through the centres of the pixels. They share no
// code with our rasteriser, our projection and our boxes.
#pragma once

#include "worlds/scene.h"

#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/core/view.h>

#include <cstdint>
#include <memory>
#include <string>

namespace occlude::worlds {

class Rays {
public:
    /// Takes the opaque triangles of the scene in their current places. `scene` outlives this.
    explicit Rays(const RandomScene& scene);
    ~Rays();
    Rays(const Rays&) = delete;
    Rays& operator=(const Rays&) = delete;

    /// Empty, or the pixel of `picture` that shows an item although its rays clearly meet a nearer
    /// one. Compares `pixels` pixels, chosen by `seed`, or all if there are no more. Adds the clear
    /// cases to `compared`. Views that ignore their near plane show surfaces that no ray from it
    /// meets: nothing is compared.
    std::string disagrees(const View& view, const CpuDevice& picture, uint32_t pixels,
                          uint64_t seed, uint64_t& compared) const;

private:
    struct Scene;

    const RandomScene& world_;
    std::unique_ptr<Scene> scene_;
    glm::dvec3 center_{0.0};
    double length_ = 0.0; ///< of a ray that leaves the world
};

} // namespace occlude::worlds
