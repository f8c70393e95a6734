// Time, for the algorithms that measure or count in it. Algorithms name no clock of their own: the
// host gives them one, and tests give them another.
#pragma once

#include <functional>

namespace occlude {

/// Seconds since some fixed moment; never goes back. Algorithms ask it several times in a frame: it
/// must move meanwhile. An engine's frame time does not.
using SecondsClock = std::function<double()>;

/// The computer's own clock (std::chrono::steady_clock), for hosts that have no better one.
SecondsClock steady_seconds_clock();

} // namespace occlude
