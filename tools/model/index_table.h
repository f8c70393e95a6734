// Finds equal things by their hashes, and remembers nothing but their indices.
#pragma once

#include <occlude/core/rng.h>

#include <glm/vec3.hpp>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace occlude::tools {

/// A hash of a point; equal points have equal hashes, whatever the sign of their zeros.
inline uint64_t hash_of(const glm::vec3& v)
{
    const glm::vec3 positive = v + 0.0f; // -0 becomes 0
    return hash64(std::bit_cast<uint32_t>(positive.x), std::bit_cast<uint32_t>(positive.y),
                  std::bit_cast<uint32_t>(positive.z));
}

/// An open-addressing table of indices, of 8 to 16 bytes per entry.
class IndexTable {
public:
    /// Room for `entries` different things.
    explicit IndexTable(size_t entries)
        : slots_(std::bit_ceil(entries * 2 + 1), kFree)
    {
    }
    /// The index that equals `candidate`, which is put in if there is none. O(1) on average.
    template <class Equal>
    uint32_t find_or_insert(uint64_t hash, uint32_t candidate, Equal&& equal)
    {
        const size_t mask = slots_.size() - 1;
        size_t at = mix64(hash) & mask;
        while (slots_[at] != kFree && !equal(slots_[at])) {
            at = (at + 1) & mask;
        }
        if (slots_[at] == kFree) {
            slots_[at] = candidate;
        }
        return slots_[at];
    }

private:
    static constexpr uint32_t kFree = 0xffffffffu;
    std::vector<uint32_t> slots_;
};

} // namespace occlude::tools
