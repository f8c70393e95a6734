#include <occlude/scene/detail/split_plane.h>

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

namespace occlude::detail {

namespace {

/// Planes are tried at this many places per axis.
constexpr size_t kCandidates = 15;
/// A plane is used only if either side has at most this share of the triangles.
constexpr double kLargestShare = 0.9;

struct Cost {
    double value = std::numeric_limits<double>::infinity();
    uint64_t cuts = 0; ///< triangles across the plane
};

// No finite value if a side holds more than `most` triangles.
Cost cost_of(std::span<const Aabb> boxes, const SplitPlane& plane, double most)
{
    Cost cost;
    std::array<Aabb, 2> side;
    std::array<double, 2> count{};
    for (const Aabb& box : boxes) {
        const bool low =
            !box.is_bounded() || box.min[plane.axis] < plane.at || box.max[plane.axis] <= plane.at;
        const bool high = box.is_bounded() && box.max[plane.axis] > plane.at;
        if (low) {
            ++count[0];
        }
        if (high) {
            ++count[1];
        }
        Aabb clipped = box;
        if (low && high) {
            ++cost.cuts;
            clipped.max[plane.axis] = plane.at;
            side[0] = merge(side[0], clipped);
            clipped = box;
            clipped.min[plane.axis] = plane.at;
            side[1] = merge(side[1], clipped);
        } else if (box.is_bounded()) {
            side[low ? 0 : 1] = merge(side[low ? 0 : 1], box);
        }
    }
    if (count[0] <= most && count[1] <= most) {
        cost.value =
            double{surface_area(side[0])} * count[0] + double{surface_area(side[1])} * count[1];
    }
    return cost;
}

} // namespace

SplitChoice choose_split_plane(std::span<const Aabb> boxes, uint64_t most_cuts)
{
    const auto most = kLargestShare * static_cast<double>(boxes.size());
    double least = std::numeric_limits<double>::infinity();
    SplitChoice choice;
    std::vector<float> borders;
    for (int axis = 0; axis < 3; ++axis) {
        borders.clear();
        for (const Aabb& box : boxes) {
            if (box.is_bounded()) {
                borders.push_back(box.max[axis]);
            }
        }
        for (size_t k = 1; k <= kCandidates && !borders.empty(); ++k) {
            const auto rank = borders.begin() +
                              static_cast<std::ptrdiff_t>(borders.size() * k / (kCandidates + 1));
            std::nth_element(borders.begin(), rank, borders.end());
            const SplitPlane plane{axis, *rank};
            const Cost cost = cost_of(boxes, plane, most);
            if (cost.value < least && cost.cuts <= most_cuts) {
                least = cost.value;
                choice.plane = plane;
            } else if (cost.value < least) {
                choice.cuts_too_many = true;
            }
        }
    }
    return choice;
}

} // namespace occlude::detail
