#include <occlude/backends/cpu_fast/detail/bin_raster.h>

#include <cmath>

namespace occlude::cpu_fast {

namespace {

constexpr float kSubTileMiddleX = 0.5f * (kSubTileWidth - 1);
constexpr float kSubTileMiddleY = 0.5f * (kSubTileHeight - 1);

// Prims that fill fewer cells than this are not worth finding the bin's farthest depth again.
constexpr int kManyCells = kBinWidth * kBinHeight / 4;

// Prims of a bin lie far apart: they are fetched while those before them are filled.
constexpr size_t kPrefetched = 12;

void prefetch([[maybe_unused]] const Prim& prim)
{
#if defined(__GNUC__) || defined(__clang__)
    __builtin_prefetch(&prim);
#endif
}

// The columns of a row that the prim fills; first > last if there are none.
void columns(const BinPrim& prim, int row, int& first, int& last)
{
    const auto y = static_cast<float>(row);
    const float low = std::max(prim.left[0].slope * y + prim.left[0].at,
                               prim.left[1].slope * y + prim.left[1].at);
    const float high = std::min(prim.right[0].slope * y + prim.right[0].at,
                                prim.right[1].slope * y + prim.right[1].at);
    const float from = std::min(std::max(low, static_cast<float>(prim.x0)), float{kBinWidth});
    const float to = std::max(std::min(high, static_cast<float>(prim.x1)), -1.0f);
    first = static_cast<int>(std::ceil(from));
    last = static_cast<int>(std::floor(to));
}

// The cells of one sub-tile that the prim fills.
uint32_t coverage(const BinPrim& prim, int x, int y)
{
    uint32_t mask = 0;
    for (int j = 0; j < kSubTileHeight; ++j) {
        if (y + j < prim.y0 || y + j > prim.y1) {
            continue;
        }
        int first = 0;
        int last = 0;
        columns(prim, y + j, first, last);
        first = std::max(first - x, 0);
        last = std::min(last - x, kSubTileWidth - 1);
        for (int i = first; i <= last; ++i) {
            mask |= 1u << (j * kSubTileWidth + i);
        }
    }
    return mask;
}

// Calls use(index, mask, depth) for each sub-tile in which the prim fills cells.
template <class Use>
void for_each_sub_tile(const BinPrim& prim, Use&& use)
{
    for (int y = prim.y0 & -kSubTileHeight; y <= prim.y1; y += kSubTileHeight) {
        for (int x = prim.x0 & -kSubTileWidth; x <= prim.x1; x += kSubTileWidth) {
            const uint32_t mask = coverage(prim, x, y);
            const float row = prim.zy * (static_cast<float>(y) + kSubTileMiddleY) + prim.z;
            const float depth =
                std::min(prim.zx * (static_cast<float>(x) + kSubTileMiddleX) + row, prim.z_max);
            if (mask != 0) {
                use(sub_tile_index(x, y), mask, depth);
            }
        }
    }
}

} // namespace

// Two layers: what the new one covers moves the nearer layer farther, so that the sub-tile gets
// farther from what it could say, until the layer covers everything and becomes the farther one.
void scalar::merge_layer(uint32_t covered, float depth, float& far_depth, float& near_depth,
                         uint32_t& mask)
{
    if (covered == 0 || !(depth < far_depth)) {
        return; // nothing that is not hidden already
    }
    const bool swallows = (mask & ~covered) == 0 && depth < near_depth;
    const bool much_nearer = near_depth - depth > far_depth - near_depth;
    const bool restart = swallows || much_nearer;
    const uint32_t merged = restart ? covered : covered | mask;
    const float merged_depth = restart ? depth : std::max(near_depth, depth);
    if (merged != kWholeSubTile) {
        mask = merged;
        near_depth = merged_depth;
        return;
    }
    const bool keep = covered == kWholeSubTile && near_depth < depth;
    far_depth = merged_depth;
    mask = keep ? mask : 0;
    near_depth = keep ? near_depth : 0.0f;
}

namespace {

void lower(const BinPrim& prim, MaskedBin& bin)
{
    for_each_sub_tile(prim, [&](int i, uint32_t mask, float depth) {
        scalar::merge_layer(mask, depth, bin.far_depth[i], bin.near_depth[i], bin.mask[i]);
    });
}

void touch(const BinPrim& prim, PieceBin& piece)
{
    for_each_sub_tile(prim, [&](int i, uint32_t mask, float depth) {
        piece.touched[i] |= mask;
        piece.depth[i] = std::max(piece.depth[i], depth);
    });
}

void open(const BinPrim& prim, PieceBin& piece)
{
    for_each_sub_tile(prim, [&](int i, uint32_t mask, float) { piece.open[i] |= mask; });
}

template <class Use>
void for_each_in(const BinRange& range, Use&& use)
{
    for (int stripe = range.stripe0; stripe <= range.stripe1; ++stripe) {
        const int first = stripe * kSubTilesPerStripe;
        for (int i = range.group0 * kSubTilesAcross; i < (range.group1 + 1) * kSubTilesAcross;
             ++i) {
            use(first + i);
        }
    }
}

void clear(const BinRange& range, PieceBin& piece)
{
    for_each_in(range, [&](int i) {
        piece.touched[i] = 0;
        piece.open[i] = 0;
        piece.depth[i] = 0.0f;
    });
}

void merge(const BinRange& range, const PieceBin& piece, MaskedBin& bin)
{
    for_each_in(range, [&](int i) {
        scalar::merge_layer(piece.touched[i] & ~piece.open[i], piece.depth[i], bin.far_depth[i],
                            bin.near_depth[i], bin.mask[i]);
    });
}

float farthest(const MaskedBin& bin)
{
    return *std::max_element(bin.far_depth, bin.far_depth + kSubTiles);
}

// One piece in one bin: its prims but those that are alone.
void fill_piece(const BinKernels& kernels, const PrimBatch& batch,
                std::span<const uint32_t> indices, int ox, int oy, MaskedBin& bin,
                PieceBin& scratch, float far_depth)
{
    BinRange all;
    size_t triangles = 0;
    size_t edges = 0;
    float nearest = 1.0f;
    const Prim* last = nullptr;
    for (const uint32_t index : indices) {
        const Prim& prim = batch.prims[index];
        if (prim.kind() == PrimKind::edge) {
            ++edges;
            continue;
        }
        all.add(prim.cells, ox, oy);
        nearest = std::min(nearest, prim.z_min);
        last = &prim;
        ++triangles;
    }
    if (triangles == 0 || nearest >= far_depth) {
        return;
    }
    if (triangles == 1 && edges == 0) {
        kernels.lower(BinPrim(*last, ox, oy), bin);
        return;
    }
    kernels.clear(all, scratch);
    for (const uint32_t index : indices) {
        const Prim& prim = batch.prims[index];
        BinPrim here(prim, ox, oy);
        if (prim.kind() == PrimKind::triangle) {
            kernels.touch(here, scratch);
            continue;
        }
        // Edges reach farther than the triangles, where nothing was cleared and nothing is merged.
        here.x0 = std::max(here.x0, all.stripe0 * kStripeWidth);
        here.x1 = std::min(here.x1, (all.stripe1 + 1) * kStripeWidth - 1);
        here.y0 = std::max(here.y0, all.group0 * kSubTileHeight);
        here.y1 = std::min(here.y1, (all.group1 + 1) * kSubTileHeight - 1);
        if (here.x0 <= here.x1 && here.y0 <= here.y1) {
            kernels.open(here, scratch);
        }
    }
    kernels.merge(all, scratch, bin);
}

} // namespace

const BinKernels& bin_kernels(Kernel kernel)
{
    static constexpr BinKernels kScalar{&lower, &touch, &open, &clear, &merge, &farthest};
    return kernel == Kernel::scalar ? kScalar : simd_bin_kernels();
}

void reset(MaskedBin& bin, int width, int height)
{
    std::fill(std::begin(bin.far_depth), std::end(bin.far_depth), 1.0f);
    std::fill(std::begin(bin.near_depth), std::end(bin.near_depth), 0.0f);
    std::fill(std::begin(bin.mask), std::end(bin.mask), 0u);
    if (width >= kBinWidth && height >= kBinHeight) {
        return;
    }
    for (int y = 0; y < kBinHeight; y += kSubTileHeight) {
        for (int x = 0; x < kBinWidth; x += kSubTileWidth) {
            if (x >= width || y >= height) {
                bin.far_depth[sub_tile_index(x, y)] = 0.0f;
            }
        }
    }
}

float fill_bin(const BinKernels& kernels, std::span<const PrimBatch> batches, size_t bin_index,
               int ox, int oy, float far_depth, MaskedBin& bin, PieceBin& scratch)
{
    bool stale = false; // then the bin is not farther than that
    for (const PrimBatch& batch : batches) {
        const std::span<const uint32_t> indices = batch.bins[bin_index];
        for (size_t begin = 0; begin < indices.size();) {
            const Prim& prim = batch.prims[indices[begin]];
            prefetch(batch.prims[indices[std::min(begin + kPrefetched, indices.size() - 1)]]);
            size_t end = begin + 1;
            if (prim.kind() == PrimKind::alone) {
                begin = end;
                if (prim.z_min >= far_depth) {
                    continue;
                }
                const BinPrim here(prim, ox, oy);
                if (stale && here.cells() >= kManyCells) {
                    far_depth = kernels.farthest(bin);
                    stale = false;
                    if (prim.z_min >= far_depth) {
                        continue;
                    }
                }
                kernels.lower(here, bin);
                stale = true;
                continue;
            }
            while (end < indices.size() &&
                   batch.prims[indices[end]].piece_and_kind >> 2 == prim.piece() &&
                   batch.prims[indices[end]].kind() != PrimKind::alone) {
                ++end;
            }
            if (stale) {
                far_depth = kernels.farthest(bin);
            }
            fill_piece(kernels, batch, indices.subspan(begin, end - begin), ox, oy, bin, scratch,
                       far_depth);
            stale = true;
            begin = end;
        }
    }
    return kernels.farthest(bin);
}

} // namespace occlude::cpu_fast
