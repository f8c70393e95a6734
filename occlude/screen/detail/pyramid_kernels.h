// The inner loops of DepthPyramid, as scalar and as vector code.
#pragma once

#include <occlude/screen/depth_pyramid.h>
#include <occlude/screen/detail/box_projector.h>

#include <glm/vec2.hpp>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace occlude::detail {

/// A coarse test looks at no more than kSpan x kSpan texels of one level.
inline constexpr int kSpan = 4;

/// Pixels or texels from low to high, both ends included.
struct TexelRange {
    glm::ivec2 low{0};
    glm::ivec2 high{-1};

    bool is_empty() const { return low.x > high.x || low.y > high.y; }
};

/// The pixels of `rect` in a target of this size; false if there are none.
inline bool clip(const PixelRect& rect, glm::ivec2 size_px, TexelRange& pixels)
{
    pixels.low = {std::max(rect.x, 0), std::max(rect.y, 0)};
    // In 64 bits, because the edges of a rectangle may be anywhere in 32 bits.
    const int64_t right = int64_t{rect.x} + rect.width - 1;
    const int64_t top = int64_t{rect.y} + rect.height - 1;
    pixels.high = {static_cast<int>(std::clamp<int64_t>(right, -1, size_px.x - 1)),
                   static_cast<int>(std::clamp<int64_t>(top, -1, size_px.y - 1))};
    return !pixels.is_empty();
}

/// The finest level where the pixels lie in at most kSpan x kSpan texels.
inline int coarse_level(const TexelRange& pixels)
{
    // A distance of d pixels below 4 << n is at most 4 texels of level n, and 2 of the next.
    const glm::ivec2 d = pixels.high - pixels.low;
    const auto width = static_cast<int>(std::bit_width(static_cast<uint32_t>(std::max(d.x, d.y))));
    const int n = std::max(0, width - 2);
    const bool fits = (pixels.high.x >> n) - (pixels.low.x >> n) < kSpan &&
                      (pixels.high.y >> n) - (pixels.low.y >> n) < kSpan;
    return fits ? n : n + 1;
}

/// The texels of a level that lie wholly in the pixels, as far as the target reaches. If one of
/// them does not hide, its farthest pixel lies in the rectangle and is visible. There may be none.
inline TexelRange whole_texels(const TexelRange& pixels, int level, glm::ivec2 size_px)
{
    const auto first = [&](int low) { return (low + (1 << level) - 1) >> level; };
    const auto last = [&](int high, int size) {
        return high == size - 1 ? high >> level : ((high + 1) >> level) - 1;
    };
    return {{first(pixels.low.x), first(pixels.low.y)},
            {last(pixels.high.x, size_px.x), last(pixels.high.y, size_px.y)}};
}

/// Reduces two rows of `width` texels (or one row twice) to one row of half the width, rounded up.
using ReduceRows = void (*)(const float* a, const float* b, int width, float* out);
void reduce_rows(const float* a, const float* b, int width, float* out);

/// Computes all levels above `base`.
void build_levels(std::span<const PyramidLevel> levels, int base, float* texels, ReduceRows reduce);
void build_levels_simd(std::span<const PyramidLevel> levels, int base, float* texels);

/// True if all texels of the range, at most kSpan x kSpan of a level, are below `nearest`. Reads up
/// to kSpan - 1 floats beyond the last texel of all, and ignores them.
bool all_nearer(const PyramidLevel& level, const float* texels, const TexelRange& range,
                float nearest);

/// DepthPyramid::hides without refinement. Precondition: the pyramid has levels, and `base` is one.
bool coarse_hides(std::span<const PyramidLevel> levels, int base, const float* texels,
                  const PixelRect& rect, float nearest);

/// The vector code counts the texels of a level in 31 bits, which limits targets to 32768 x 32768
/// pixels.
inline constexpr size_t kMostVectorLevels = 16;

/// Tests the first `count` bounds that are valid, and writes 1 or 0 to `hidden`; all of `hidden`
/// may be written. Precondition: the pyramid has from one to kMostVectorLevels levels.
void coarse_hides_simd(std::span<const PyramidLevel> levels, int base, const float* texels,
                       const BoundsBlock& bounds, size_t count,
                       BoundsBlock::Field<uint8_t>& hidden);

} // namespace occlude::detail
