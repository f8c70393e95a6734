#include <occlude/hierarchy/builders/bsp_builder.h>

#include <occlude/core/assert.h>

#include <algorithm>
#include <array>
#include <numeric>

namespace occlude {

namespace {

// No decision below depends on the order of the items in their range: sides merge by min, max and
// whole-number sums, and own items are sorted by id.

using Order = std::span<uint32_t>; // item ids

constexpr uint32_t kMaxDepth = 64;
constexpr size_t kMaxPlanes = 32; // candidates per axis

// Items on one side of a plane.
struct Side {
    Aabb box;
    uint64_t weight = 0; // triangles; an item without any counts as one
    size_t items = 0;

    void add(const ItemBounds& item)
    {
        box = merge(box, item.box);
        weight += std::max(item.triangles, 1u);
        ++items;
    }
    void add(const Side& other)
    {
        box = merge(box, other.box);
        weight += other.weight;
        items += other.items;
    }
};

// The weight of a box: its area, or its length if the boxes of a node lie on one line.
enum class Measure { area, length };

double measure_of(const Aabb& box, Measure measure)
{
    if (box.is_empty()) {
        return 0.0;
    }
    const glm::dvec3 e = glm::dvec3{box.max} - glm::dvec3{box.min};
    return measure == Measure::area ? e.x * e.y + e.y * e.z + e.z * e.x : e.x + e.y + e.z;
}

// Ascending, without duplicates.
struct Planes {
    std::array<float, kMaxPlanes> at;
    size_t count = 0;

    void add(float plane) { at[count++] = plane; }
    void sort_and_unite()
    {
        std::sort(at.begin(), at.begin() + count);
        count = static_cast<size_t>(std::unique(at.begin(), at.begin() + count) - at.begin());
    }
    // The first plane at or above `x`, or `count`.
    size_t first_from(float x) const
    {
        return static_cast<size_t>(std::lower_bound(at.begin(), at.begin() + count, x) -
                                   at.begin());
    }
    // The number of planes at or below `x`.
    size_t count_up_to(float x) const
    {
        return static_cast<size_t>(std::upper_bound(at.begin(), at.begin() + count, x) -
                                   at.begin());
    }
};

// The side of a plane that a box is on. A flat box in the plane is below.
bool is_below(const Aabb& box, int axis, float plane)
{
    return box.max[axis] <= plane;
}
bool is_above(const Aabb& box, int axis, float plane)
{
    return box.min[axis] >= plane && !is_below(box, axis, plane);
}

struct Cut {
    int axis = -1; // -1: none found
    float plane = 0.0f;
    double cost = Aabb::kInfinity;
};

class Builder {
public:
    Builder(std::span<const ItemBounds> items, const BspOptions& options)
        : items_(items)
        , options_(options)
        , max_leaf_items_(std::max(options.max_leaf_items, 1u))
        , max_depth_(std::min(options.max_depth, kMaxDepth))
    {
    }

    std::vector<Node>& nodes() { return nodes_; }

    // Builds the subtree of nodes_[node] over `order`, which begins at `first_item` of the whole.
    void build(size_t node, Order order, size_t first_item, uint32_t depth)
    {
        nodes_[node].first_item = static_cast<uint32_t>(first_item);
        const Cut cut =
            depth < max_depth_ && order.size() > max_leaf_items_ ? find_cut(order) : Cut{};
        if (cut.axis < 0) {
            keep(node, order);
            return;
        }
        // [ straddling | below | above ]
        const auto box_of = [this](uint32_t item) -> const Aabb& { return items_[item].box; };
        const auto below = std::partition(order.begin(), order.end(), [&](uint32_t item) {
            return !is_below(box_of(item), cut.axis, cut.plane) &&
                   !is_above(box_of(item), cut.axis, cut.plane);
        });
        const auto above = std::partition(below, order.end(), [&](uint32_t item) {
            return is_below(box_of(item), cut.axis, cut.plane);
        });
        std::array<Order, 3> parts{Order{order.begin(), below}, Order{below, above},
                                   Order{above, order.end()}};
        if (options_.straddling == BspOptions::Straddling::own) {
            keep(node, parts[0]);
            parts[0] = {};
        }
        size_t child = nodes_.size();
        nodes_[node].first_child = NodeId{child};
        nodes_[node].child_count = static_cast<uint32_t>(
            std::ranges::count_if(parts, [](Order part) { return !part.empty(); }));
        nodes_.resize(child + nodes_[node].child_count);
        for (const Order part : parts) {
            if (!part.empty()) {
                const auto before = static_cast<size_t>(part.data() - order.data());
                build(child++, part, first_item + before, depth + 1);
            }
        }
    }

    // Makes `own` the own items of a node.
    void keep(size_t node, Order own)
    {
        nodes_[node].own_items = static_cast<uint32_t>(own.size());
        std::sort(own.begin(), own.end());
    }

private:
    // The plane of a node; none if no candidate separates anything.
    Cut find_cut(Order order) const
    {
        Side all;
        for (const uint32_t item : order) {
            all.add(items_[item]);
        }
        const glm::dvec3 e = glm::dvec3{all.box.max} - glm::dvec3{all.box.min};
        std::array<int, 3> axes{0, 1, 2}; // the longest first
        std::stable_sort(axes.begin(), axes.end(), [&](int a, int b) { return e[a] > e[b]; });
        Cut best;
        for (const int axis : axes) {
            const Cut cut = best_of(candidates(order, all.box, axis), order, all, axis);
            if (cut.axis >= 0 && cut.cost < best.cost) {
                best = cut;
            }
            if (best.axis >= 0 && options_.split != BspOptions::Split::cost) {
                break;
            }
        }
        return best;
    }

