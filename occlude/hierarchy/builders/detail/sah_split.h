// The step that BVH builders repeat: divides boxes in two at the least binned surface area
// heuristic. Internal: builders include it, users do not.
//
// No decision depends on the order of the primitives: bins merge by min, max and whole-number sums,
// and ties are broken by item id. So the tree does not depend on the number of threads.
#pragma once

#include <occlude/core/detail/float4.h>
#include <occlude/hierarchy/builders/task_runner.h>
#include <occlude/hierarchy/hierarchy.h>

#include <array>
#include <bit>
#include <cstdint>
#include <span>

namespace occlude::detail {

/// A growing box, in lanes 0 to 2; lane 3 is not used.
struct Extent {
    Float4 low{Aabb::kInfinity, Aabb::kInfinity, Aabb::kInfinity, 0.0f};
    Float4 high{-Aabb::kInfinity, -Aabb::kInfinity, -Aabb::kInfinity, 0.0f};

    void add(Float4 point)
    {
        low = min4(low, point);
        high = max4(high, point);
    }
    void add(const Extent& other)
    {
        low = min4(low, other.low);
        high = max4(high, other.high);
    }
    Aabb box() const { return {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}}; }
};

/// A bounded item during the build: its box in lanes 0 to 2, and whole numbers in lane 3.
struct Primitive {
    Float4 low;  ///< lane 3: the item
    Float4 high; ///< lane 3: its triangles

    static Primitive of(uint32_t item, const Aabb& box, uint32_t triangles)
    {
        return {Float4{box.min.x, box.min.y, box.min.z, std::bit_cast<float>(item)},
                Float4{box.max.x, box.max.y, box.max.z, std::bit_cast<float>(triangles)}};
    }
    uint32_t item() const { return std::bit_cast<std::array<uint32_t, 4>>(low)[3]; }
    uint32_t triangles() const { return std::bit_cast<std::array<uint32_t, 4>>(high)[3]; }
    Aabb box() const { return {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}}; }

    /// Halves before adding, because the sum of two large corners may overflow. Lane 3 is 0.
    Float4 center() const
    {
        constexpr Int4 kCorner{-1, -1, -1, 0};
        const auto corner = [&](Float4 v) {
            return std::bit_cast<Float4>(std::bit_cast<Int4>(v) & kCorner);
        };
        return 0.5f * corner(low) + 0.5f * corner(high);
    }
    /// The same on one axis.
    float center(int axis) const { return 0.5f * low[axis] + 0.5f * high[axis]; }
};
static_assert(sizeof(Primitive) == 32);

/// The box around the centres.
Extent centers_of(std::span<const Primitive> primitives);

/// The two parts of some primitives, neither empty.
struct Parts {
    size_t left = 0; ///< how many items go to the left part; they come first
    Extent left_centers;
    Extent right_centers;
};

/// Divides `from`, which has at least two primitives, into `to`, which is as long and does not
/// overlap it; `from` is scratch memory afterwards. `centers` is centers_of(from). Of at most
/// kMaxBins `bins` per axis, it chooses the border with the least area * triangles on both sides;
/// an item without triangles counts as one. If all centres coincide, or `halve` is set, it chooses
/// the median of the widest axis. `tasks` bins large inputs in parallel.
inline constexpr uint32_t kMaxBins = 32;
Parts part(std::span<Primitive> from, std::span<Primitive> to, const Extent& centers, uint32_t bins,
           bool halve, TaskRunner& tasks);

} // namespace occlude::detail
