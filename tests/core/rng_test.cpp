#include <occlude/core/rng.h>

#include <gtest/gtest.h>

#include <array>

namespace occlude {
namespace {

TEST(Rng, MixIsSplitmix64)
{
    // The published sequence of splitmix64 from seed 1234567.
    constexpr uint64_t kGamma = 0x9e3779b97f4a7c15ull;
    EXPECT_EQ(mix64(1234567), 6457827717110365317ull);
    EXPECT_EQ(mix64(1234567 + kGamma), 3203168211198807973ull);
    EXPECT_EQ(mix64(1234567 + 2 * kGamma), 9817491932198370423ull);
}

TEST(Rng, SameSeedGivesSameSequence)
{
    Rng a(5);
    Rng b(5);
    Rng c(6);
    int same_as_other_seed = 0;
    for (int i = 0; i < 100; ++i) {
        const uint64_t x = a.next();
        EXPECT_EQ(x, b.next());
        same_as_other_seed += x == c.next() ? 1 : 0;
    }
    EXPECT_EQ(same_as_other_seed, 0);
}

TEST(Rng, HashDependsOnOrderAndOnEveryValue)
{
    EXPECT_NE(hash64(1, 2), hash64(2, 1));
    EXPECT_NE(hash64(1, 2, 3), hash64(1, 2, 4));
    EXPECT_NE(hash64(1, 2), hash64(1, 2, 0));
    EXPECT_NE(hash64(0), hash64(0, 0));
}

TEST(Rng, UniformBelowReachesExactlyTheWholeNumbersBelow)
{
    EXPECT_EQ(uniform_below(0, 7), 0u);
    EXPECT_EQ(uniform_below(~uint64_t{0}, 7), 6u);
    EXPECT_EQ(uniform_below(~uint64_t{0}, 1), 0u);
    EXPECT_EQ(uniform_below(~uint64_t{0}, 0xffffffffu), 0xfffffffeu);
}

TEST(Rng, Uniform01IsBelowOne)
{
    EXPECT_EQ(uniform01(0), 0.0f);
    EXPECT_LT(uniform01(~uint64_t{0}), 1.0f);
    EXPECT_EQ(uniform01(~uint64_t{0}), 1.0f - 0x1p-24f);
}

TEST(Rng, NumbersAreEvenlySpread)
{
    Rng rng(11);
    std::array<int, 10> below{};
    std::array<int, 10> range{};
    for (int i = 0; i < 100000; ++i) {
        ++below[rng.below(10)];
        ++range[static_cast<size_t>(rng.range(0.0f, 10.0f))];
    }
    for (size_t i = 0; i < 10; ++i) { // 10000 expected, deviation 95: five of them
        EXPECT_NEAR(below[i], 10000, 475);
        EXPECT_NEAR(range[i], 10000, 475);
    }
}

TEST(Rng, RangeKeepsItsEnds)
{
    Rng rng(3);
    for (int i = 0; i < 1000; ++i) {
        const float x = rng.range(-2.0f, 5.0f);
        EXPECT_GE(x, -2.0f);
        EXPECT_LT(x, 5.0f);
    }
}

} // namespace
} // namespace occlude
