// The only source of randomness in the library: a hash, by a fixed algorithm, of values that name
// the purpose of the number. It has no state and is the same on every compiler, so that every run
// repeats.
#pragma once

#include <cstdint>

namespace occlude {

/// A well-mixed 64-bit value of `x` (the finaliser of splitmix64).
constexpr uint64_t mix64(uint64_t x)
{
    x += 0x9e3779b97f4a7c15ull;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

/// A hash of several values, in order.
template <class... Rest>
constexpr uint64_t hash64(uint64_t first, Rest... rest)
{
    uint64_t h = mix64(first);
    ((h = mix64(h ^ static_cast<uint64_t>(rest))), ...);
    return h;
}

/// A whole number uniform in [0, count), from a hash. Precondition: count > 0.
constexpr uint32_t uniform_below(uint64_t hash, uint32_t count)
{
    return static_cast<uint32_t>(((hash >> 32) * count) >> 32);
}

/// A number uniform in [0, 1), from a hash: 24 random bits, exactly representable.
constexpr float uniform01(uint64_t hash)
{
    return static_cast<float>(hash >> 40) * 0x1p-24f;
}

/// A sequence of hashes of one seed, for generators that draw many numbers in a fixed order.
class Rng {
public:
    constexpr explicit Rng(uint64_t seed)
        : seed_(seed)
    {
    }

    constexpr uint64_t next() { return hash64(seed_, ++count_); }
    constexpr uint32_t below(uint32_t count) { return uniform_below(next(), count); }
    constexpr float range(float low, float high) { return low + (high - low) * uniform01(next()); }

private:
    uint64_t seed_;
    uint64_t count_ = 0;
};

} // namespace occlude
