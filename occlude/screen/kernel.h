// The choice between two implementations of the same work.
#pragma once

#include <cstdint>

namespace occlude {

/// Both give the same results, bit for bit; `scalar` is the specification.
enum class Kernel : uint8_t {
    simd,   ///< 4, 8 or 16 values at once, chosen by the processor when the program runs
    scalar, ///< one after the other, as written in the paper or the comment
};

} // namespace occlude
