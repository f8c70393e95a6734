// The inner loops of the rasteriser with vectors: each lane is a row of 32 cells while coverage is
// found, and a sub-tile from then on; the operations and their order are those of the scalar loops.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "occlude/backends/cpu_fast/bin_raster_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <occlude/backends/cpu_fast/detail/bin_raster.h>

HWY_BEFORE_NAMESPACE();
namespace occlude::cpu_fast::HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR // a processor without vectors

const BinKernels* bin_kernel_table()
{
    return &bin_kernels(Kernel::scalar);
}

#else

namespace {

namespace hn = hwy::HWY_NAMESPACE;

// At most 16 lanes: rows of a bin come by sixteens.
using F = hn::CappedTag<float, 16>;
using I = hn::RebindToSigned<F>;
using U = hn::RebindToUnsigned<F>;
using B = hn::Repartition<uint8_t, U>;
constexpr F kF;
constexpr I kI;
constexpr U kU;
constexpr B kB;
// Adding it to a small whole number leaves that number in the lowest bits of the float.
constexpr float kMagic = 0x1.8p23f;
constexpr int32_t kMagicBits = 0x4b400000;
using VF = hn::Vec<F>;
using VI = hn::Vec<I>;
using VU = hn::Vec<U>;

// Four rows of 32 cells, a row per lane, as four sub-tiles, a sub-tile per lane: byte 4 * r + c
// becomes byte 4 * c + r, in each block of 128 bits.
HWY_INLINE VU sub_tiles_from_rows(VU rows)
{
    alignas(16) static constexpr uint8_t kTransposed[16] = {0, 4, 8,  12, 1, 5, 9,  13,
                                                            2, 6, 10, 14, 3, 7, 11, 15};
    return hn::BitCast(
        kU, hn::TableLookupBytes(hn::BitCast(kB, rows), hn::LoadDup128(kB, kTransposed)));
}

// What does not change between the rows of a prim.
struct PrimVectors {
    explicit HWY_INLINE PrimVectors(const BinPrim& p)
        : left0(hn::Set(kF, p.left[0].slope))
        , left1(hn::Set(kF, p.left[1].slope))
        , right0(hn::Set(kF, p.right[0].slope))
        , right1(hn::Set(kF, p.right[1].slope))
        , left0_at(hn::Set(kF, p.left[0].at))
        , left1_at(hn::Set(kF, p.left[1].at))
        , right0_at(hn::Set(kF, p.right[0].at))
        , right1_at(hn::Set(kF, p.right[1].at))
        , x0(hn::Set(kF, static_cast<float>(p.x0)))
        , x1(hn::Set(kF, static_cast<float>(p.x1)))
        , y0(hn::Set(kF, static_cast<float>(p.y0)))
        , y1(hn::Set(kF, static_cast<float>(p.y1)))
        , zx(hn::Set(kF, p.zx))
        , zy(hn::Set(kF, p.zy))
        , z(hn::Set(kF, p.z))
        , z_max(hn::Set(kF, p.z_max))
    {
    }
    VF left0, left1, right0, right1, left0_at, left1_at, right0_at, right1_at;
    VF x0, x1, y0, y1, zx, zy, z, z_max;
};

// Calls use(index of the first sub-tile, masks, depths) for each vector of sub-tiles of which the
// prim may fill some; masks of 0 among them. First asks wanted(index, depths), which is cheaper
// than finding the masks.
template <class Wanted, class Use>
HWY_INLINE void for_each_vector(const BinPrim& prim, Wanted&& wanted, Use&& use)
{
    const auto lanes = static_cast<int>(hn::Lanes(kF));
    const PrimVectors v(prim);
    const VF lane = hn::Iota(kF, 0.0f);
    // Middles of the sub-tiles of a vector: four side by side, the next four above them.
    const VI block = hn::Iota(kI, 0);
    const VF tile_x = hn::Add(hn::ConvertTo(kF, hn::ShiftLeft<3>(hn::And(block, hn::Set(kI, 3)))),
                              hn::Set(kF, 3.5f));
    const VF tile_y =
        hn::Add(hn::ConvertTo(kF, hn::AndNot(hn::Set(kI, 3), block)), hn::Set(kF, 1.5f));
    int stripe0 = prim.x0 / kStripeWidth;
    int stripe1 = prim.x1 / kStripeWidth;
    const bool wide = stripe0 != stripe1;
    for (int y = prim.y0 & -lanes; y <= prim.y1; y += lanes) {
        const VF first_row = hn::Set(kF, static_cast<float>(y));
        const VF row = hn::Add(first_row, lane);
        const VF low = hn::Max(hn::Add(hn::Mul(v.left0, row), v.left0_at),
                               hn::Add(hn::Mul(v.left1, row), v.left1_at));
        const VF high = hn::Min(hn::Add(hn::Mul(v.right0, row), v.right0_at),
                                hn::Add(hn::Mul(v.right1, row), v.right1_at));
        const auto inside = hn::And(hn::Ge(row, v.y0), hn::Le(row, v.y1));
        const VF from = hn::Min(hn::Max(low, v.x0), hn::Set(kF, float{kBinWidth}));
        const VF to = hn::Max(hn::Min(high, v.x1), hn::Set(kF, -1.0f));
        // As integers above kMagic: one addition, where a conversion would also care for overflow.
        const VI first = hn::BitCast(kI, hn::Add(hn::Ceil(from), hn::Set(kF, kMagic)));
        const VF last_column = hn::IfThenElse(inside, hn::Floor(to), hn::Set(kF, -1.0f));
        const VI last = hn::BitCast(kI, hn::Add(last_column, hn::Set(kF, kMagic)));
        const VF row_z = hn::Add(hn::Mul(v.zy, hn::Add(first_row, tile_y)), v.z);
        if (wide) {
            stripe0 = (hn::GetLane(hn::MinOfLanes(kI, first)) - kMagicBits) >> 5;
            stripe1 = (hn::GetLane(hn::MaxOfLanes(kI, last)) - kMagicBits) >> 5;
        }
        for (int stripe = stripe0; stripe <= stripe1; ++stripe) {
            const int index = stripe * kSubTilesPerStripe + y;
            const VF x = hn::Add(hn::Set(kF, static_cast<float>(stripe * kStripeWidth)), tile_x);
            const VF depth = hn::Min(hn::Add(hn::Mul(v.zx, x), row_z), v.z_max);
            if (!wanted(index, depth)) {
                continue;
            }
            const VI offset = hn::Set(kI, kMagicBits + stripe * kStripeWidth);
            const VI begin = hn::Max(hn::Sub(first, offset), hn::Zero(kI));
            const VI end = hn::Min(hn::Sub(last, offset), hn::Set(kI, kStripeWidth - 1));
            // Where begin > end, they may lie outside of the word. The result does not count there,
            // but a shift by more than the word is not defined on every target.
            const VI word = hn::Set(kI, kStripeWidth - 1);
            const VU from_begin = hn::Shl(hn::Set(kU, ~0u), hn::BitCast(kU, hn::And(begin, word)));
            const VU after_end = hn::Shl(hn::Set(kU, ~1u), hn::BitCast(kU, hn::And(end, word)));
            const VU masks = hn::IfThenZeroElse(hn::RebindMask(kU, hn::Gt(begin, end)),
                                                hn::AndNot(after_end, from_begin));
            use(index, sub_tiles_from_rows(masks), depth);
        }
    }
}

// scalar::merge_layer for a vector of sub-tiles.
HWY_INLINE void merge_layers(VU all_covered, VF any_depth, MaskedBin& bin, int i)
{
    const VF far_depth = hn::Load(kF, bin.far_depth + i);
    const VU none = hn::Zero(kU);
    const auto active =
        hn::AndNot(hn::RebindMask(kF, hn::Eq(all_covered, none)), hn::Lt(any_depth, far_depth));
    // With no cell covered, and the nearest depth, nothing changes.
    const VU covered = hn::IfThenElseZero(hn::RebindMask(kU, active), all_covered);
    const VF depth = hn::IfThenElseZero(active, any_depth);
    const VF near_depth = hn::Load(kF, bin.near_depth + i);
    const VU mask = hn::Load(kU, bin.mask + i);
    const VU whole = hn::Set(kU, kWholeSubTile);
    const auto nearer = hn::Lt(depth, near_depth);
    const auto swallows =
        hn::And(hn::RebindMask(kF, hn::Eq(hn::AndNot(covered, mask), none)), nearer);
    const auto much_nearer =
        hn::And(active, hn::Gt(hn::Sub(near_depth, depth), hn::Sub(far_depth, near_depth)));
    const auto restart = hn::Or(swallows, much_nearer);
    const VU merged = hn::Or(covered, hn::IfThenZeroElse(hn::RebindMask(kU, restart), mask));
    const VF merged_depth = hn::IfThenElse(restart, depth, hn::Max(near_depth, depth));
    const auto full = hn::Eq(merged, whole);
    const auto full_f = hn::RebindMask(kF, full);
    const auto keep =
        hn::And(hn::RebindMask(kF, hn::Eq(covered, whole)), hn::Lt(near_depth, depth));
    const VU kept = hn::IfThenElseZero(hn::RebindMask(kU, keep), mask);
    const VF kept_depth = hn::IfThenElseZero(keep, near_depth);
    hn::Store(hn::IfThenElse(full, kept, merged), kU, bin.mask + i);
    hn::Store(hn::IfThenElse(full_f, kept_depth, merged_depth), kF, bin.near_depth + i);
    hn::Store(hn::IfThenElse(full_f, merged_depth, far_depth), kF, bin.far_depth + i);
}

struct Always {
    HWY_INLINE bool operator()(int, VF) const { return true; }
};

// The same where all sub-tiles of the vector are covered whole.
HWY_INLINE void cover_layers(VF depth, MaskedBin& bin, int i)
{
    const VF far_depth = hn::Load(kF, bin.far_depth + i);
    const VF near_depth = hn::Load(kF, bin.near_depth + i);
    const VF nearer = hn::Min(far_depth, depth);
    const auto keep = hn::Lt(near_depth, nearer);
    hn::Store(nearer, kF, bin.far_depth + i);
    hn::Store(hn::IfThenElseZero(keep, near_depth), kF, bin.near_depth + i);
    hn::Store(hn::IfThenElseZero(hn::RebindMask(kU, keep), hn::Load(kU, bin.mask + i)), kU,
              bin.mask + i);
}

void lower(const BinPrim& prim, MaskedBin& bin)
{
    constexpr int kLarge = kBinWidth * kBinHeight / 4; // most vectors are covered whole
    const bool large = prim.cells() >= kLarge;
    for_each_vector(
        prim,
        [&](int i, VF depth)
            HWY_ATTR { return !hn::AllFalse(kF, hn::Lt(depth, hn::Load(kF, bin.far_depth + i))); },
        [&](int i, VU masks, VF depth) HWY_ATTR {
            if (large && hn::AllTrue(kU, hn::Eq(masks, hn::Set(kU, kWholeSubTile)))) {
                cover_layers(depth, bin, i);
            } else {
                merge_layers(masks, depth, bin, i);
            }
        });
}

void touch(const BinPrim& prim, PieceBin& piece)
{
    for_each_vector(prim, Always{}, [&](int i, VU masks, VF depth) HWY_ATTR {
        const auto some = hn::RebindMask(kF, hn::Ne(masks, hn::Zero(kU)));
        const VF before = hn::Load(kF, piece.depth + i);
        hn::Store(hn::IfThenElse(some, hn::Max(before, depth), before), kF, piece.depth + i);
        hn::Store(hn::Or(hn::Load(kU, piece.touched + i), masks), kU, piece.touched + i);
    });
}

void open(const BinPrim& prim, PieceBin& piece)
{
    for_each_vector(prim, Always{}, [&](int i, VU masks, VF) HWY_ATTR {
        hn::Store(hn::Or(hn::Load(kU, piece.open + i), masks), kU, piece.open + i);
    });
}

template <class Use>
HWY_INLINE void for_each_in(const BinRange& range, Use&& use)
{
    const auto lanes = static_cast<int>(hn::Lanes(kF));
    for (int stripe = range.stripe0; stripe <= range.stripe1; ++stripe) {
        const int first = stripe * kSubTilesPerStripe;
        for (int i = range.group0 * kSubTilesAcross; i < (range.group1 + 1) * kSubTilesAcross;
             i += lanes) {
            use(first + i);
        }
    }
}

void clear(const BinRange& range, PieceBin& piece)
{
    for_each_in(range, [&](int i) HWY_ATTR {
        hn::Store(hn::Zero(kU), kU, piece.touched + i);
        hn::Store(hn::Zero(kU), kU, piece.open + i);
        hn::Store(hn::Zero(kF), kF, piece.depth + i);
    });
}

void merge(const BinRange& range, const PieceBin& piece, MaskedBin& bin)
{
    for_each_in(range, [&](int i) HWY_ATTR {
        const VU covered =
            hn::AndNot(hn::Load(kU, piece.open + i), hn::Load(kU, piece.touched + i));
        merge_layers(covered, hn::Load(kF, piece.depth + i), bin, i);
    });
}

float farthest(const MaskedBin& bin)
{
    const auto lanes = static_cast<int>(hn::Lanes(kF));
    VF most = hn::Zero(kF);
    for (int i = 0; i < kSubTiles; i += lanes) {
        most = hn::Max(most, hn::Load(kF, bin.far_depth + i));
    }
    return hn::GetLane(hn::MaxOfLanes(kF, most));
}

} // namespace

const BinKernels* bin_kernel_table()
{
    static constexpr BinKernels kKernels{&lower, &touch, &open, &clear, &merge, &farthest};
    return &kKernels;
}

#endif

} // namespace occlude::cpu_fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace occlude::cpu_fast {
HWY_EXPORT(bin_kernel_table);

const BinKernels& simd_bin_kernels()
{
    return *HWY_DYNAMIC_DISPATCH(bin_kernel_table)();
}

} // namespace occlude::cpu_fast
#endif
