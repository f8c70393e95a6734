#include <occlude/hierarchy/builders/detail/sah_split.h>

#include <occlude/hierarchy/builders/detail/parallel.h>

#include <algorithm>
#include <cmath>

namespace occlude::detail {

namespace {

constexpr size_t kParallelBinning = 65536; // primitives; fewer are binned by one thread

struct Bin {
    Extent extent;
    int64_t weight = 0; // triangles; an item without any counts as one, so 0 is an empty bin

    void add(const Primitive& p)
    {
        extent.low = min4(extent.low, p.low);
        extent.high = max4(extent.high, p.high);
        weight += std::max(p.triangles(), 1u);
    }
    void add(const Bin& other)
    {
        extent.add(other.extent);
        weight += other.weight;
    }
};

// The weight of a box: its area, or its length if all boxes of the node lie on one line, where
// areas could not tell splits apart.
enum class Measure { area, length };

double measure_of(const Extent& extent, Measure measure)
{
    const double x = double{extent.high[0]} - double{extent.low[0]};
    const double y = double{extent.high[1]} - double{extent.low[1]};
    const double z = double{extent.high[2]} - double{extent.low[2]};
    return measure == Measure::area ? x * y + y * z + z * x : x + y + z;
}

double cost(const Bin& bin, Measure measure)
{
    return bin.weight > 0 ? measure_of(bin.extent, measure) * static_cast<double>(bin.weight)
                          : Aabb::kInfinity; // such a split leaves one side empty
}

// Maps centres to bins, per axis. An axis on which all centres coincide, or whose extent is too
// small or too large for float, has scale 0: everything falls into bin 0.
struct Binning {
    Float4 low;
    Float4 scale{};
    int32_t count;

    Binning(const Extent& centers, uint32_t bin_count)
        : low(centers.low)
        , count(static_cast<int32_t>(bin_count))
    {
        low[3] = 0.0f;
        for (int axis = 0; axis < 3; ++axis) {
            const float extent = centers.high[axis] - centers.low[axis];
            const float s = static_cast<float>(bin_count) / extent;
            scale[axis] = extent > 0.0f && std::isfinite(s) && s > 0.0f ? s : 0.0f;
        }
    }

    // Clamped on both sides: infinity times a scale of 0 converts to anything.
    Int4 bins(Float4 center) const
    {
        const Int4 bin = __builtin_convertvector((center - low) * scale, Int4);
        const Int4 last = Int4{} + (count - 1);
        const Int4 capped = bin < last ? bin : last;
        return capped & (capped > -1);
    }
};

// Reserves `capacity` bins per axis: most nodes are small, and clearing bins that they cannot fill
// would cost more than all other work.
template <size_t capacity>
struct Bins {
    std::array<std::array<Bin, capacity>, 3> bins; // [axis][bin]

