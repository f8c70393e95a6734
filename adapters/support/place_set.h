// A set of places in an engine's order, by which a batch of items is drawn in that order.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace occlude {

class PlaceSet {
public:
    /// The set is empty, and holds places below `count`.
    void make_room(size_t count) { words_.resize(std::max(words_.size(), count / 64 + 1)); }

    void insert(uint32_t place) { words_[place / 64] |= uint64_t{1} << (place % 64); }

    /// Calls `visit(place)` for each place, ascending, and takes it out of the set.
    template <typename Visit>
    void take_all(const Visit& visit)
    {
        for (size_t word = 0; word < words_.size(); ++word) {
            for (uint64_t bits = words_[word]; bits != 0; bits &= bits - 1) {
                visit(
                    static_cast<uint32_t>(word * 64 + static_cast<size_t>(std::countr_zero(bits))));
            }
            words_[word] = 0;
        }
    }

private:
    std::vector<uint64_t> words_;
};

} // namespace occlude
