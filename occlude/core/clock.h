// Time, for the algorithms that measure or count in it. Algorithms name no clock of their own: the
// program injects one, and tests inject another.
#pragma once

#include <functional>

namespace occlude {

/// Seconds since some fixed moment; never goes back.
using SecondsClock = std::function<double()>;

} // namespace occlude
