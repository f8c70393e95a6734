#include <occlude/hierarchy/bvh_builder.h>

#include <occlude/core/assert.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace occlude {

namespace {

// No decision below depends on the order of the primitives in their range: bins merge by min, max
// and whole-number sums, ties are broken by item id. So neither the number of threads nor the
// standard library's partition can show in the tree.

constexpr uint32_t kMaxBins = 32;
// Deeper than this, nodes are halved: no input can make the tree, or the recursion, deeper than
// kMaxSahDepth + 32.
constexpr uint32_t kMaxSahDepth = 64;
constexpr size_t kParallelBuild = 4096;    // items; smaller subtrees are built by one thread
constexpr size_t kParallelBinning = 65536; // items; smaller nodes are binned by one thread

// One item while building. 32 bytes.
struct Primitive {
    glm::vec3 min;
    uint32_t item;
    glm::vec3 max;
    uint32_t triangles;

    // Not Aabb::center(): the sum of two large corners may overflow.
    glm::vec3 center() const { return 0.5f * min + 0.5f * max; }
};
static_assert(sizeof(Primitive) == 32);
using Primitives = std::span<Primitive>;

struct Bin {
    Aabb box;
    uint64_t weight = 0; // triangles; an item without any counts as one
    uint64_t items = 0;

    void add(const Primitive& p)
    {
        box.min = glm::min(box.min, p.min);
        box.max = glm::max(box.max, p.max);
        weight += std::max(p.triangles, 1u);
        ++items;
    }
    void add(const Bin& other)
    {
        box.min = glm::min(box.min, other.box.min);
        box.max = glm::max(box.max, other.box.max);
        weight += other.weight;
        items += other.items;
    }
};

// What a box costs: its area, or its length where all boxes of the node lie on one line and no area
// could tell splits apart.
enum class Measure { area, length };

double measure_of(const Aabb& box, Measure measure)
{
    const glm::dvec3 e = glm::dvec3{box.max} - glm::dvec3{box.min};
    return measure == Measure::area ? e.x * e.y + e.y * e.z + e.z * e.x : e.x + e.y + e.z;
}

double cost(const Bin& bin, Measure measure)
{
    return bin.items > 0 ? measure_of(bin.box, measure) * static_cast<double>(bin.weight)
                         : Aabb::kInfinity; // such a split does not split
}

// Maps centres to bins, per axis. An axis on which all centres coincide, or whose extent is too
// small or too large for float, has scale 0: everything falls into bin 0.
struct Binning {
    glm::vec3 low;
    glm::vec3 scale{0.0f};
    uint32_t count;

    Binning(const Aabb& centers, uint32_t bin_count)
        : low(centers.min)
        , count(bin_count)
    {
        for (int axis = 0; axis < 3; ++axis) {
            const float extent = centers.max[axis] - centers.min[axis];
            const float s = static_cast<float>(bin_count) / extent;
            scale[axis] = extent > 0.0f && std::isfinite(s) && s > 0.0f ? s : 0.0f;
        }
    }

    uint32_t bin(const glm::vec3& center, int axis) const
    {
        if (scale[axis] == 0.0f) {
            return 0;
        }
        const float position = (center[axis] - low[axis]) * scale[axis];
        return std::min(static_cast<uint32_t>(position), count - 1);
    }
};

// Room for `capacity` bins per axis: most nodes are small, and clearing bins that they cannot fill
// would cost more than the rest.
template <size_t capacity>
struct Bins {
    std::array<std::array<Bin, capacity>, 3> bins; // [axis][bin]

    void add(Primitives primitives, const Binning& binning)
    {
        for (const Primitive& p : primitives) {
            const glm::vec3 center = p.center();
            for (int axis = 0; axis < 3; ++axis) {
                bins[static_cast<size_t>(axis)][binning.bin(center, axis)].add(p);
            }
        }
    }
    void add(const Bins& other, uint32_t count)
    {
        for (size_t axis = 0; axis < 3; ++axis) {
            for (uint32_t i = 0; i < count; ++i) {
                bins[axis][i].add(other.bins[axis][i]);
            }
        }
    }
};

struct Split {
    int axis = -1; // -1: none found
    uint32_t bin = 0;
};

class Builder {
public:
    Builder(std::vector<Node>& nodes, const BvhOptions& options)
        : nodes_(nodes)
        , max_leaf_items_(std::max(options.max_leaf_items, 1u))
        , bins_(std::clamp(options.bins, 2u, kMaxBins))
    {
    }

