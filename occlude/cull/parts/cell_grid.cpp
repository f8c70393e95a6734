#include <occlude/cull/parts/cell_grid.h>

#include <glm/common.hpp>

#include <algorithm>
#include <cmath>

namespace occlude {

namespace {

// Overlaps allowed per item. Enough for items that mostly lie apart: an item of a cell's size
// overlaps eight cells.
constexpr uint64_t kOverlapsPerItem = 32;
constexpr uint64_t kLeastOverlapBudget = 1 << 16; // 0.5 MiB, so that small scenes are not limited

} // namespace

bool CellGrid::is_current(const Hierarchy& hierarchy) const
{
    return structure_ == hierarchy.structure_version() &&
           std::ranges::equal(bounds_, hierarchy.item_bounds(),
                              [](const ItemBounds& a, const ItemBounds& b) {
                                  return a.box == b.box && a.triangles == b.triangles;
                              });
}

void CellGrid::find_owners(const Hierarchy& hierarchy)
{
    owners_.assign(hierarchy.items().size(), NodeId{});
    for (size_t n = 0; n < hierarchy.nodes().size(); ++n) {
        const Node& node = hierarchy.nodes()[n];
        std::fill_n(owners_.begin() + node.first_item, node.own_items, NodeId{n});
    }
}

// The part of `box` that lies in a cell, rounded outward by a millionth of the cell. The outermost
// cells reach as far as the items do.
static Aabb part_in_cell(const Aabb& box, const Lattice& lattice, const glm::uvec3& at)
{
    constexpr double kSlop = 1e-6;
    Aabb part = box;
    for (int axis = 0; axis < 3; ++axis) {
        const double size = lattice.cell_size[axis];
        const double low = lattice.low[axis] + size * (at[axis] - kSlop);
        const double high = lattice.low[axis] + size * (at[axis] + 1.0 + kSlop);
        if (at[axis] > 0) {
            const float rounded = std::nextafter(static_cast<float>(low), -Aabb::kInfinity);
            part.min[axis] = std::max(part.min[axis], std::min(rounded, part.max[axis]));
        }
        if (at[axis] + 1 < lattice.count[axis]) {
            const float rounded = std::nextafter(static_cast<float>(high), Aabb::kInfinity);
            part.max[axis] = std::min(part.max[axis], std::max(rounded, part.min[axis]));
        }
    }
    return part;
}

static Aabb intersection(const Aabb& a, const Aabb& b)
{
    return {glm::max(a.min, b.min), glm::min(a.max, b.max)};
}

// Makes one cell from `overlaps`, which all name this cell.
CellGrid::Cell CellGrid::make_cell(std::span<const Overlap> overlaps, const Lattice& lattice,
                                   const Aabb& region)
{
    Cell cell;
    cell.at = lattice.at(overlaps.front().first);
    cell.first = static_cast<uint32_t>(items_.size());
    cell.count = static_cast<uint32_t>(overlaps.size());
    for (const auto& [same_index, item_at] : overlaps) {
        const ItemBounds& item = bounds_[item_at.value];
        cell.box = merge(cell.box, part_in_cell(intersection(item.box, region), lattice, cell.at));
        cell.triangles += item.triangles;
        items_.push_back(item_at);
    }
    return cell;
}

// The number of (item, overlapped cell) pairs in a lattice. O(items).
uint64_t CellGrid::count_overlaps(std::span<const ItemPosition> items, const Aabb& region,
                                  const Lattice& lattice) const
{
    uint64_t count = 0;
    for (const ItemPosition item : items) {
        const Aabb part = intersection(bounds_[item.value].box, region);
        const glm::uvec3 cells = lattice.cell(part.max) - lattice.cell(part.min) + 1u;
        count += uint64_t{cells.x} * cells.y * cells.z;
    }
    return count;
}

// The finest lattice of at most `cells` cells whose overlaps the budget allows. Items that overlap
// one another overlap most cells, too: without a budget, nested grids over n such items would have
// n^3 overlaps.
Lattice CellGrid::choose_lattice(std::span<const ItemPosition> items, const Aabb& region,
                                 uint64_t cells) const
{
    Lattice lattice = Lattice::over(region, cells);
    while (cells > 1 && count_overlaps(items, region, lattice) > overlap_budget_) {
        cells /= 2;
        lattice = Lattice::over(region, cells);
    }
    return lattice;
}

// Makes a grid over the parts of the items in `region`, and the grids nested in it.
uint32_t CellGrid::build_grid(const std::vector<ItemPosition>& items, const Aabb& region,
                              const CellGridOptions& options, uint32_t level)
{
    uint64_t triangles = 0;
    for (const ItemPosition item : items) {
        triangles += bounds_[item.value].triangles;
    }
    const uint64_t cell_triangles = std::max<uint64_t>(options.cell_triangles, 1);
    const uint64_t cells =
        std::clamp<uint64_t>(triangles / cell_triangles, 1, std::max<size_t>(items.size(), 1));
    const Lattice lattice = choose_lattice(items, region, cells);

    std::vector<Overlap> overlaps;
    for (const ItemPosition item : items) {
        const Aabb part = intersection(bounds_[item.value].box, region);
        const glm::uvec3 low = lattice.cell(part.min);
        const glm::uvec3 high = lattice.cell(part.max);
        for (uint32_t z = low.z; z <= high.z; ++z) {
            for (uint32_t y = low.y; y <= high.y; ++y) {
                for (uint32_t x = low.x; x <= high.x; ++x) {
                    overlaps.emplace_back(lattice.index({x, y, z}), item);
                }
            }
        }
    }
    overlap_budget_ -= std::min<uint64_t>(overlap_budget_, overlaps.size());
    std::sort(overlaps.begin(), overlaps.end());

    const auto grid = static_cast<uint32_t>(grids_.size());
    grids_.push_back({lattice, static_cast<uint32_t>(cells_.size()), 0});
    for (size_t begin = 0, end = 0; begin < overlaps.size(); begin = end) {
        while (end < overlaps.size() && overlaps[end].first == overlaps[begin].first) {
            ++end;
        }
        cells_.push_back(
            make_cell(std::span{overlaps}.subspan(begin, end - begin), lattice, region));
        ++grids_[grid].cell_count;
    }
    const uint32_t cells_end = static_cast<uint32_t>(cells_.size());
    for (uint32_t c = grids_[grid].first_cell; c < cells_end && level < options.nested_levels;
         ++c) {
        const Cell cell = cells_[c]; // a copy, because cells_ grows
        const bool crowded = cell.count > 1 && cell.triangles / 2 > cell_triangles;
        if (crowded && overlap_budget_ >= 2 * uint64_t{cell.count}) {
            const std::vector<ItemPosition> own(items_.begin() + cell.first,
                                                items_.begin() + cell.first + cell.count);
            const uint32_t nested = build_grid(own, cell.box, options, level + 1);
            cells_[c].grid = nested;
        }
    }
    return grid;
}

void CellGrid::update(const Hierarchy& hierarchy, const CellGridOptions& options)
{
    if (is_current(hierarchy)) {
        return;
    }
    structure_ = hierarchy.structure_version();
    bounds_.assign(hierarchy.item_bounds().begin(), hierarchy.item_bounds().end());
    find_owners(hierarchy);
    grids_.clear();
    cells_.clear();
    items_.clear();
    unbounded_.clear();

    Aabb region;
    std::vector<ItemPosition> bounded;
    for (size_t i = 0; i < bounds_.size(); ++i) {
        const Aabb& box = bounds_[i].box;
        if (box.is_bounded()) {
            bounded.push_back(ItemPosition{i});
            region = merge(region, box);
        } else if (!box.is_empty()) {
            unbounded_.push_back(ItemPosition{i});
        }
    }
    overlap_budget_ = std::max(kOverlapsPerItem * uint64_t{bounded.size()}, kLeastOverlapBudget);
    if (!bounded.empty()) {
        build_grid(bounded, region, options, 0);
    }
}

} // namespace occlude
