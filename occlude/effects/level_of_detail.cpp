#include <occlude/effects/level_of_detail.h>

#include <occlude/core/assert.h>

#include <algorithm>
#include <functional>

namespace occlude {

uint32_t choose_level_of_detail(uint64_t pixels, std::span<const uint64_t> thresholds,
                                uint32_t current, float hysteresis)
{
    OCCLUDE_ASSERT(std::ranges::is_sorted(thresholds, std::greater<>{}),
                   "the thresholds of levels of detail descend");
    OCCLUDE_ASSERT(hysteresis >= 0.0f && hysteresis < 1.0f,
                   "the hysteresis of levels of detail is from 0 to less than 1");
    const auto count = static_cast<uint32_t>(thresholds.size());
    uint32_t level = std::min(current, count);
    const auto pixel_count = static_cast<double>(pixels);
    const auto threshold = [&](uint32_t i) { return static_cast<double>(thresholds[i]); };
    // Goes finer while the next finer threshold is clearly passed; otherwise coarser likewise.
    while (level > 0 && pixel_count >= threshold(level - 1) * (1.0 + double{hysteresis})) {
        --level;
    }
    while (level < count && pixel_count < threshold(level) * (1.0 - double{hysteresis})) {
        ++level;
    }
    return level;
}

} // namespace occlude
