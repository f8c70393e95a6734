// The inner loops of DepthPyramid with vectors: rows are reduced a vector at a time. A block of
// coarse tests goes through three loops without a branch. The first finds the texels, a vector of
// boxes at a time. The second finds the farthest depth in each of their four columns, box by box.
// The third computes the answers, a vector of boxes at a time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "occlude/screen/depth_pyramid_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <occlude/screen/detail/pyramid_kernels.h>

#include <array>

HWY_BEFORE_NAMESPACE();
namespace occlude::HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR // a processor without vectors

using detail::reduce_rows;

void coarse_hides(std::span<const detail::PyramidLevel> levels, int base, const float* texels,
                  const detail::BoundsBlock& bounds, size_t count,
                  detail::BoundsBlock::Field<uint8_t>& hidden)
{
    for (size_t i = 0; i < count; ++i) {
        hidden[i] =
            bounds.valid[i] != 0 &&
                    detail::coarse_hides(levels, base, texels, bounds.rect(i), bounds.near_depth[i])
                ? 1
                : 0;
    }
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

using F = hn::ScalableTag<float>;
using I = hn::RebindToSigned<F>;
constexpr F kF;
constexpr I kI;
using VI = hn::Vec<I>;
using Block = detail::BoundsBlock;

// Intermediate results between the three loops of a coarse test.
struct Coarse {
    alignas(64) Block::Field<int32_t> level;
    alignas(
        64) std::array<Block::Field<int32_t>, detail::kSpan> row; // its first texel in the level
    alignas(64) Block::Field<int32_t> last_column;                // 0 to kSpan - 1
    alignas(64) Block::Field<float> nearest;
    alignas(64) std::array<float, detail::kSpan * Block::kBoxes> farthest; // by column, box by box
};

// The pixels of rectangles along one axis: detail::clip.
struct Pixels {
    VI low;
    VI count; // there are none if the count is less than 1
};

HWY_INLINE Pixels clip(VI from, VI size, VI target)
{
    const VI zero = hn::Zero(kI);
    const VI low = hn::Max(from, zero);
    // Does not overflow if the size is positive; a size that is not positive stays so.
    const VI inside = hn::Min(hn::Add(size, hn::Min(from, zero)), hn::Sub(target, low));
    return {low, hn::Min(size, inside)};
}

HWY_INLINE VI level_of_distance(VI pixels)
{
    // std::bit_width(pixels) - 2 from the exponent of a number that a float holds exactly.
    const VI bits = hn::BitCast(kI, hn::ConvertTo(kF, pixels));
    const VI exponent = hn::Sub(hn::ShiftRight<23>(bits), hn::Set(kI, 127));
    return hn::Max(hn::Sub(exponent, hn::Set(kI, 1)), hn::Zero(kI));
}

// The texels of the bounds from `i` on: detail::coarse_level.
HWY_INLINE void find_texels(glm::ivec2 target, int base, const Block& bounds, size_t i, Coarse& out)
{
    const VI zero = hn::Zero(kI);
    const VI one = hn::Set(kI, 1);
    const VI last = hn::Set(kI, detail::kSpan - 1);
    const Pixels x =
        clip(hn::Load(kI, &bounds.x[i]), hn::Load(kI, &bounds.width[i]), hn::Set(kI, target.x));
    const Pixels y =
        clip(hn::Load(kI, &bounds.y[i]), hn::Load(kI, &bounds.height[i]), hn::Set(kI, target.y));
    // A rectangle without pixels takes the first pixel, so that all lanes read texels that exist.
    const auto some = hn::And(hn::Gt(x.count, zero), hn::Gt(y.count, zero));
    const VI low_x = hn::IfThenElseZero(some, x.low);
    const VI low_y = hn::IfThenElseZero(some, y.low);
    const VI across = hn::IfThenElseZero(some, hn::Sub(x.count, one));
    const VI up = hn::IfThenElseZero(some, hn::Sub(y.count, one));

    VI level = hn::Max(level_of_distance(hn::Max(across, up)), hn::Set(kI, base));
    const auto texels = [&](VI low, VI distance) HWY_ATTR {
        return hn::Sub(hn::Shr(hn::Add(low, distance), level), hn::Shr(low, level));
    };
    const auto too_many = hn::Gt(hn::Max(texels(low_x, across), texels(low_y, up)), last);
    level = hn::Add(level, hn::IfThenElseZero(too_many, one));
    const VI rows = texels(low_y, up); // in addition to the first
    const VI width = hn::Add(hn::Shr(hn::Set(kI, target.x - 1), level), one);
    hn::Store(level, kI, &out.level[i]);
    hn::Store(texels(low_x, across), kI, &out.last_column[i]);
    VI row = hn::Add(hn::Mul(hn::Shr(low_y, level), width), hn::Shr(low_x, level));
    hn::Store(row, kI, &out.row[0][i]);
    for (int k = 1; k < detail::kSpan; ++k) { // if there are fewer rows, the last one is read again
        row = hn::Add(row, hn::IfThenElseZero(hn::Gt(rows, hn::Set(kI, k - 1)), width));
        hn::Store(row, kI, &out.row[static_cast<size_t>(k)][i]);
    }
    // A rectangle without pixels is hidden (farther than all depths); invalid bounds never are.
    const auto inf = hn::Set(kF, Aabb::kInfinity);
    const auto near_depth =
        hn::IfThenElse(hn::RebindMask(kF, some), hn::Load(kF, &bounds.near_depth[i]), inf);
    const auto valid = hn::Ne(hn::Load(kI, &bounds.valid[i]), zero);
    hn::Store(hn::IfThenElse(hn::RebindMask(kF, valid), near_depth, hn::Neg(inf)), kF,
              &out.nearest[i]);
}

HWY_INLINE void farthest_of_columns(std::span<const detail::PyramidLevel> levels,
                                    const float* texels, size_t i, Coarse& c)
{
    const hn::FixedTag<float, detail::kSpan> d;
    const float* level = texels + levels[static_cast<size_t>(c.level[i])].first;
    const auto row = [&](size_t k) HWY_ATTR { return hn::LoadU(d, level + c.row[k][i]); };
    hn::Store(hn::Max(hn::Max(row(0), row(1)), hn::Max(row(2), row(3))), d,
              &c.farthest[detail::kSpan * i]);
}

HWY_INLINE void answer(const Coarse& c, size_t i, Block::Field<uint8_t>& hidden)
{
    hn::Vec<F> first, second, third, fourth;
    hn::LoadInterleaved4(kF, &c.farthest[detail::kSpan * i], first, second, third, fourth);
    const VI last = hn::Load(kI, &c.last_column[i]);
    const auto from = [&](int column, hn::Vec<F> v) HWY_ATTR {
        return hn::IfThenElse(hn::RebindMask(kF, hn::Gt(last, hn::Set(kI, column - 1))), v, first);
    };
    const auto farthest =
        hn::Max(hn::Max(first, from(1, second)), hn::Max(from(2, third), from(3, fourth)));
    const auto hides = hn::RebindMask(kI, hn::Lt(farthest, hn::Load(kF, &c.nearest[i])));
    const hn::Rebind<uint8_t, I> bytes;
    hn::StoreU(hn::DemoteTo(bytes, hn::IfThenElseZero(hides, hn::Set(kI, 1))), bytes, &hidden[i]);
}

// Lanes beyond `count` hold arbitrary values: they are clipped like the others, and their answers
// are never read.
void coarse_hides(std::span<const detail::PyramidLevel> levels, int base, const float* texels,
                  const Block& bounds, size_t count, Block::Field<uint8_t>& hidden)
{
    static_assert(detail::kSpan == 4 && Block::kBoxes % hn::MaxLanes(F{}) == 0);
    const size_t lanes = hn::Lanes(kF);
    Coarse c;
    for (size_t i = 0; i < count; i += lanes) {
        find_texels(levels[0].size, base, bounds, i, c);
    }
    for (size_t i = 0; i < count; ++i) {
        farthest_of_columns(levels, texels, i, c);
    }
    for (size_t i = 0; i < count; i += lanes) {
        answer(c, i, hidden);
    }
}

#endif

void build_levels(std::span<const detail::PyramidLevel> levels, int base, float* texels)
{
    detail::build_levels(levels, base, texels, &reduce_rows);
}

} // namespace occlude::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace occlude {
HWY_EXPORT(build_levels);
HWY_EXPORT(coarse_hides);

void detail::build_levels_simd(std::span<const PyramidLevel> levels, int base, float* texels)
{
    HWY_DYNAMIC_DISPATCH(build_levels)(levels, base, texels);
}

void detail::coarse_hides_simd(std::span<const PyramidLevel> levels, int base, const float* texels,
                               const BoundsBlock& bounds, size_t count,
                               BoundsBlock::Field<uint8_t>& hidden)
{
    HWY_DYNAMIC_DISPATCH(coarse_hides)(levels, base, texels, bounds, count, hidden);
}

} // namespace occlude
#endif
