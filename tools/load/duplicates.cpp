#include "load/duplicates.h"

#include <occlude/core/rng.h>

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <unordered_map>

namespace occlude::tools {
namespace {

uint64_t hash_floats(uint64_t hash, std::span<const glm::vec3> points)
{
    for (const glm::vec3& p : points) {
        hash = hash64(hash, std::bit_cast<uint32_t>(p.x),
                      uint64_t{std::bit_cast<uint32_t>(p.y)} << 32 | std::bit_cast<uint32_t>(p.z));
    }
    return hash;
}

uint64_t hash_of(const Mesh& mesh)
{
    uint64_t hash = hash_floats(mesh.indices.size(), mesh.positions);
    for (size_t i = 0; i + 1 < mesh.indices.size(); i += 2) {
        hash = hash64(hash, uint64_t{mesh.indices[i]} << 32 | mesh.indices[i + 1]);
    }
    return hash;
}

bool equal(const Mesh& a, const Mesh& b)
{
    return a.indices == b.indices && a.positions == b.positions && a.normals == b.normals;
}

/// For every mesh the first one that is equal to it.
std::vector<uint32_t> first_equal_mesh(const std::vector<Mesh>& meshes)
{
    std::vector<uint64_t> hashes(meshes.size());
    oneapi::tbb::parallel_for(size_t{0}, meshes.size(),
                              [&](size_t i) { hashes[i] = hash_of(meshes[i]); });
    std::unordered_multimap<uint64_t, uint32_t> known;
    std::vector<uint32_t> first(meshes.size());
    for (uint32_t i = 0; i < meshes.size(); ++i) {
        const auto [begin, end] = known.equal_range(hashes[i]);
        const auto found = std::find_if(
            begin, end, [&](const auto& entry) { return equal(meshes[entry.second], meshes[i]); });
        first[i] = found != end ? found->second : i;
        if (found == end) {
            known.emplace(hashes[i], i);
        }
    }
    return first;
}

uint64_t hash_of(const glm::dmat4& matrix)
{
    uint64_t hash = 0;
    for (int column = 0; column < 4; ++column) {
        const glm::dvec4 positive = matrix[column] + 0.0; // -0 becomes 0
        for (int row = 0; row < 4; ++row) {
            hash = hash64(hash, std::bit_cast<uint64_t>(positive[row]));
        }
    }
    return hash;
}

} // namespace

Duplicates find_duplicates(const SceneModel& model, std::span<const LoadedInstance* const> placed)
{
    const std::vector<uint32_t> mesh_of = first_equal_mesh(model.meshes);
    Duplicates found;
    found.unseen.assign(model.instances.size(), false);
    std::unordered_multimap<uint64_t, uint32_t> known; ///< instances that are drawn
    for (uint32_t i = 0; i < model.instances.size(); ++i) {
        const Instance& instance = model.instances[i];
        const uint32_t mesh = mesh_of[instance.mesh];
        const glm::dmat4& place = placed[i]->world_from_mesh;
        const uint64_t key = hash64(hash_of(place), mesh);
        const auto [begin, end] = known.equal_range(key);
        bool coincides = false;
        bool is_same = false;
        for (auto at = begin; at != end; ++at) {
            const Instance& other = model.instances[at->second];
            if (mesh_of[other.mesh] == mesh && placed[at->second]->world_from_mesh == place) {
                coincides = true;
                is_same = is_same || (!other.translucent() && !instance.translucent() &&
                                      other.color == instance.color);
            }
        }
        found.unseen[i] = is_same;
        found.unseen_count += is_same ? 1 : 0;
        found.other_color_count += coincides && !is_same ? 1 : 0;
        if (!is_same) {
            known.emplace(key, i);
        }
    }
    return found;
}

} // namespace occlude::tools
