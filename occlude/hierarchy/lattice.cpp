#include <occlude/hierarchy/lattice.h>

#include <algorithm>
#include <cmath>

namespace occlude {

static glm::uvec3 cells_along(const glm::dvec3& extent, double cube)
{
    glm::uvec3 count{1};
    for (int axis = 0; axis < 3; ++axis) {
        const double cells = std::ceil(extent[axis] / cube);
        count[axis] = static_cast<uint32_t>(
            std::clamp(cells, 1.0, static_cast<double>(Lattice::kMaxPerAxis)));
    }
    return count;
}

Lattice Lattice::over(const Aabb& box, uint64_t cells)
{
    Lattice lattice;
    OCCLUDE_ASSERT(cells > 0, "a lattice needs at least one cell");
    OCCLUDE_ASSERT(box.is_bounded(), "a lattice needs a bounded box");
    if (!box.is_bounded()) {
        return lattice;
    }
    lattice.low = glm::dvec3{box.min};
    const glm::dvec3 extent = glm::dvec3{box.max} - lattice.low;
    const double longest = std::max({extent.x, extent.y, extent.z});
    if (longest <= 0.0) {
        return lattice;
    }
    // Shrinks the cubes by a tenth each time, until there are enough.
    constexpr double kStep = 0.9;
    double cube = longest;
    lattice.count = cells_along(extent, cube);
    while (lattice.cell_count() < cells && cube * kMaxPerAxis > longest) {
        cube *= kStep;
        lattice.count = cells_along(extent, cube);
    }
    lattice.cell_size = extent / glm::dvec3{lattice.count};
    return lattice;
}

glm::uvec3 Lattice::cell(const glm::vec3& point) const
{
    glm::uvec3 cell{0};
    for (int axis = 0; axis < 3; ++axis) {
        const double offset = double{point[axis]} - low[axis];
        const double position = cell_size[axis] > 0.0 ? offset / cell_size[axis] : 0.0;
        const double last = static_cast<double>(count[axis] - 1);
        OCCLUDE_ASSERT(position == position, "a coordinate of the point is NaN");
        cell[axis] = static_cast<uint32_t>(position > 0.0 ? std::min(position, last) : 0.0);
    }
    return cell;
}

} // namespace occlude