    void add(std::span<const Primitive> primitives, const Binning& binning)
    {
        for (const Primitive& p : primitives) {
            const Int4 at = binning.bins(p.center());
            for (int axis = 0; axis < 3; ++axis) {
                bins[static_cast<size_t>(axis)][static_cast<size_t>(at[axis])].add(p);
            }
        }
    }
    void add(const Bins& other)
    {
        for (size_t axis = 0; axis < 3; ++axis) {
            for (size_t i = 0; i < capacity; ++i) {
                bins[axis][i].add(other.bins[axis][i]);
            }
        }
    }
};

struct Border {
    int axis = -1; // -1: none found
    int32_t bin = 0;
};

template <size_t capacity>
Bins<capacity> fill_bins(std::span<const Primitive> primitives, const Binning& binning,
                         TaskRunner& tasks)
{
    using Filled = Bins<capacity>;
    const auto fill = [&](size_t begin, size_t end) {
        Filled bins;
        bins.add(primitives.subspan(begin, end - begin), binning);
        return bins;
    };
    if (primitives.size() < kParallelBinning) {
        return fill(0, primitives.size());
    }
    return map_and_join<Filled>(tasks, 0, primitives.size(), kParallelBinning / 4, fill,
                                [](Filled a, const Filled& b) {
                                    a.add(b);
                                    return a;
                                });
}

// The border between bins with the least area * triangles on both sides.
template <size_t capacity>
Border best_border(std::span<const Primitive> primitives, const Binning& binning, TaskRunner& tasks)
{
    const auto all = fill_bins<capacity>(primitives, binning, tasks);
    const auto count = static_cast<size_t>(binning.count);
    Bin whole;
    for (size_t i = 0; i < count; ++i) {
        whole.add(all.bins[0][i]);
    }
    const Measure measure =
        measure_of(whole.extent, Measure::area) > 0.0 ? Measure::area : Measure::length;
    Border best;
    double best_cost = Aabb::kInfinity;
    for (int axis = 0; axis < 3; ++axis) {
        if (binning.scale[axis] == 0.0f) {
            continue;
        }
        const auto& bins = all.bins[static_cast<size_t>(axis)];
        std::array<double, capacity> right_cost;
        Bin right;
        for (size_t i = count - 1; i > 0; --i) {
            right.add(bins[i]);
            right_cost[i] = cost(right, measure);
        }
        Bin left;
        for (size_t i = 1; i < count; ++i) {
            left.add(bins[i - 1]);
            const double here = cost(left, measure) + right_cost[i];
            if (here < best_cost) {
                best_cost = here;
                best = {axis, static_cast<int32_t>(i)};
            }
        }
    }
    return best;
}

// All lanes of the result say whether the centre lies before the border.
template <int axis>
Int4 is_left(Float4 center, const Binning& binning, const Border& border)
{
    const Int4 left = binning.bins(center) < Int4{} + border.bin;
    return Int4{} + left[axis];
}

// Writes each item to both ends of `to` and advances only the right end. Centres of the other side
// become NaN, which min4 and max4 ignore. So there is no branch to mispredict.
template <int axis>
Parts distribute(std::span<const Primitive> from, std::span<Primitive> to, const Binning& binning,
                 const Border& border)
{
    const auto nan_where = [](Int4 mask, Float4 v) {
        return std::bit_cast<Float4>(mask | std::bit_cast<Int4>(v));
    };
    Parts parts;
    size_t right = from.size();
    for (const Primitive& p : from) {
        const Float4 center = p.center();
        const Int4 left = is_left<axis>(center, binning, border);
        to[parts.left] = p;
        to[right - 1] = p;
        parts.left += static_cast<size_t>(-left[0]);
        right -= static_cast<size_t>(1 + left[0]);
        parts.left_centers.add(nan_where(~left, center));
        parts.right_centers.add(nan_where(left, center));
    }
    return parts;
}

// Halves at the median centre of the widest axis; equal centres by item id.
Parts halve_at_median(std::span<Primitive> from, std::span<Primitive> to, const Extent& centers)
{
    // Half extents, which cannot overflow.
    const Float4 extent = 0.5f * centers.high - 0.5f * centers.low;
    int axis = extent[1] > extent[0] ? 1 : 0;
    axis = extent[2] > extent[axis] ? 2 : axis;
    const auto before = [axis](const Primitive& a, const Primitive& b) {
        const float ca = a.center(axis);
        const float cb = b.center(axis);
        return ca != cb ? ca < cb : a.item() < b.item();
    };
    if (from.size() == 2) { // half of all nodes, where leaves have one item
        const bool swapped = before(from[1], from[0]);
        to[0] = from[swapped ? 1 : 0];
        to[1] = from[swapped ? 0 : 1];
        return {1, {}, {}}; // nobody reads the centre of a single item
    }
    const size_t half = from.size() / 2;
    std::nth_element(from.begin(), from.begin() + static_cast<std::ptrdiff_t>(half), from.end(),
                     before);
    std::copy(from.begin(), from.end(), to.begin());
    return {half, centers_of(to.first(half)), centers_of(to.subspan(half))};
}

} // namespace

Extent centers_of(std::span<const Primitive> primitives)
{
    Extent centers;
    for (const Primitive& p : primitives) {
        centers.add(p.center());
    }
    return centers;
}

Parts part(std::span<Primitive> from, std::span<Primitive> to, const Extent& centers, uint32_t bins,
           bool halve, TaskRunner& tasks)
{
    if (!halve && from.size() > 2) {
        // More bins than items find no better split.
        const auto few = static_cast<uint32_t>(std::min<size_t>(from.size(), bins));
        const Binning binning(centers, few);
        const Border best = few <= 4    ? best_border<4>(from, binning, tasks)
                            : few <= 8  ? best_border<8>(from, binning, tasks)
                            : few <= 16 ? best_border<16>(from, binning, tasks)
                                        : best_border<kMaxBins>(from, binning, tasks);
        if (best.axis >= 0) {
            return best.axis == 0   ? distribute<0>(from, to, binning, best)
                   : best.axis == 1 ? distribute<1>(from, to, binning, best)
                                    : distribute<2>(from, to, binning, best);
        }
    }
    return halve_at_median(from, to, centers);
}

} // namespace occlude::detail
