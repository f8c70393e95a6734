#include <occlude/scene/partition.h>

#include <occlude/core/assert.h>

#include <algorithm>
#include <array>
#include <numeric>

namespace occlude {
namespace {

/// Split candidates are tried at every 1/16 of the sorted triangles, from 4/16 to 12/16.
constexpr size_t kSixteenths = 16;
constexpr size_t kFirstCandidate = 4;
constexpr size_t kLastCandidate = 12;

struct Triangles {
    std::span<const glm::vec3> positions;
    std::span<const uint32_t> indices;
    std::vector<glm::vec3> centroids;

    Aabb box_of(uint32_t triangle) const
    {
        const glm::vec3& a = positions[indices[3 * size_t{triangle}]];
        const glm::vec3& b = positions[indices[3 * size_t{triangle} + 1]];
        const glm::vec3& c = positions[indices[3 * size_t{triangle} + 2]];
        const glm::vec3 sum = a + b + c; // NaN if any of them is, which min and max may miss
        return sum == sum ? Aabb{glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))}
                          : Aabb::everything();
    }
};

int longest_axis(const Triangles& triangles, std::span<const uint32_t> ids)
{
    Aabb centers;
    for (uint32_t id : ids) {
        centers = merge(centers, {triangles.centroids[id], triangles.centroids[id]});
    }
    const glm::vec3 extent = centers.extent();
    if (extent.x >= extent.y && extent.x >= extent.z) {
        return 0;
    }
    return extent.y >= extent.z ? 1 : 2;
}

/// The place to divide the sorted triangles: the candidate with the least area(left) * count(left)
/// + area(right) * count(right).
size_t best_cut(const Triangles& triangles, std::span<const uint32_t> sorted)
{
    const auto cut_at = [&](size_t sixteenth) { return sorted.size() * sixteenth / kSixteenths; };
    std::array<Aabb, kSixteenths> slices;
    for (size_t i = 0; i < kSixteenths; ++i) {
        for (size_t at = cut_at(i); at < cut_at(i + 1); ++at) {
            slices[i] = merge(slices[i], triangles.box_of(sorted[at]));
        }
    }
    size_t best = sorted.size() / 2;
    float best_cost = Aabb::kInfinity;
    for (size_t candidate = kFirstCandidate; candidate <= kLastCandidate; ++candidate) {
        const size_t cut = cut_at(candidate);
        if (cut == 0) {
            continue;
        }
        Aabb left;
        Aabb right;
        for (size_t i = 0; i < kSixteenths; ++i) {
            Aabb& side = i < candidate ? left : right;
            side = merge(side, slices[i]);
        }
        const float cost = surface_area(left) * static_cast<float>(cut) +
                           surface_area(right) * static_cast<float>(sorted.size() - cut);
        if (cost < best_cost) {
            best_cost = cost;
            best = cut;
        }
    }
    return best;
}

void emit(const Triangles& triangles, std::span<uint32_t> ids, Partition& out)
{
    std::sort(ids.begin(), ids.end());
    PartitionPart part;
    part.first_index = static_cast<uint32_t>(out.indices.size());
    part.index_count = static_cast<uint32_t>(3 * ids.size());
    for (uint32_t id : ids) {
        part.box = merge(part.box, triangles.box_of(id));
        const auto corners = triangles.indices.subspan(3 * size_t{id}, 3);
        out.indices.insert(out.indices.end(), corners.begin(), corners.end());
    }
    out.parts.push_back(part);
}

void split(const Triangles& triangles, std::span<uint32_t> ids, size_t max_triangles,
           Partition& out)
{
    if (ids.size() <= max_triangles) {
        emit(triangles, ids, out);
        return;
    }
    const int axis = longest_axis(triangles, ids);
    std::sort(ids.begin(), ids.end(), [&](uint32_t a, uint32_t b) {
        const float a_at = triangles.centroids[a][axis];
        const float b_at = triangles.centroids[b][axis];
        return a_at != b_at ? a_at < b_at : a < b;
    });
    const size_t cut = best_cut(triangles, ids);
    split(triangles, ids.first(cut), max_triangles, out);
    split(triangles, ids.subspan(cut), max_triangles, out);
}

} // namespace

Partition partition_triangles(std::span<const glm::vec3> positions,
                              std::span<const uint32_t> indices, uint32_t max_triangles)
{
    OCCLUDE_ASSERT(indices.size() % 3 == 0, "there must be three indices per triangle");
    OCCLUDE_ASSERT(max_triangles > 0, "partition_triangles() needs max_triangles > 0");
    Partition out;
    const size_t count = indices.size() / 3;
    const bool inside = std::all_of(indices.begin(), indices.end(),
                                    [&](uint32_t index) { return index < positions.size(); });
    OCCLUDE_ASSERT(inside, "every index must be less than the number of positions");
    if (count == 0 || !inside) {
        return out;
    }
    Triangles triangles{positions, indices, {}};
    std::vector<uint32_t> ids(count);
    std::iota(ids.begin(), ids.end(), 0u);
    out.indices.reserve(indices.size());
    if (count > max_triangles) {
        triangles.centroids.resize(count);
        for (uint32_t i = 0; i < count; ++i) {
            const glm::vec3 center = triangles.box_of(i).center();
            // NaN has no place in an order; the box of its part is unbounded.
            const bool ordered = center == center;
            triangles.centroids[i] = ordered ? center : glm::vec3{0.0f};
        }
    }
    split(triangles, ids, std::max(max_triangles, 1u), out);
    return out;
}

} // namespace occlude
