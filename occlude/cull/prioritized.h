// Prioritized-layered projection: draws the cells with the least matter before them first, until a
// budget is spent. On demand, occlusion tests then make the image exact.
//
// Implements  J. T. Klosowski, C. T. Silva, "The Prioritized-Layered Projection Algorithm for
//             Visible Set Estimation", IEEE TVCG 6(2), 2000, and "Efficient Conservative
//             Visibility Culling Using the Prioritized-Layered Projection Algorithm", IEEE TVCG
//             7(4), 2001 (cPLP), as followed up by W. T. Correa, J. T. Klosowski, C. T. Silva,
//             "Visibility-Based Prefetching for Interactive Out-Of-Core Rendering", 2003.
// Map         the front, a queue of cells by solidity    -> SolidityFront (solidity_front.h)
//             what a cell hands on to its neighbours     -> SolidityFront::spread
//             the projection, until the budget is spent  -> Prioritized::draw_by_solidity
//             the finish of cPLP                         -> Prioritized::finish_by_tests
// Deviations  Cells belong to a regular grid, not to a tetrahedral mesh or octree. The solidity of
//             a cell is the least sum of densities over all paths of cells from the eye to it,
//             where density is the cell's triangles over the triangles of the fullest cell; the
//             papers weigh faces by the view direction. cPLP tests the cells of its front and goes
//             on from the visible ones. Here, all remaining occupied cells are tested in batches,
//             by the box around their contents: never more tests than occupied cells.
// Guarantees  approximate: any item may be missing. Exact with `finish`: then every item in the
//             frustum is drawn, or all its cells were found hidden in this frame.
// Cost        the budget, in triangles or in milliseconds of the clock, exceeded by at most one
//             cell or `chunk_triangles`. One step per cell of the grid, empty cells included. With
//             `finish`, one test per cell that the budget left out, and the items that the tests
//             reveal.
#pragma once

#include <occlude/core/clock.h>
#include <occlude/core/option_range.h>
#include <occlude/cull/culler.h>
#include <occlude/cull/parts/cell_grid.h>
#include <occlude/cull/parts/cull_frame.h>
#include <occlude/cull/parts/solidity_front.h>

#include <cstdint>
#include <vector>

namespace occlude {

struct PrioritizedOptions {
    /// Triangles that a frame draws before the finish; 0: no limit.
    uint64_t budget_triangles = 100000;
    /// Milliseconds that a frame draws before the finish; 0, or without a clock: no limit.
    double budget_time = 0.0;
    /// Tests the cells that the budget left out and draws the visible ones (cPLP): exact.
    bool finish = false;
    /// The mean number of triangles per cell, which sets the size of cells.
    uint64_t cell_triangles = 4096;
    /// With a time budget: reads the clock each time that this many triangles are drawn.
    uint64_t chunk_triangles = 8192;
    /// Number of cells in one batch of tests of the finish.
    uint32_t batch_size = 50;
};

class Prioritized final : public Culler {
public:
    using Options = PrioritizedOptions;
    static constexpr AlgorithmTraits kTraits{
        .name = "prioritized",
        .paper = "Klosowski, Silva 2000; Correa, Klosowski, Silva 2003",
        .summary = "draws the cells that are least likely hidden first, until a budget is spent",
        .needs = {.queries = true},
        .node_use = NodeUse::none,
        .exact = PrioritizedOptions{}.finish,
    };

    /// `clock` returns rising seconds. It measures the time to issue draws, which is the time to
    /// draw only if the device draws at once or the clock waits for it. It is never read without a
    /// time budget.
    explicit Prioritized(HierarchyRef hierarchy, PrioritizedOptions options = {},
                         SecondsClock clock = {})
        : Culler(hierarchy)
        , options_(clamped(options))
        , clock_(std::move(clock))
    {
    }

private:
    /// An occupied cell that the budget left out.
    struct Remaining {
        float distance;
        uint32_t cell;
    };

    void cull_frame(CullFrame& frame) override;
    void reset_state() override { seen_stamp_.clear(); }
    Guarantee guarantee() const override;

    void prepare();
    void draw_by_solidity(CullFrame& frame);
    bool spent(CullFrame& frame);
    void draw_cell(CullFrame& frame, uint32_t cell, Decision decision);
    bool any_left(const CullFrame& frame, const CellGrid::Cell& cell) const;
    void finish_by_tests(CullFrame& frame);
    void test_batch(CullFrame& frame);
    void note_hidden(CullFrame& frame);

    PrioritizedOptions options_;
    SecondsClock clock_;
    CellGrid grid_;
    SolidityFront front_;
    std::vector<uint32_t> seen_stamp_; ///< by position: the last frame that drew or decided it
    std::vector<Remaining> remaining_;
    std::vector<uint32_t> hidden_;
    TestBatch batch_;
    std::vector<Ticket> tickets_;
    std::vector<uint32_t> tested_;
    uint64_t triangles_ = 0; ///< drawn and queued in this frame
    double start_ = 0.0;
};

template <class Visit>
void visit_options(PrioritizedOptions& o, Visit&& visit)
{
    visit("budget_triangles", o.budget_triangles, {},
          "triangles that a frame draws before the finish; 0: no limit");
    visit("budget_time", o.budget_time, {},
          "milliseconds that a frame draws before the finish; 0: no limit");
    visit("finish", o.finish, "test what the budget left out and draw what is visible: exact");
    visit("cell_triangles", o.cell_triangles, {1},
          "mean triangles per cell, which set the size of cells");
    visit("chunk_triangles", o.chunk_triangles, {1},
          "with budget_time: triangles drawn between two readings of the clock");
    visit("batch_size", o.batch_size, {1, 65536}, "cells in one batch of tests of the finish");
}

} // namespace occlude