    // Builds the subtree of nodes_[node] over `primitives`, which begin at `first_item` of the
    // whole. Its descendants go to the slots from `free_slot` on, of which it needs at most
    // 2 * primitives.size() - 2: no two subtrees ever meet, whichever thread is first.
    void build(size_t node, size_t free_slot, Primitives primitives, size_t first_item,
               uint32_t depth)
    {
        Node& here = nodes_[node];
        here.first_item = static_cast<uint32_t>(first_item);
        if (primitives.size() <= max_leaf_items_) {
            make_leaf(here, primitives);
            return;
        }
        const size_t left_count = split(primitives, depth);
        const size_t left_slots = 2 * left_count - 2;
        here.first_child = NodeId{free_slot};
        here.child_count = 2;
        const auto build_left = [&] {
            build(free_slot, free_slot + 2, primitives.first(left_count), first_item, depth + 1);
        };
        const auto build_right = [&] {
            build(free_slot + 1, free_slot + 2 + left_slots, primitives.subspan(left_count),
                  first_item + left_count, depth + 1);
        };
        if (primitives.size() >= kParallelBuild) {
            tbb::parallel_invoke(build_left, build_right);
        } else {
            build_left();
            build_right();
        }
    }

    static void make_leaf(Node& node, Primitives primitives)
    {
        node.own_items = static_cast<uint32_t>(primitives.size());
        std::sort(primitives.begin(), primitives.end(),
                  [](const Primitive& a, const Primitive& b) { return a.item < b.item; });
    }

private:
    // Reorders `primitives` into two parts, neither empty, and returns the size of the first.
    size_t split(Primitives primitives, uint32_t depth) const
    {
        const Aabb centers = center_bounds(primitives);
        if (depth < kMaxSahDepth && primitives.size() > 2) {
            // More bins than items find nothing more.
            const auto few = static_cast<uint32_t>(std::min<size_t>(primitives.size(), bins_));
            const Binning binning(centers, few);
            const Split best = few <= 4    ? best_split<4>(primitives, binning)
                               : few <= 16 ? best_split<16>(primitives, binning)
                                           : best_split<kMaxBins>(primitives, binning);
            if (best.axis >= 0) {
                const auto middle =
                    std::partition(primitives.begin(), primitives.end(), [&](const Primitive& p) {
                        return binning.bin(p.center(), best.axis) < best.bin;
                    });
                return static_cast<size_t>(middle - primitives.begin());
            }
        }
        return halve(primitives, centers);
    }

    static Aabb center_bounds(Primitives primitives)
    {
        Aabb centers;
        for (const Primitive& p : primitives) {
            centers.min = glm::min(centers.min, p.center());
            centers.max = glm::max(centers.max, p.center());
        }
        return centers;
    }

    // The split between bins with the least area * triangles on both sides.
    template <size_t capacity>
    static Split best_split(Primitives primitives, const Binning& binning)
    {
        const auto all = fill_bins<capacity>(primitives, binning);
        Bin whole;
        for (uint32_t i = 0; i < binning.count; ++i) {
            whole.add(all.bins[0][i]);
        }
        const Measure measure =
            measure_of(whole.box, Measure::area) > 0.0 ? Measure::area : Measure::length;
        Split best;
        double best_cost = Aabb::kInfinity;
        for (int axis = 0; axis < 3; ++axis) {
            if (binning.scale[axis] == 0.0f) {
                continue;
            }
            const auto& bins = all.bins[static_cast<size_t>(axis)];
            std::array<double, capacity> right_cost;
            Bin right;
            for (uint32_t i = binning.count - 1; i > 0; --i) {
                right.add(bins[i]);
                right_cost[i] = cost(right, measure);
            }
            Bin left;
            for (uint32_t i = 1; i < binning.count; ++i) {
                left.add(bins[i - 1]);
                const double here = cost(left, measure) + right_cost[i];
                if (here < best_cost) {
                    best_cost = here;
                    best = {axis, i};
                }
            }
        }
        return best;
    }

    template <size_t capacity>
    static Bins<capacity> fill_bins(Primitives primitives, const Binning& binning)
    {
        using Filled = Bins<capacity>;
        if (primitives.size() < kParallelBinning) {
            Filled bins;
            bins.add(primitives, binning);
            return bins;
        }
        return tbb::parallel_reduce(
            tbb::blocked_range<size_t>(0, primitives.size(), kParallelBinning / 4), Filled{},
            [&](const tbb::blocked_range<size_t>& range, Filled bins) {
                bins.add(primitives.subspan(range.begin(), range.size()), binning);
                return bins;
            },
            [&](Filled a, const Filled& b) {
                a.add(b, binning.count);
                return a;
            });
    }

