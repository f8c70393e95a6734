// Time, for the algorithms that measure what their work costs. Algorithms name no clock of their
// own: the program injects one, and tests inject another.
#pragma once

#include <functional>

namespace occlude {

/// Microseconds since some fixed moment; never goes back.
using MicrosecondClock = std::function<double()>;

} // namespace occlude
