#include <occlude/hierarchy/builders/local_tree.h>

#include <occlude/hierarchy/detail/box_area.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace occlude {

using detail::box_area;

namespace {

struct LocalBuilder {
    std::span<const Aabb> boxes;
    LocalTree tree;
    std::vector<Aabb> from_right;

    static float middle(const Aabb& box, int axis)
    {
        return box.is_bounded() ? box.center()[axis] : 0.0f;
    }

    void sort_along(std::span<uint32_t> parts, int axis) const
    {
        std::sort(parts.begin(), parts.end(), [&](uint32_t a, uint32_t b) {
            const float at_a = middle(boxes[a], axis);
            const float at_b = middle(boxes[b], axis);
            return at_a != at_b ? at_a < at_b : a < b;
        });
    }

    // The cheapest way to divide parts, sorted by their middles, in two: the least sum of area
    // times parts. Divisions whose sides overlap along the axis come last, because the tree would
    // not be a BSP.
    std::pair<double, size_t> best_cut(std::span<const uint32_t> parts, int axis)
    {
        from_right.assign(parts.size() + 1, Aabb{});
        for (size_t i = parts.size(); i-- > 0;) {
            from_right[i] = merge(from_right[i + 1], boxes[parts[i]]);
        }
        std::pair<double, size_t> best{Aabb::kInfinity, parts.size() / 2};
        const double whole = box_area(from_right[0]) * static_cast<double>(parts.size());
        Aabb left;
        for (size_t cut = 1; cut < parts.size(); ++cut) {
            left = merge(left, boxes[parts[cut - 1]]);
            const Aabb& right = from_right[cut];
            const auto count = static_cast<double>(cut);
            const auto rest = static_cast<double>(parts.size() - cut);
            const bool overlap = left.max[axis] > right.min[axis];
            const double cost =
                box_area(left) * count + box_area(right) * rest + (overlap ? whole : 0.0);
            if (cost < best.first) {
                best = {cost, cut};
            }
        }
        return best;
    }

    void build(uint32_t node, std::span<uint32_t> parts)
    {
        for (const uint32_t part : parts) {
            tree.nodes[node].box = merge(tree.nodes[node].box, boxes[part]);
        }
        if (parts.size() == 1) {
            tree.nodes[node].part = parts[0];
            return;
        }
        double least = Aabb::kInfinity;
        int best_axis = 0;
        size_t cut = parts.size() / 2;
        for (int axis = 0; axis < 3; ++axis) {
            sort_along(parts, axis);
            const auto [cost, at] = best_cut(parts, axis);
            if (cost < least) {
                least = cost;
                best_axis = axis;
                cut = at;
            }
        }
        sort_along(parts, best_axis);
        const auto child = static_cast<uint32_t>(tree.nodes.size());
        tree.nodes[node].first_child = child;
        tree.nodes.resize(child + 2);
        build(child, parts.first(cut));
        build(child + 1, parts.subspan(cut));
    }
};

} // namespace

LocalTree build_local_tree(std::span<const Aabb> part_boxes)
{
    LocalBuilder builder{part_boxes, {}, {}};
    if (!part_boxes.empty()) {
        std::vector<uint32_t> parts(part_boxes.size());
        std::iota(parts.begin(), parts.end(), 0u);
        builder.tree.nodes.resize(1);
        builder.build(0, parts);
    }
    return std::move(builder.tree);
}

} // namespace occlude