    Planes candidates(Order order, const Aabb& box, int axis) const
    {
        const double low = box.min[axis];
        const double extent = box.max[axis] - low;
        Planes planes;
        if (options_.split == BspOptions::Split::middle) {
            planes.add(static_cast<float>(low + 0.5 * extent));
        } else if (options_.split == BspOptions::Split::median) {
            planes.add(median_face(order, axis));
        } else if (order.size() <= kMaxPlanes) {
            // The upper face of each item. For few items, these planes are enough.
            for (const uint32_t item : order) {
                planes.add(items_[item].box.max[axis]);
            }
        } else {
            for (size_t i = 1; i <= kMaxPlanes; ++i) {
                const double t = static_cast<double>(i) / (kMaxPlanes + 1);
                planes.add(static_cast<float>(low + t * extent));
            }
        }
        planes.sort_and_unite();
        return planes;
    }

    // Reorders `order`. Takes the face, not the centre, so that the median item does not straddle
    // the plane.
    float median_face(Order order, int axis) const
    {
        const auto middle = order.begin() + static_cast<std::ptrdiff_t>((order.size() - 1) / 2);
        const auto face = [&](uint32_t item) { return items_[item].box.max[axis]; };
        std::nth_element(order.begin(), middle, order.end(),
                         [&](uint32_t a, uint32_t b) { return face(a) < face(b); });
        return face(*middle);
    }

    // The cheapest of the planes that leave fewer items on each side than the node has.
    Cut best_of(const Planes& planes, Order order, const Side& all, int axis) const
    {
        // ends[i]: items below plane i but not i-1; starts[i]: above plane i but not i+1.
        std::array<Side, kMaxPlanes> ends;
        std::array<Side, kMaxPlanes> starts;
        for (const uint32_t item : order) {
            const Aabb& box = items_[item].box;
            const size_t end = planes.first_from(box.max[axis]);
            const size_t start = std::min(planes.count_up_to(box.min[axis]), end);
            if (end < planes.count) {
                ends[end].add(items_[item]);
            }
            if (start > 0) {
                starts[start - 1].add(items_[item]);
            }
        }
        for (size_t i = planes.count; i-- > 1;) {
            starts[i - 1].add(starts[i]);
        }
        const bool is_flat = measure_of(all.box, Measure::area) <= 0.0;
        const Measure measure = is_flat ? Measure::length : Measure::area;
        Cut best;
        Side below;
        for (size_t i = 0; i < planes.count; ++i) {
            below.add(ends[i]);
            const Side& above = starts[i];
            if (below.items + above.items == 0 || below.items == all.items ||
                above.items == all.items) {
                continue;
            }
            const uint64_t straddling = all.weight - below.weight - above.weight;
            const double cost = measure_of(below.box, measure) * static_cast<double>(below.weight) +
                                measure_of(above.box, measure) * static_cast<double>(above.weight) +
                                measure_of(all.box, measure) * static_cast<double>(straddling);
            if (cost < best.cost) {
                best = {axis, planes.at[i], cost};
            }
        }
        return best;
    }

    std::span<const ItemBounds> items_;
    BspOptions options_;
    uint32_t max_leaf_items_;
    uint32_t max_depth_;
    std::vector<Node> nodes_;
};

} // namespace

Hierarchy build_bsp(std::span<const ItemBounds> items, const BspOptions& options)
{
    OCCLUDE_ASSERT(items.size() < ItemId::kInvalid / 2, "too many items for 32-bit node ids");
    if (items.empty()) {
        return Hierarchy::from_arrays({}, {}, {});
    }
    std::vector<uint32_t> order(items.size());
    std::iota(order.begin(), order.end(), 0u);
    // No plane can separate an unbounded or an empty box from anything.
    const auto bounded = std::stable_partition(
        order.begin(), order.end(), [&](uint32_t item) { return !items[item].box.is_bounded(); });
    const auto odd_count = static_cast<size_t>(bounded - order.begin());

    Builder builder(items, options);
    builder.nodes().resize(1);
    if (odd_count == 0) {
        builder.build(0, order, 0, 0);
    } else {
        builder.keep(0, Order{order}.first(odd_count));
        if (bounded != order.end()) {
            builder.nodes()[0].first_child = NodeId{1u};
            builder.nodes()[0].child_count = 1;
            builder.nodes().resize(2);
            builder.build(1, Order{order}.subspan(odd_count), odd_count, 1);
        }
    }

    std::vector<ItemId> ids(items.size());
    std::vector<ItemBounds> bounds(items.size());
    for (size_t i = 0; i < items.size(); ++i) {
        ids[i] = ItemId{order[i]};
        bounds[i] = items[order[i]];
    }
    Hierarchy hierarchy =
        Hierarchy::from_arrays(std::move(builder.nodes()), std::move(ids), std::move(bounds));
    hierarchy.set_virtual_leaves(options.leaf_triangles);
    return hierarchy;
}

} // namespace occlude
