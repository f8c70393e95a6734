// The inner loops of DepthPyramid with vectors: rows are reduced a vector at a time, and a coarse test
// takes four texels at a time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "occlude/core/depth_pyramid_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <occlude/core/detail/pyramid_kernels.h>

HWY_BEFORE_NAMESPACE();
namespace occlude::HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR // a processor without vectors

using detail::reduce_rows;

bool all_below(const float* texels, int stride, const detail::TexelRange& range, float nearest)
{
    for (int y = range.low.y; y <= range.high.y; ++y) {
        for (int x = range.low.x; x <= range.high.x; ++x) {
            if (texels[static_cast<ptrdiff_t>(y) * stride + x] >= nearest) {
                return false;
            }
        }
    }
    return true;
}

#else

namespace hn = hwy::HWY_NAMESPACE;

void reduce_rows(const float* a, const float* b, int width, float* out)
{
    const hn::ScalableTag<float> d;
    const auto lanes = static_cast<int>(hn::Lanes(d));
    int x = 0;
    for (; x + 2 * lanes <= width; x += 2 * lanes) {
        const auto low = hn::Max(hn::LoadU(d, a + x), hn::LoadU(d, b + x));
        const auto high = hn::Max(hn::LoadU(d, a + x + lanes), hn::LoadU(d, b + x + lanes));
        const auto pairs = hn::Max(hn::ConcatEven(d, high, low), hn::ConcatOdd(d, high, low));
        hn::StoreU(pairs, d, out + x / 2);
    }
    detail::reduce_rows(a + x, b + x, width - x, out + x / 2);
}

// True if all texels of the range, at most 4x4, are below `nearest`.
HWY_INLINE bool all_below(const float* texels, int stride, const detail::TexelRange& range,
                          float nearest)
{
    const hn::FixedTag<float, detail::kSpan> d;
    // Four rows, the last of them again where there are less.
    const float* first = texels + static_cast<ptrdiff_t>(range.low.y) * stride + range.low.x;
    const int rows = range.high.y - range.low.y;
    const auto row = [&](int k)
                         HWY_ATTR { return hn::LoadU(d, first + std::min(k, rows) * stride); };
    const auto farthest = hn::Max(hn::Max(row(0), row(1)), hn::Max(row(2), row(3)));
    const auto seen = hn::Ge(farthest, hn::Set(d, nearest));
    const auto inside = hn::FirstN(d, static_cast<size_t>(range.high.x - range.low.x + 1));
    return hn::AllFalse(d, hn::And(seen, inside));
}

#endif

void build_levels(std::span<const detail::PyramidLevel> levels, float* texels)
{
    detail::build_levels(levels, texels, &reduce_rows);
}

void coarse_hides(std::span<const detail::PyramidLevel> levels, const float* texels,
                  std::span<const ScreenBounds> bounds, DepthPyramid::Refinement refinement,
                  uint8_t* hidden)
{
    const glm::ivec2 size = levels.empty() ? glm::ivec2{0} : levels[0].size;
    for (size_t i = 0; i < bounds.size(); ++i) {
        const ScreenBounds& b = bounds[i];
        detail::TexelRange pixels;
        hidden[i] = b.valid ? 1 : 0;
        if (b.valid && detail::clip(b.rect, size, pixels)) {
            const int n = detail::coarse_level(pixels);
            const detail::PyramidLevel& level = levels[static_cast<size_t>(n)];
            const auto hides = [&](const detail::TexelRange& range) HWY_ATTR {
                return all_below(texels + level.first, level.size.x, range, b.near_depth);
            };
            const bool all = hides({pixels.low >> n, pixels.high >> n});
            hidden[i] = all ? 1 : 0;
            if (!all && refinement == DepthPyramid::Refinement::pixels) {
                const detail::TexelRange whole = detail::whole_texels(pixels, n, size);
                hidden[i] = whole.is_empty() || hides(whole) ? detail::kUndecided : 0;
            }
        }
    }
}

} // namespace occlude::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace occlude {
HWY_EXPORT(build_levels);
HWY_EXPORT(coarse_hides);

void detail::build_levels_simd(std::span<const PyramidLevel> levels, float* texels)
{
    HWY_DYNAMIC_DISPATCH(build_levels)(levels, texels);
}

void detail::coarse_hides_simd(std::span<const PyramidLevel> levels, const float* texels,
                               std::span<const ScreenBounds> bounds,
                               DepthPyramid::Refinement refinement, uint8_t* hidden)
{
    HWY_DYNAMIC_DISPATCH(coarse_hides)(levels, texels, bounds, refinement, hidden);
}

} // namespace occlude
#endif
