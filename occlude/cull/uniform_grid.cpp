#include <occlude/cull/uniform_grid.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace occlude {

// The axis that is closest to the view direction.
static int slab_axis(const View& view)
{
    const glm::vec3 forward = glm::abs(glm::vec3{view.frustum().plane(Frustum::near)});
    if (forward.z >= forward.x && forward.z >= forward.y) {
        return 2;
    }
    return forward.y >= forward.x ? 1 : 0;
}

// The slab at which the front-to-back order starts: the slab of the eye, or, without an eye, the
// first one along the view direction.
static uint32_t first_slab(const View& view, const Lattice& lattice, int axis)
{
    if (!view.orthographic()) {
        return lattice.cell(view.eye())[axis];
    }
    const bool forward = glm::vec3{view.frustum().plane(Frustum::near)}[axis] >= 0.0f;
    return forward ? 0 : lattice.count[axis] - 1;
}

// The cells of a grid in the frustum, slab by slab outward from the eye, and near to far in each
// slab.
void UniformGrid::collect_cells(CullFrame& frame, const CellGrid::Grid& grid, PlaneMask mask,
                                std::vector<Entry>& entries)
{
    const View& view = frame.view();
    const int axis = slab_axis(view);
    const auto first = static_cast<int64_t>(first_slab(view, grid.lattice, axis));
    entries.clear();
    for (uint32_t c = grid.first_cell; c < grid.first_cell + grid.cell_count; ++c) {
        const CellGrid::Cell& cell = grid_.cells()[c];
        PlaneMask cell_mask = mask;
        ++frame.counters().nodes_visited;
        if (view.frustum().classify(cell.box, cell_mask) == Containment::outside) {
            continue;
        }
        const int64_t steps = static_cast<int64_t>(cell.at[axis]) - first;
        // Outward: the eye's own slab, then one step to each side, then two.
        const auto slab = static_cast<uint32_t>(steps > 0 ? 2 * steps - 1 : -2 * steps);
        entries.push_back({slab, view.distance_key(cell.box), c, cell_mask});
    }
    std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
        return std::tie(a.slab, a.distance, a.cell) < std::tie(b.slab, b.distance, b.cell);
    });
}

bool UniformGrid::all_drawn(const CullFrame& frame, const CellGrid::Cell& cell) const
{
    return std::ranges::all_of(grid_.items(cell), [&](ItemPosition item) {
        return seen_stamp_[item.value] == frame.stamp();
    });
}

void UniformGrid::draw_cell(CullFrame& frame, const Entry& entry, Decision decision)
{
    for (const ItemPosition item : grid_.items(grid_.cells()[entry.cell])) {
        if (seen_stamp_[item.value] != frame.stamp()) {
            seen_stamp_[item.value] = frame.stamp();
            // All planes are needed, because only a part of a large item lies in the cell.
            frame.draw_item(grid_.owner(item), item, Frustum::kAllPlanes, decision);
        }
    }
}

void UniformGrid::found_visible(CullFrame& frame, const Entry& entry, Decision decision,
                                std::vector<Entry>& opened)
{
    if (grid_.cells()[entry.cell].grid == CellGrid::kNone) {
        draw_cell(frame, entry, decision);
    } else {
        opened.push_back(entry);
    }
}

// Tests the cells of a slab together, then reads all answers. Cells that must not be tested are
// drawn first, so that they hide others.
void UniformGrid::test_slab(CullFrame& frame, std::span<const Entry> slab,
                            std::vector<Entry>& opened)
{
    batch_.clear();
    tested_.clear();
    const size_t max_tests = std::max(frame.caps().max_outstanding, 1u);
    for (const Entry& entry : slab) {
        const CellGrid::Cell& cell = grid_.cells()[entry.cell];
        const Aabb test_box = frame.view().inflated_for_test(cell.box);
        if (all_drawn(frame, cell)) {
            continue;
        }
        if (frame.view().touches_near(test_box)) {
            found_visible(frame, entry, Decision::drawn_near, opened);
            continue;
        }
        if (tested_.size() == max_tests) {
            found_visible(frame, entry, Decision::drawn, opened);
            continue;
        }
        batch_.add_box(test_box, NodeId{});
        batch_.end_test();
        tested_.push_back(entry);
    }
    frame.flush_draws();
    if (tested_.empty()) {
        return;
    }
    frame.query(batch_, tickets_);
    for (size_t i = 0; i < tested_.size(); ++i) {
        if (is_visible(frame.wait(tickets_[i]), 0)) {
            found_visible(frame, tested_[i], Decision::drawn_revealed, opened);
        } else {
            hidden_.push_back(tested_[i].cell);
        }
    }
    frame.flush_draws();
}

void UniformGrid::cull_grid(CullFrame& frame, const CellGrid::Grid& grid, PlaneMask mask,
                            size_t depth)
{
    collect_cells(frame, grid, mask, levels_[depth].entries);
    for (size_t begin = 0, end = 0; begin < levels_[depth].entries.size(); begin = end) {
        const std::span<const Entry> entries = levels_[depth].entries;
        while (end < entries.size() && entries[end].slab == entries[begin].slab) {
            ++end;
        }
        levels_[depth].opened.clear();
        test_slab(frame, entries.subspan(begin, end - begin), levels_[depth].opened);
        for (const Entry& cell : levels_[depth].opened) {
            cull_grid(frame, grid_.grids()[grid_.cells()[cell.cell].grid], cell.mask, depth + 1);
        }
    }
}

// Decides the items of hidden cells that no other cell has drawn.
void UniformGrid::note_hidden(CullFrame& frame)
{
    for (const uint32_t cell : hidden_) {
        for (const ItemPosition item : grid_.items(grid_.cells()[cell])) {
            if (seen_stamp_[item.value] != frame.stamp()) {
                seen_stamp_[item.value] = frame.stamp();
                frame.decide_item(grid_.owner(item), item, Decision::hidden);
            }
        }
    }
}

void UniformGrid::cull_frame(CullFrame& frame)
{
    grid_.update(hierarchy(), {options_.cell_triangles, options_.nested_levels});
    seen_stamp_.resize(hierarchy().items().size());
    levels_.resize(size_t{options_.nested_levels} + 1);
    hidden_.clear();

    for (const ItemPosition item : grid_.unbounded()) {
        frame.draw_item(grid_.owner(item), item, Frustum::kAllPlanes, Decision::drawn_near);
    }
    if (!grid_.grids().empty()) {
        cull_grid(frame, grid_.grids()[0], Frustum::kAllPlanes, 0);
    }
    note_hidden(frame);
}

} // namespace occlude
