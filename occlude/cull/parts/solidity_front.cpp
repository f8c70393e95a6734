#include <occlude/cull/parts/solidity_front.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <limits>
#include <tuple>

namespace occlude {

// Without an eye, the front begins at the cell farthest against the view direction.
static glm::uvec3 first_cell(const Lattice& lattice, const View& view)
{
    if (!view.orthographic()) {
        return lattice.cell(view.eye());
    }
    const glm::vec3 forward{view.frustum().plane(Frustum::near)};
    glm::uvec3 first{0};
    for (int axis = 0; axis < 3; ++axis) {
        first[axis] = forward[axis] >= 0.0f ? 0 : lattice.count[axis] - 1;
    }
    return first;
}

void SolidityFront::start(const CellGrid& grid, const View& view)
{
    const CellGrid::Grid& outermost = grid.grids()[0];
    const Lattice& lattice = outermost.lattice;
    cell_at_.assign(lattice.cell_count(), CellGrid::kNone);
    solidity_.assign(lattice.cell_count(), std::numeric_limits<double>::infinity());
    fullest_ = 1;
    for (uint32_t c = 0; c < outermost.cell_count; ++c) {
        const CellGrid::Cell& cell = grid.cells()[c];
        cell_at_[lattice.index(cell.at)] = c;
        fullest_ = std::max(fullest_, cell.triangles);
    }
    eye_cell_ = first_cell(lattice, view);
    heap_.clear();
    push({0.0, 0.0, lattice.index(eye_cell_)});
}

bool SolidityFront::comes_later(const Entry& a, const Entry& b)
{
    return std::tie(a.solidity, a.distance, a.index) > std::tie(b.solidity, b.distance, b.index);
}

void SolidityFront::push(const Entry& entry)
{
    if (entry.solidity >= solidity_[entry.index]) {
        return; // a path through less matter is known
    }
    solidity_[entry.index] = entry.solidity;
    heap_.push_back(entry);
    std::push_heap(heap_.begin(), heap_.end(), comes_later);
}

std::optional<SolidityFront::Entry> SolidityFront::pop()
{
    while (!heap_.empty()) {
        std::pop_heap(heap_.begin(), heap_.end(), comes_later);
        const Entry entry = heap_.back();
        heap_.pop_back();
        if (entry.solidity <= solidity_[entry.index]) {
            return entry;
        } // Otherwise the cell came to the front again, by a better path.
    }
    return std::nullopt;
}

void SolidityFront::spread(const CellGrid& grid, const Entry& from)
{
    const Lattice& lattice = grid.grids()[0].lattice;
    const uint32_t occupied = cell(from);
    const double density =
        occupied == CellGrid::kNone
            ? 0.0
            : static_cast<double>(grid.cells()[occupied].triangles) / static_cast<double>(fullest_);
    const glm::uvec3 at = lattice.at(from.index);
    for (int axis = 0; axis < 3; ++axis) {
        for (const uint32_t step : {~0u, 1u}) { // backward, forward
            glm::uvec3 next = at;
            next[axis] += step;
            if (next[axis] < lattice.count[axis]) {
                const double distance = glm::distance(glm::dvec3{next}, glm::dvec3{eye_cell_});
                push({from.solidity + density, distance, lattice.index(next)});
            }
        }
    }
}

} // namespace occlude
