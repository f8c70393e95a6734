#include <occlude/core/clock.h>

#include <chrono>

namespace occlude {

SecondsClock steady_seconds_clock()
{
    return [] {
        const auto now = std::chrono::steady_clock::now().time_since_epoch();
        return std::chrono::duration<double>(now).count();
    };
}

} // namespace occlude
