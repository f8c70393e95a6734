#include <occlude/hierarchy/builders/octree_builder.h>

#include <occlude/hierarchy/builders/cell_tree.h>

#include <algorithm>
#include <bit>

namespace occlude {

namespace {

constexpr uint32_t kMaxDepth = 21; // three bits a level in 64-bit codes

// Spreads the low 21 bits of x, two zeros after each.
uint64_t spread_bits(uint64_t x)
{
    x &= 0x1fffff;
    x = (x | x << 32) & 0x001f00000000ffff;
    x = (x | x << 16) & 0x001f0000ff0000ff;
    x = (x | x << 8) & 0x100f00f00f00f00f;
    x = (x | x << 4) & 0x10c30c30c30c30c3;
    x = (x | x << 2) & 0x1249249249249249;
    return x;
}

// The octants of a point from the root down, three bits for each level.
uint64_t morton_code(const glm::dvec3& center, const glm::dvec3& low, double cube_size)
{
    uint64_t code = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double position = cube_size > 0.0 ? (center[axis] - low[axis]) / cube_size : 0.0;
        const double cells = position * static_cast<double>(1u << kMaxDepth);
        const auto cell = static_cast<uint64_t>(std::clamp(cells, 0.0, 0x1fffff * 1.0));
        code |= spread_bits(cell) << axis;
    }
    return code;
}

class Builder {
public:
    CellTree tree;

    Builder(std::span<const ItemBounds> items, const OctreeOptions& options)
        : tree(items)
        , items_(items)
        , max_leaf_items_(std::max(options.max_leaf_items, 1u))
        , max_depth_(std::min(options.max_depth, kMaxDepth))
    {
        sort_by_code();
    }

    // Builds nodes[node] over the items [first, end) of the order.
    void build(size_t node, size_t first, size_t end)
    {
        const uint64_t differing = codes_[first] ^ codes_[end - 1];
        if (end - first <= max_leaf_items_ || differing == 0) {
            tree.make_leaf(node, first, end);
            return;
        }
        // The first level with more than one occupied octant; the levels above it get no node.
        const auto digit = static_cast<uint32_t>(std::bit_width(differing) - 1) / 3;
        std::vector<size_t> starts;
        for (size_t i = first; i < end; ++i) {
            if (i == first || codes_[i] >> (3 * digit) != codes_[i - 1] >> (3 * digit)) {
                starts.push_back(i);
            }
        }
        size_t child = tree.add_children(node, first, starts.size());
        starts.push_back(end);
        for (size_t c = 0; c + 1 < starts.size(); ++c) {
            build(child++, starts[c], starts[c + 1]);
        }
    }

private:
    void sort_by_code()
    {
        Aabb centers;
        for (size_t i = tree.odd_items; i < tree.order.size(); ++i) {
            const glm::vec3 center = items_[tree.order[i]].box.center();
            centers = merge(centers, {center, center});
        }
        const glm::dvec3 low{centers.min};
        const glm::dvec3 extent = glm::dvec3{centers.max} - low;
        const double cube_size = std::max({extent.x, extent.y, extent.z});

        std::vector<std::pair<uint64_t, uint32_t>> sorted; // code, item
        for (size_t i = tree.odd_items; i < tree.order.size(); ++i) {
            const glm::dvec3 center{items_[tree.order[i]].box.center()};
            const uint32_t unused_digits = kMaxDepth - max_depth_;
            const uint64_t code = morton_code(center, low, cube_size) >> (3 * unused_digits);
            sorted.emplace_back(code, tree.order[i]);
        }
        std::sort(sorted.begin(), sorted.end());
        codes_.assign(tree.odd_items, 0);
        for (size_t i = 0; i < sorted.size(); ++i) {
            codes_.push_back(sorted[i].first);
            tree.order[tree.odd_items + i] = sorted[i].second;
        }
    }

    std::span<const ItemBounds> items_;
    uint32_t max_leaf_items_;
    uint32_t max_depth_;
    std::vector<uint64_t> codes_; // of tree.order, ascending
};

} // namespace

Hierarchy build_octree(std::span<const ItemBounds> items, const OctreeOptions& options)
{
    if (items.empty()) {
        return Hierarchy::from_arrays({}, {}, {});
    }
    Builder builder(items, options);
    if (builder.tree.odd_items < items.size()) {
        builder.build(builder.tree.top, builder.tree.odd_items, items.size());
    }
    return builder.tree.finish(items, options.leaf_triangles);
}

} // namespace occlude
