#include <occlude/core/clock.h>

#include <gtest/gtest.h>

namespace occlude {
namespace {

TEST(SteadySecondsClock, NeverGoesBackAndMovesWithinAFrame)
{
    const SecondsClock clock = steady_seconds_clock();
    const double start = clock();
    double last = start;
    while (last - start < 1e-3) { // if this test hangs, the clock stands still
        const double now = clock();
        ASSERT_GE(now, last);
        last = now;
    }
    EXPECT_LT(last - start, 60.0);
}

} // namespace
} // namespace occlude
