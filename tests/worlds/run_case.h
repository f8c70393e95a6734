// Runs one random world: an algorithm over a faulty device beside a picture of everything.
#pragma once

#include "worlds/spec.h"

#include <cstdint>
#include <string>

namespace occlude::worlds {

/// How much was compared; adds up over cases.
struct Counts {
    uint64_t cases = 0;
    uint64_t exact_cases = 0; ///< whose images were compared; the others' contract was
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

/// Empty, or what went wrong first, as a sentence with the frame. Checks, in every frame:
///   - the image of an exact culler equals that of drawing all items, without frustum culling: the
///     owner and the depth of every pixel, and all translucent fragments
///   - no line of the contract is broken, by culler or device (ValidatingDevice)
///   - the report counts what was drawn
std::string run_case(const Spec& spec, Counts& counts);

/// The smallest spec found, by simpler(), that still fails.
Spec shrink(const Spec& failing);

} // namespace occlude::worlds
