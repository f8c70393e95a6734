#include <occlude/hierarchy/builders/grid_builder.h>

#include <occlude/hierarchy/builders/cell_tree.h>
#include <occlude/hierarchy/lattice.h>

#include <algorithm>
#include <utility>

namespace occlude {

namespace {

constexpr uint32_t kMaxDepth = 32;

class Builder {
public:
    CellTree tree;

    Builder(std::span<const ItemBounds> items, const GridOptions& options)
        : tree(items)
        , items_(items)
        , options_(options)
    {
    }

    // Builds nodes[node] over the items [first, end) of the order.
    void build(size_t node, size_t first, size_t end, uint32_t depth)
    {
        const size_t count = end - first;
        if (count <= std::max(options_.max_leaf_items, 1u) ||
            depth >= std::min(options_.max_depth, kMaxDepth)) {
            tree.make_leaf(node, first, end);
            return;
        }
        const std::vector<size_t> starts = sort_into_cells(first, end);
        const size_t cells = starts.size() - 1;
        if (cells == 1) { // all centres in one place
            tree.make_leaf(node, first, end);
            return;
        }
        const size_t child = tree.add_children(node, first, cells);
        for (size_t c = 0; c < cells; ++c) {
            build(child + c, starts[c], starts[c + 1], depth + 1);
        }
    }

private:
    // Orders the items by cell, then by id. Returns where each occupied cell starts, and the end.
    std::vector<size_t> sort_into_cells(size_t first, size_t end)
    {
        Aabb centers;
        for (size_t i = first; i < end; ++i) {
            const glm::vec3 center = items_[tree.order[i]].box.center();
            centers = merge(centers, {center, center});
        }
        const uint64_t cells = (end - first) / std::max(options_.items_per_cell, 1u);
        const Lattice lattice = Lattice::over(centers, std::max<uint64_t>(cells, 2));
        std::vector<std::pair<uint64_t, uint32_t>> sorted; // cell, item
        for (size_t i = first; i < end; ++i) {
            const uint32_t item = tree.order[i];
            sorted.emplace_back(lattice.index(lattice.cell(items_[item].box.center())), item);
        }
        std::sort(sorted.begin(), sorted.end());
        std::vector<size_t> starts;
        for (size_t i = 0; i < sorted.size(); ++i) {
            tree.order[first + i] = sorted[i].second;
            if (i == 0 || sorted[i].first != sorted[i - 1].first) {
                starts.push_back(first + i);
            }
        }
        starts.push_back(end);
        return starts;
    }

    std::span<const ItemBounds> items_;
    GridOptions options_;
};

} // namespace

Hierarchy build_grid(std::span<const ItemBounds> items, const GridOptions& options)
{
    if (items.empty()) {
        return Hierarchy::from_arrays({}, {}, {});
    }
    Builder builder(items, options);
    if (builder.tree.odd_items < items.size()) {
        builder.build(builder.tree.top, builder.tree.odd_items, items.size(), 0);
    }
    return builder.tree.finish(items, options.leaf_triangles);
}

} // namespace occlude
