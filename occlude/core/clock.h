// Time for algorithms that measure it or count in it. Algorithms never read a clock of their own:
// the host gives them one, and tests give them another.
#pragma once

#include <functional>

namespace occlude {

/// Seconds since some fixed moment. Must never go back, and must advance between calls within a
/// frame, because algorithms read it several times per frame. An engine's frame time does not
/// advance so.
using SecondsClock = std::function<double()>;

/// The computer's own clock (std::chrono::steady_clock), for hosts that have no better one.
SecondsClock steady_seconds_clock();

} // namespace occlude
