// Which of two implementations does the work where there are two.
#pragma once

#include <cstdint>

namespace occlude {

/// Both give the same results, bit for bit: what `scalar` says is the specification.
enum class Kernel : uint8_t {
    simd,   ///< 4, 8 or 16 at once, chosen by what the processor has when the program runs
    scalar, ///< one after the other, as written in the paper or the comment
};

} // namespace occlude
