// Four floats at once, in the compilers' own vector types: the same operations in the same order on
// every machine, so that results are those of scalar code, bit for bit. Internal.
#pragma once

#include <bit>
#include <cstdint>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace occlude::detail {

/// Four floats in one register on every machine that has such; the compilers' own extension.
using Float4 = float __attribute__((vector_size(16)));
using Int4 = int32_t __attribute__((vector_size(16)));

/// Lane by lane; where both are equal, `a`, as glm::min and glm::max do.
inline Float4 min4(Float4 a, Float4 b)
{
#ifdef __SSE2__
    return _mm_min_ps(b, a); // compilers make four instructions of the expression below
#else
    return b < a ? b : a;
#endif
}
inline Float4 max4(Float4 a, Float4 b)
{
#ifdef __SSE2__
    return _mm_max_ps(b, a);
#else
    return a < b ? b : a;
#endif
}

inline Float4 splat(float v)
{
    return Float4{v, v, v, v};
}

inline Float4 load4(const float* four)
{
    return Float4{four[0], four[1], four[2], four[3]};
}

inline Float4 abs4(Float4 v)
{
    return std::bit_cast<Float4>(std::bit_cast<Int4>(v) & 0x7fffffff);
}

/// Rounds toward zero, and up to the next whole number. Precondition: an int can hold the result.
inline Int4 truncate4(Float4 v)
{
    return __builtin_convertvector(v, Int4);
}
inline Int4 ceil4(Float4 v)
{
    const Int4 whole = truncate4(v);
    return whole - (__builtin_convertvector(whole, Float4) < v); // a comparison's result is 0 or -1
}

/// Bit i: lane i is set. Lanes are comparisons' results: 0 or -1.
inline uint32_t bits_of(Int4 lanes)
{
#ifdef __SSE2__
    return static_cast<uint32_t>(_mm_movemask_ps(std::bit_cast<Float4>(lanes)));
#else
    return static_cast<uint32_t>((lanes[0] & 1) | (lanes[1] & 2) | (lanes[2] & 4) | (lanes[3] & 8));
#endif
}

} // namespace occlude::detail
