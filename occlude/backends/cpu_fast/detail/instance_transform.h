// How an instance of a mesh comes onto the grid of a view.
#pragma once

#include <occlude/backends/cpu_fast/detail/prim.h>
#include <occlude/core/aabb.h>
#include <occlude/core/pixel_rect.h>
#include <occlude/core/view.h>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace occlude::cpu_fast {

/// The grid of a view.
struct Grid {
    glm::ivec2 size_px{0};
    int cell_px = 1;
    glm::ivec2 size_cells{0};
    glm::ivec2 size_bins{0};

    Grid() = default;
    Grid(glm::ivec2 size_px, int cell_px);
    size_t bin_count() const { return pixel_count(size_bins); }
    /// Of bin column x in bin row y.
    size_t bin_index(int x, int y) const
    {
        return static_cast<size_t>(y) * static_cast<size_t>(size_bins.x) + static_cast<size_t>(x);
    }
};

/// How one instance of a mesh comes onto the grid.
struct InstanceTransform {
    InstanceTransform() = default;
    /// `usable` is false if nothing of the instance may hide anything.
    InstanceTransform(const View& view, const Grid& grid, const glm::mat4& world_from_mesh,
                      const Aabb& box);

    std::array<glm::vec4, 4> column{}; ///< of the map to (x cells, y cells, window depth, 1) * w
    float least_w = 0.0f;              ///< positions of less w are known too badly
    float least_z = 0.0f;      ///< window depth * w at the near plane, and what it is off by
    glm::vec2 guard_low{0.0f}; ///< x >= guard_low * w, in cells
    glm::vec2 guard_high{0.0f};
    Growth growth;
    float nearest = 0.0f;    ///< no corner of its box is nearer, in window depth
    uint32_t tie_break = 0;  ///< tells boxes that are equally near apart
    float z_slack = 0.0f;    ///< what depth may be off by, in window depth
    float front_sign = 1.0f; ///< counter-clockwise in the mesh: this times the area on the grid > 0
    bool usable = false;
};

} // namespace occlude::cpu_fast
