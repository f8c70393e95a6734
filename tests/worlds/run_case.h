// Runs one random world: an algorithm over a faulty device beside a picture of everything.
#pragma once

#include "worlds/spec.h"

#include <cstdint>
#include <string>

namespace occlude::worlds {

/// Counts of comparisons; they add up over cases.
struct Counts {
    uint64_t cases = 0;
    uint64_t exact_cases = 0; ///< cases with compared images; in the others only the contract was
    uint64_t frames = 0;
    uint64_t pixels = 0;
    uint64_t tests = 0;
    uint64_t faults = 0;
    uint64_t drawn = 0;          ///< items, by exact cullers
    uint64_t in_frustum = 0;     ///< items that frustum culling draws, in the same frames
    uint64_t rays = 0;           ///< pixels compared with rays
    uint64_t representative = 0; ///< exact cases in which 10 to 90% of the items in the frustum own
                                 ///< no pixel

    Counts& operator+=(const Counts& other);
    /// The share of the items in the frustum that were not drawn.
    double hidden_share() const;
};

/// Empty, or the first failure, as a sentence with the frame. Checks, in every frame:
///   - the image of an exact culler equals that of drawing all items, without frustum culling: the
///     owner and the depth of every pixel, and all translucent fragments
///   - neither culler nor device breaks a line of the contract (ValidatingDevice)
///   - the report counts the drawn items
std::string run_case(const Spec& spec, Counts& counts);

/// The smallest spec found, by simpler(), that still fails.
Spec shrink(const Spec& failing);

} // namespace occlude::worlds
