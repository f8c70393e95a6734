// The front of the prioritized-layered projection: the cells of a grid in the order of how much
// matter lies between them and the eye.
//
// Implements  the queue of J. T. Klosowski, C. T. Silva, "The Prioritized-Layered Projection
//             Algorithm for Visible Set Estimation", 2000; prioritized.h lists the deviations.
// Map         the cell that holds the eye comes first       -> start
//             the least solid cell of the front             -> pop
//             a cell hands its solidity to its neighbours   -> spread
// Cost        O(log cells) per pop and spread; start() is O(cells).
#pragma once

#include <occlude/core/view.h>
#include <occlude/cull/parts/cell_grid.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace occlude {

class SolidityFront {
public:
    /// A cell of the lattice, occupied or not, that is in the front.
    struct Entry {
        double solidity = 0.0;
        double distance = 0.0; ///< distance of its centre from the eye's cell, in cells
        uint64_t index = 0;    ///< in the lattice
    };

    /// Puts the eye's cell into the front, alone. Precondition: `grid` has cells.
    void start(const CellGrid& grid, const View& view);

    /// Takes the least solid cell, and the nearest of equally solid ones. Each cell comes once.
    /// Returns nothing when the front is empty.
    std::optional<Entry> pop();

    /// The occupied cell of `grid` at this index, or CellGrid::kNone.
    uint32_t cell(const Entry& entry) const { return cell_at_[entry.index]; }

    /// Hands the solidity of a cell, plus its own density, on to its six neighbours.
    void spread(const CellGrid& grid, const Entry& from);

private:
    static bool comes_later(const Entry& a, const Entry& b);
    void push(const Entry& entry);

    glm::uvec3 eye_cell_{0};
    uint64_t fullest_ = 1;          ///< triangles of the fullest cell
    std::vector<uint32_t> cell_at_; ///< per index in the lattice: the occupied cell, or kNone
    std::vector<double> solidity_;  ///< per index in the lattice: the least solidity found so far
    std::vector<Entry> heap_;       ///< the least solid on top
};

} // namespace occlude
