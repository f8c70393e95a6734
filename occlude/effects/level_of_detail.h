// Geometric level of detail by the number of pixels that a query counted (GPU Gems 29.9).
#pragma once

#include <cstdint>
#include <span>

namespace occlude {

/// The level of detail for an object of `pixels` visible pixels: the first level i with `pixels` >=
/// thresholds[i], or thresholds.size() (the coarsest) if there is none. Leaves `current` only if
/// the count is past the threshold between two levels by the share `hysteresis`, so that a count
/// near a threshold does not make the object flicker. Preconditions: `thresholds` descend; 0 <=
/// hysteresis < 1. A `current` beyond the coarsest level counts as the coarsest.
uint32_t choose_level_of_detail(uint64_t pixels, std::span<const uint64_t> thresholds,
                                uint32_t current, float hysteresis);

} // namespace occlude
