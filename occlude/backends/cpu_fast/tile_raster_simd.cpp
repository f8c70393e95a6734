// The inner loops of the tile rasteriser with vectors: the cells of a row, a vector at a time, in
// the operations and the order of the scalar loops.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "occlude/backends/cpu_fast/tile_raster_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <occlude/backends/cpu_fast/detail/tile_raster.h>

#include <algorithm>
#include <array>
#include <cmath>

HWY_BEFORE_NAMESPACE();
namespace occlude::cpu_fast::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// At most 16 lanes, so that vectors tile the rows of a tile.
using F = hn::CappedTag<float, 16>;
constexpr F kF;
using VF = hn::Vec<F>;

// Which columns of a row can count at all: the edge functions cross the threshold there. A superset
// of them: rounding is paid for by kMargin.
struct Columns {
    explicit Columns(const TilePrim& prim)
        : prim_(prim)
    {
        for (size_t i = 0; i < 3; ++i) {
            // Edges that are nearly level cross it too slowly for the division to be exact.
            inverse_[i] = std::abs(prim.nx[i]) < 0x1p-8f ? 0.0f : 1.0f / prim.nx[i];
        }
    }

    void find(const std::array<float, 3>& row, int& first, int& last) const
    {
        constexpr float kMargin = 0.0625f;
        float from = static_cast<float>(prim_.cells.x0);
        float to = static_cast<float>(prim_.cells.x1);
        for (size_t i = 0; i < 3; ++i) {
            const float crossing = (prim_.threshold - row[i]) * inverse_[i];
            if (inverse_[i] > 0.0f) {
                from = std::max(from, crossing - kMargin);
            } else if (inverse_[i] < 0.0f) {
                to = std::min(to, crossing + kMargin);
            }
        }
        first = static_cast<int>(from);
        last = to < 0.0f ? -1 : static_cast<int>(to);
    }

private:
    const TilePrim& prim_;
    std::array<float, 3> inverse_{};
};

// Calls use(row of the tile, first column of a vector, mask, depth) for each vector of cells that
// may count.
struct PrimVectors {
    explicit PrimVectors(const TilePrim& prim)
        : nx0(hn::Set(kF, prim.nx[0]))
        , nx1(hn::Set(kF, prim.nx[1]))
        , nx2(hn::Set(kF, prim.nx[2]))
        , zx(hn::Set(kF, prim.zx))
        , z_max(hn::Set(kF, prim.z_max))
        , threshold(hn::Set(kF, prim.threshold))
        , low(hn::Set(kF, static_cast<float>(prim.cells.x0)))
        , high(hn::Set(kF, static_cast<float>(prim.cells.x1)))
    {
    }
    VF nx0, nx1, nx2, zx, z_max, threshold, low, high;
};

template <class Use>
HWY_INLINE void for_each_vector(const TilePrim& prim, Use&& use)
{
    const auto lanes = static_cast<int>(hn::Lanes(kF));
    const PrimVectors v(prim);
    const bool wide = prim.cells.x1 - prim.cells.x0 >= 2 * lanes;
    const Columns columns(prim);
    for (int j = prim.cells.y0; j <= prim.cells.y1; ++j) {
        const auto y = static_cast<float>(j);
        const std::array<float, 3> row{prim.ny[0] * y + prim.c[0], prim.ny[1] * y + prim.c[1],
                                       prim.ny[2] * y + prim.c[2]};
        int first = prim.cells.x0;
        int last = prim.cells.x1;
        if (wide) {
            columns.find(row, first, last);
        }
        const VF row0 = hn::Set(kF, row[0]);
        const VF row1 = hn::Set(kF, row[1]);
        const VF row2 = hn::Set(kF, row[2]);
        const VF row_z = hn::Set(kF, prim.zy * y + prim.z);
        for (int i = first & -lanes; i <= last; i += lanes) {
            const VF x = hn::Iota(kF, static_cast<float>(i));
            const VF e0 = hn::Add(hn::Mul(v.nx0, x), row0);
            const VF e1 = hn::Add(hn::Mul(v.nx1, x), row1);
            const VF e2 = hn::Add(hn::Mul(v.nx2, x), row2);
            const VF least = hn::Min(hn::Min(e0, e1), e2);
            const auto inside = hn::And(hn::Ge(x, v.low), hn::Le(x, v.high));
            const auto counts = hn::And(hn::Ge(least, v.threshold), inside);
            const VF z = hn::Min(hn::Add(hn::Mul(v.zx, x), row_z), v.z_max);
            use(j, i, counts, z);
        }
    }
}

