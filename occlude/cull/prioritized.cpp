#include <occlude/cull/prioritized.h>

#include <algorithm>
#include <tuple>

namespace occlude {

Guarantee Prioritized::guarantee() const
{
    return options_.finish ? Guarantee::exact() : Guarantee::approximate(Guarantee::kAnySamples);
}

void Prioritized::prepare()
{
    grid_.update(hierarchy(), {.cell_triangles = options_.cell_triangles});
    seen_stamp_.resize(hierarchy().items().size());
    hidden_.clear();
    triangles_ = 0;
    start_ = clock_ && options_.budget_time > 0.0 ? clock_() : 0.0;
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
}

// Takes cells from the front until the budget is spent, the least solid first, and the nearest of
// equally solid ones. Cells outside the frustum hand on solidity but are not drawn.
void Prioritized::draw_by_solidity(CullFrame& frame)
{
    front_.start(grid_, frame.view());
    while (const std::optional<SolidityFront::Entry> entry = front_.pop()) {
        ++frame.counters().nodes_visited;
        const uint32_t cell = front_.cell(*entry);
        if (cell != CellGrid::kNone &&
            frame.view().frustum().classify(grid_.cells()[cell].box) != Containment::outside) {
            if (spent(frame)) {
                return;
            }
            draw_cell(frame, cell, Decision::drawn);
        }
        front_.spread(grid_, *entry);
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

// Tests the cells that the budget left out, near to far, each batch against all that is drawn
// before it.
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

// Decides the items of hidden cells that no other cell has drawn.
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
    prepare();
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