    // Halves at the median centre of the widest axis; equal centres by item id.
    static size_t halve(Primitives primitives, const Aabb& centers)
    {
        // Half extents, which cannot overflow.
        const glm::vec3 extent = 0.5f * centers.max - 0.5f * centers.min;
        int axis = extent.y > extent.x ? 1 : 0;
        axis = extent.z > extent[axis] ? 2 : axis;
        const size_t half = primitives.size() / 2;
        std::nth_element(primitives.begin(), primitives.begin() + static_cast<std::ptrdiff_t>(half),
                         primitives.end(), [axis](const Primitive& a, const Primitive& b) {
                             const float ca = a.center()[axis];
                             const float cb = b.center()[axis];
                             return ca != cb ? ca < cb : a.item < b.item;
                         });
        return half;
    }

    std::vector<Node>& nodes_;
    uint32_t max_leaf_items_;
    uint32_t bins_;
};

// Leaves of more than one item need fewer slots than were set aside: closes the gaps, in order.
void close_gaps(std::vector<Node>& nodes)
{
    std::vector<uint32_t> new_index(nodes.size(), 0);
    std::vector<bool> used(nodes.size(), false);
    used[0] = true;
    for (size_t i = 0; i < nodes.size(); ++i) {
        for (uint32_t c = 0; used[i] && c < nodes[i].child_count; ++c) {
            used[nodes[i].first_child.value + c] = true;
        }
    }
    uint32_t count = 0;
    for (size_t i = 0; i < nodes.size(); ++i) {
        new_index[i] = count;
        count += used[i] ? 1 : 0;
    }
    for (size_t i = 0; i < nodes.size(); ++i) {
        if (used[i]) {
            Node node = nodes[i];
            if (node.child_count > 0) {
                node.first_child = NodeId{new_index[node.first_child.value]};
            }
            nodes[new_index[i]] = node;
        }
    }
    nodes.resize(count);
}

// The items in three groups, in the order of their ids: bounded, unbounded, empty.
struct Groups {
    std::vector<Primitive> primitives;
    std::array<size_t, 3> sizes{};
};

Groups group(std::span<const ItemBounds> items)
{
    const auto kind = [](const Aabb& box) -> size_t {
        return box.is_bounded() ? 0 : box.is_empty() ? 2 : 1;
    };
    Groups groups;
    for (const ItemBounds& item : items) {
        ++groups.sizes[kind(item.box)];
    }
    std::array<size_t, 3> next{0, groups.sizes[0], groups.sizes[0] + groups.sizes[1]};
    groups.primitives.resize(items.size());
    for (size_t i = 0; i < items.size(); ++i) {
        const Aabb& box = items[i].box;
        groups.primitives[next[kind(box)]++] = {box.min, static_cast<uint32_t>(i), box.max,
                                                items[i].triangles};
    }
    return groups;
}

} // namespace

Hierarchy build_bvh(std::span<const ItemBounds> items, const BvhOptions& options)
{
    OCCLUDE_ASSERT(items.size() < ItemId::kInvalid / 2, "too many items for 32-bit node ids");
    if (items.empty()) {
        return Hierarchy::from_arrays({}, {}, {});
    }
    Groups groups = group(items);
    const Primitives primitives = groups.primitives;

    // One kind of boxes: the root is theirs. Otherwise each kind gets a child of the root.
    const auto kinds = static_cast<size_t>(
        std::count_if(groups.sizes.begin(), groups.sizes.end(), [](size_t n) { return n > 0; }));
    const size_t top = kinds > 1 ? 1 + kinds : 1;
    std::vector<Node> nodes(top + 2 * std::max<size_t>(groups.sizes[0], 1) - 2);
    if (kinds > 1) {
        nodes[0].first_child = NodeId{1u};
        nodes[0].child_count = static_cast<uint32_t>(kinds);
    }
    Builder builder(nodes, options);
    size_t node = kinds > 1 ? 1 : 0;
    size_t first_item = 0;
    for (size_t kind = 0; kind < groups.sizes.size(); ++kind) {
        const Primitives own = primitives.subspan(first_item, groups.sizes[kind]);
        if (own.empty()) {
            continue;
        }
        if (kind == 0) {
            builder.build(node, top, own, first_item, 0);
        } else {
            nodes[node].first_item = static_cast<uint32_t>(first_item);
            Builder::make_leaf(nodes[node], own);
        }
        ++node;
        first_item += own.size();
    }
    if (options.max_leaf_items > 1) {
        close_gaps(nodes);
    }

    std::vector<ItemId> order(items.size());
    std::vector<ItemBounds> bounds(items.size());
    tbb::parallel_for(size_t{0}, items.size(), [&](size_t i) {
        order[i] = ItemId{primitives[i].item};
        bounds[i] = {{primitives[i].min, primitives[i].max},
                     primitives[i].triangles,
                     items[primitives[i].item].flags};
    });
    Hierarchy hierarchy =
        Hierarchy::from_arrays(std::move(nodes), std::move(order), std::move(bounds));
    hierarchy.set_virtual_leaves(options.leaf_triangles);
    return hierarchy;
}

} // namespace occlude
