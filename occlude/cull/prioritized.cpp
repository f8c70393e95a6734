#include <occlude/cull/prioritized.h>

#include <occlude/core/assert.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <limits>
#include <tuple>

namespace occlude {

Guarantee Prioritized::guarantee() const
{
    return options_.finish ? Guarantee::exact() : Guarantee::approximate(Guarantee::kAnySamples);
}

void Prioritized::prepare(const CullFrame& frame)
{
    grid_.update(hierarchy(), {.cell_triangles = options_.cell_triangles});
    seen_stamp_.resize(hierarchy().items().size());
    cells_drawn_.clear();
    hidden_.clear();
    front_.clear();
    triangles_ = 0;
    start_ = clock_ && options_.budget_time > 0.0 ? clock_() : 0.0;
    if (grid_.grids().empty()) {
        return;
    }
    const CellGrid::Grid& grid = grid_.grids()[0];
    cell_at_.assign(grid.lattice.cell_count(), CellGrid::kNone);
    solidity_.assign(grid.lattice.cell_count(), std::numeric_limits<double>::infinity());
    fullest_ = 1;
    for (uint32_t c = 0; c < grid.cell_count; ++c) {
        const CellGrid::Cell& cell = grid_.cells()[c];
        cell_at_[grid.lattice.index(cell.at)] = c;
        fullest_ = std::max(fullest_, cell.triangles);
    }
    // Without an eye, the view begins at the cell that lies farthest against its direction.
    const glm::vec3 forward{frame.view().frustum().plane(Frustum::near)};
    const Lattice& lattice = grid.lattice;
    glm::uvec3 first = lattice.cell(frame.view().eye());
    if (frame.view().orthographic()) {
        for (int axis = 0; axis < 3; ++axis) {
            first[axis] = forward[axis] >= 0.0f ? 0 : lattice.count[axis] - 1;
        }
    }
    push({0.0, 0.0, lattice.index(first)});
}

bool Prioritized::comes_later(const Front& a, const Front& b)
{
    return std::tie(a.solidity, a.distance, a.index) > std::tie(b.solidity, b.distance, b.index);
}

void Prioritized::push(const Front& entry)
{
    if (entry.solidity >= solidity_[entry.index]) {
        return; // a way through less matter is known
    }
    solidity_[entry.index] = entry.solidity;
    front_.push_back(entry);
    std::push_heap(front_.begin(), front_.end(), comes_later);
}

Prioritized::Front Prioritized::pop()
{
    OCCLUDE_ASSERT(!front_.empty(), "an empty front has nothing to pop");
    std::pop_heap(front_.begin(), front_.end(), comes_later);
    const Front entry = front_.back();
    front_.pop_back();
    return entry;
}

// Hands the solidity of a cell, and its own density, on to the six cells beside it.
void Prioritized::spread(const Front& from, const glm::uvec3& eye_cell)
{
    const Lattice& lattice = grid_.grids()[0].lattice;
    const uint32_t cell = cell_at_[from.index];
    const double density =
        cell == CellGrid::kNone
            ? 0.0
            : static_cast<double>(grid_.cells()[cell].triangles) / static_cast<double>(fullest_);
    const glm::uvec3 at = lattice.at(from.index);
    for (int axis = 0; axis < 3; ++axis) {
        for (const uint32_t step : {~0u, 1u}) { // back, forth
            glm::uvec3 next = at;
            next[axis] += step;
            if (next[axis] < lattice.count[axis]) {
                const double distance = glm::distance(glm::dvec3{next}, glm::dvec3{eye_cell});
                push({from.solidity + density, distance, lattice.index(next)});
            }
        }
    }
}

bool Prioritized::spent(CullFrame& frame)
{
    if (options_.budget_triangles > 0 && triangles_ >= options_.budget_triangles) {
        return true;
    }
    if (!clock_ || options_.budget_time <= 0.0) {
        return false;
    }
    if (frame.queued_triangles() >= options_.chunk_triangles) {
        frame.flush_draws();
    }
    constexpr double kMsPerSecond = 1000.0;
    return kMsPerSecond * (clock_() - start_) >= options_.budget_time;
}

bool Prioritized::any_left(const CullFrame& frame, const CellGrid::Cell& cell) const
{
    return std::ranges::any_of(grid_.items(cell), [&](ItemPosition item) {
        return seen_stamp_[item.value] != frame.stamp();
    });
}

void Prioritized::draw_cell(CullFrame& frame, uint32_t cell, Decision decision)
{
    const uint64_t queued_before = frame.queued_triangles();
    for (const ItemPosition item : grid_.items(grid_.cells()[cell])) {
        if (seen_stamp_[item.value] != frame.stamp()) {
            seen_stamp_[item.value] = frame.stamp();
            frame.draw_item(grid_.owner(item), item, Frustum::kAllPlanes, decision);
        }
    }
    triangles_ += frame.queued_triangles() - queued_before;
    cells_drawn_.push_back(cell);
}

// Takes cells from the front, the least solid first and of these the nearest, until the budget is
// spent. Cells outside of the frustum hand on solidity but are not drawn.
void Prioritized::draw_by_solidity(CullFrame& frame)
{
    const Lattice& lattice = grid_.grids()[0].lattice;
    const glm::uvec3 eye_cell = lattice.at(front_.front().index);
    while (!front_.empty()) {
        const Front entry = pop();
        if (entry.solidity > solidity_[entry.index]) {
            continue; // came to the front again, by a better way
        }
        ++frame.counters().nodes_visited;
        const uint32_t cell = cell_at_[entry.index];
        if (cell != CellGrid::kNone &&
            frame.view().frustum().classify(grid_.cells()[cell].box) != Containment::outside) {
            if (spent(frame)) {
                return;
            }
            draw_cell(frame, cell, Decision::drawn);
        }
        spread(entry, eye_cell);
    }
}

void Prioritized::test_batch(CullFrame& frame)
{
    frame.flush_draws();
    if (tested_.empty()) {
        return;
    }
    frame.query(batch_, tickets_);
    for (size_t i = 0; i < tested_.size(); ++i) {
        if (is_visible(frame.wait(tickets_[i]), 0)) {
            draw_cell(frame, tested_[i], Decision::drawn_revealed);
        } else {
            hidden_.push_back(tested_[i]);
        }
    }
    batch_.clear();
    tested_.clear();
}

// Tests what the budget left out, near to far, each batch against all that is drawn before it.
void Prioritized::finish_by_tests(CullFrame& frame)
{
    remaining_.clear();
    for (uint32_t c = 0; c < grid_.cells().size(); ++c) {
        const CellGrid::Cell& cell = grid_.cells()[c];
        if (any_left(frame, cell) &&
            frame.view().frustum().classify(cell.box) != Containment::outside) {
            remaining_.push_back({frame.view().distance_key(cell.box), c});
        }
    }
    std::sort(remaining_.begin(), remaining_.end(), [](const Remaining& a, const Remaining& b) {
        return std::tie(a.distance, a.cell) < std::tie(b.distance, b.cell);
    });
    const size_t batch_size =
        std::clamp(options_.batch_size, 1u, std::max(frame.caps().max_outstanding, 1u));
    batch_.clear();
    tested_.clear();
    for (const Remaining& entry : remaining_) {
        const CellGrid::Cell& cell = grid_.cells()[entry.cell];
        if (!any_left(frame, cell)) {
            continue;
        }
        const Aabb test_box = frame.view().inflated_for_test(cell.box);
        if (frame.view().touches_near(test_box)) {
            draw_cell(frame, entry.cell, Decision::drawn_near);
            continue;
        }
        batch_.add_box(test_box, NodeId{});
        batch_.end_test();
        tested_.push_back(entry.cell);
        if (tested_.size() == batch_size) {
            test_batch(frame);
        }
    }
    test_batch(frame);
}

// Items of hidden cells that no other cell has drawn.
void Prioritized::note_hidden(CullFrame& frame)
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

void Prioritized::cull_frame(CullFrame& frame)
{
    prepare(frame);
    for (const ItemPosition item : grid_.unbounded()) {
        frame.draw_item(grid_.owner(item), item, Frustum::kAllPlanes, Decision::drawn_near);
    }
    if (grid_.grids().empty()) {
        return;
    }
    draw_by_solidity(frame);
    if (options_.finish) {
        finish_by_tests(frame);
    }
    note_hidden(frame);
}

} // namespace occlude
