// Uniform and nested grids, tested slab by slab.
//
// Implements  K. Hillesland, B. Salomon, A. Lastra, D. Manocha, "Fast and Simple Occlusion Culling
//             using Hardware-Based Depth Queries", technical report, UNC Chapel Hill, 2002.
// Map         slabs of cells, front to back             -> UniformGrid::collect_cells
//             one query per cell of a slab, then all
//             results of the slab                       -> UniformGrid::test_slab
//             draw each object once                     -> UniformGrid::draw_cell
//             nested grid in a crowded cell             -> the recursion in UniformGrid::cull_grid
// Deviations  Slabs go outward from the eye's own along the axis that is closest to the view
//             direction. Cells are tested by the box around their contents, not by their walls
//             (see cell_grid.h). A cell all of whose items are drawn is not tested. No state is
//             kept between frames, as in the paper.
// Guarantees  exact: an item in the frustum is drawn if the test of any cell that it overlaps finds
//             a sample, or cannot be trusted near the viewer (rule R1).
// Cost        one test per occupied cell in the frustum, and per slab one batch and one wait for
//             its answers. All cells are built again after an item moves.
#pragma once

#include <occlude/core/option_range.h>
#include <occlude/cull/culler.h>
#include <occlude/cull/parts/cell_grid.h>
#include <occlude/cull/parts/cull_frame.h>

#include <cstdint>
#include <vector>

namespace occlude {

struct UniformGridOptions {
    /// The mean number of triangles per cell, which sets the size of cells.
    uint64_t cell_triangles = 4096;
    /// Crowded cells hold a grid of their own, up to this many levels deep. 0: the uniform grid.
    uint32_t nested_levels = 1;
};

class UniformGrid final : public Culler {
public:
    using Options = UniformGridOptions;
    static constexpr AlgorithmTraits kTraits{
        .name = "uniform_grid",
        .paper = "Hillesland, Salomon, Lastra, Manocha 2002",
        .summary = "tests the cells of a uniform or nested grid of its own, slab by slab",
        .needs = {.queries = true},
        .node_use = NodeUse::none,
    };

    explicit UniformGrid(HierarchyRef hierarchy, UniformGridOptions options = {})
        : Culler(hierarchy)
        , options_(clamped(options))
    {
    }

private:
    /// An occupied cell in the frustum.
    struct Entry {
        uint32_t slab; ///< from the eye outward
        float distance;
        uint32_t cell;
        PlaneMask mask;
    };
    /// Scratch memory of one level of nesting.
    struct Level {
        std::vector<Entry> entries;
        std::vector<Entry> opened; ///< visible cells of a slab that hold a grid
    };

    void cull_frame(CullFrame& frame) override;
    void reset_state() override { seen_stamp_.clear(); }

    void cull_grid(CullFrame& frame, const CellGrid::Grid& grid, PlaneMask mask, size_t depth);
    void collect_cells(CullFrame& frame, const CellGrid::Grid& grid, PlaneMask mask,
                       std::vector<Entry>& entries);
    void test_slab(CullFrame& frame, std::span<const Entry> slab, std::vector<Entry>& opened);
    void found_visible(CullFrame& frame, const Entry& entry, Decision decision,
                       std::vector<Entry>& opened);
    void draw_cell(CullFrame& frame, const Entry& entry, Decision decision);
    bool all_drawn(const CullFrame& frame, const CellGrid::Cell& cell) const;
    void note_hidden(CullFrame& frame);

    UniformGridOptions options_;
    CellGrid grid_;
    std::vector<Level> levels_;
    std::vector<uint32_t> seen_stamp_; ///< by position: the last frame that drew or decided it
    std::vector<uint32_t> hidden_;     ///< cells found hidden in this frame
    TestBatch batch_;
    std::vector<Ticket> tickets_;
    std::vector<Entry> tested_;
};

template <class Visit>
void visit_options(UniformGridOptions& o, Visit&& visit)
{
    visit("cell_triangles", o.cell_triangles, {1},
          "mean triangles per cell, which set the size of cells");
    visit("nested_levels", o.nested_levels, {0, 8},
          "levels of grids nested in crowded cells; 0: a uniform grid");
}

} // namespace occlude