void raise(const TilePrim& prim, PieceTile& piece)
{
    for_each_vector(prim, [&](int j, int i, auto counts, VF z) HWY_ATTR {
        float* cells = piece.depth + j * kTileWidth + i;
        const VF depth = hn::Load(kF, cells);
        hn::Store(hn::IfThenElse(counts, hn::Max(depth, z), depth), kF, cells);
    });
}

void lower(const TilePrim& prim, const DepthTile& tile)
{
    const auto lanes = static_cast<int>(hn::Lanes(kF));
    for_each_vector(prim, [&](int j, int i, auto counts, VF z) HWY_ATTR {
        if (i + lanes > tile.columns) { // the next row is another thread's
            scalar::lower_from(prim, tile, j, i);
            return;
        }
        float* cells = tile.depth + j * tile.stride + i;
        const VF depth = hn::LoadU(kF, cells);
        hn::StoreU(hn::IfThenElse(counts, hn::Min(depth, z), depth), kF, cells);
    });
}

void clear(const CellRect& cells, PieceTile& piece)
{
    const auto lanes = static_cast<int>(hn::Lanes(kF));
    const VF untouched = hn::Set(kF, kUntouched);
    for (int j = cells.y0; j <= cells.y1; ++j) {
        for (int i = cells.x0 & -lanes; i <= cells.x1; i += lanes) {
            hn::Store(untouched, kF, piece.depth + j * kTileWidth + i);
        }
    }
}

// Cells beside the rectangle were cleared with it, or are another prim's of the same piece.
void merge(const CellRect& cells, const PieceTile& piece, const DepthTile& tile)
{
    const auto lanes = static_cast<int>(hn::Lanes(kF));
    for (int j = cells.y0; j <= cells.y1; ++j) {
        const float* from = piece.depth + j * kTileWidth;
        float* to = tile.depth + j * tile.stride;
        int i = cells.x0 & -lanes;
        for (; i <= cells.x1 && i + lanes <= tile.columns; i += lanes) {
            const VF raised = hn::Load(kF, from + i);
            const VF depth = hn::LoadU(kF, to + i);
            const auto touched = hn::Ge(raised, hn::Zero(kF));
            hn::StoreU(hn::IfThenElse(touched, hn::Min(depth, raised), depth), kF, to + i);
        }
        for (; i <= cells.x1; ++i) {
            if (from[i] >= 0.0f) {
                to[i] = std::min(to[i], from[i]);
            }
        }
    }
}

} // namespace occlude::cpu_fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace occlude::cpu_fast {
HWY_EXPORT(raise);
HWY_EXPORT(lower);
HWY_EXPORT(clear);
HWY_EXPORT(merge);

namespace {

void raise_dispatched(const TilePrim& prim, PieceTile& piece)
{
    HWY_DYNAMIC_DISPATCH(raise)(prim, piece);
}

void lower_dispatched(const TilePrim& prim, const DepthTile& tile)
{
    HWY_DYNAMIC_DISPATCH(lower)(prim, tile);
}

void clear_dispatched(const CellRect& cells, PieceTile& piece)
{
    HWY_DYNAMIC_DISPATCH(clear)(cells, piece);
}

void merge_dispatched(const CellRect& cells, const PieceTile& piece, const DepthTile& tile)
{
    HWY_DYNAMIC_DISPATCH(merge)(cells, piece, tile);
}

} // namespace

const TileKernels& simd_tile_kernels()
{
    static constexpr TileKernels kSimd{&raise_dispatched, &lower_dispatched, &clear_dispatched,
                                       &merge_dispatched};
    return kSimd;
}

} // namespace occlude::cpu_fast
#endif
