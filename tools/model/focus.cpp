#include "model/focus.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <numeric>
#include <span>

namespace occlude::tools {
namespace {

constexpr float kGapToFew = 8.0f;
constexpr float kGapToMany = 64.0f;
constexpr size_t kFewShare = 20; // one in this many instances

struct Placed {
    Aabb box;
    uint64_t triangles = 0;
};

Aabb bounds_of(std::span<const Placed> placed)
{
    Aabb box;
    for (const Placed& one : placed) {
        box = merge(box, one.box);
    }
    return box;
}

uint64_t triangles_of(std::span<const Placed> placed)
{
    return std::accumulate(placed.begin(), placed.end(), uint64_t{0},
                           [](uint64_t sum, const Placed& one) { return sum + one.triangles; });
}

/// True if some stretch of the axis is so long and empty that it may hold a far gap. O(instances).
bool may_have_gap(const std::vector<Placed>& placed, int axis)
{
    constexpr size_t kBins = 1024;
    constexpr size_t kLongRun = kBins / 4;
    const Aabb all = bounds_of(placed);
    const float size = all.extent()[axis];
    if (!(size > 0.0f)) {
        return false;
    }
    const auto bin_of = [&](float at) {
        const float share = (at - all.min[axis]) / size;
        return std::min(static_cast<size_t>(share * static_cast<float>(kBins)), kBins - 1);
    };
    std::vector<int64_t> change(kBins + 1, 0); // number of instances that cover a bin
    for (const Placed& one : placed) {
        ++change[bin_of(one.box.min[axis])];
        --change[bin_of(one.box.max[axis]) + 1];
    }
    int64_t covering = 0;
    size_t run = 0;
    size_t longest = 0;
    for (size_t bin = 0; bin < kBins; ++bin) {
        covering += change[bin];
        run = covering > 0 ? 0 : run + 1;
        longest = std::max(longest, run);
    }
    return longest >= kLongRun;
}

float size_of(std::span<const Placed> placed)
{
    return glm::length(bounds_of(placed).extent());
}

/// The place where the sorted instances separate along the axis: the first far gap; 0 if there is
/// none.
size_t far_gap(std::span<const Placed> sorted, int axis)
{
    const size_t few = sorted.size() / kFewShare;
    const float core = size_of(sorted.subspan(few, sorted.size() - 2 * few));
    const float half = 0.5f * bounds_of(sorted).extent()[axis]; // of which at most one gap is far
    float reach = sorted.front().box.max[axis];
    for (size_t i = 1; i < sorted.size(); ++i) {
        const float gap = sorted[i].box.min[axis] - reach;
        const bool cuts_few = i <= few || sorted.size() - i <= few;
        if ((cuts_few && gap > kGapToFew * core) ||
            (gap > half && gap > kGapToMany * size_of(sorted.first(i)) &&
             gap > kGapToMany * size_of(sorted.subspan(i)))) {
            return i;
        }
        reach = std::max(reach, sorted[i].box.max[axis]);
    }
    return 0;
}

/// Leaves out the side of a far gap that has fewer triangles. False if there is no such gap.
bool cut_far_side(std::vector<Placed>& placed, int axis)
{
    if (placed.size() < 2 || !may_have_gap(placed, axis)) {
        return false;
    }
    std::sort(placed.begin(), placed.end(), [axis](const Placed& a, const Placed& b) {
        return a.box.min[axis] < b.box.min[axis];
    });
    const size_t at = far_gap(placed, axis);
    if (at == 0) {
        return false;
    }
    const std::span<const Placed> all = placed;
    const bool keeps_lower = triangles_of(all.first(at)) >= triangles_of(all.subspan(at));
    const auto middle = placed.begin() + static_cast<std::ptrdiff_t>(at);
    placed = keeps_lower ? std::vector<Placed>(placed.begin(), middle)
                         : std::vector<Placed>(middle, placed.end());
    return true;
}

} // namespace

Focus find_focus(const SceneModel& model)
{
    const Aabb all = world_bounds(model);
    if (!model.motion.empty() || model.instances.size() < 2) {
        return {all, 0};
    }
    std::vector<Placed> placed;
    placed.reserve(model.instances.size());
    for (const Instance& instance : model.instances) {
        const Mesh& mesh = model.meshes[instance.mesh];
        const Aabb box = world_box(model, instance);
        if (box.is_bounded()) {
            placed.push_back({box, mesh.indices.size() / 3});
        }
    }
    const size_t count = placed.size();
    while (cut_far_side(placed, 0) || cut_far_side(placed, 1) || cut_far_side(placed, 2)) {
    }
    return placed.size() == count ? Focus{all, 0} : Focus{bounds_of(placed), count - placed.size()};
}

} // namespace occlude::tools
