// The masked depth of one bin of the grid, and of one piece of a mesh while it is drawn into it.
//
// Implements  J. Hasselgren, M. Andersson, T. Akenine-Moeller, "Masked Software Occlusion Culling",
//             HPG 2016: two depths and a mask per sub-tile of 8x4 cells, merged conservatively.
// Deviations  Coverage is that of whole cells, in the cell's worst place, instead of pixel centres.
//             The nearer layer is also restarted where the new triangle covers all of it, and kept
//             where a triangle behind it covers the whole sub-tile: neither loses anything.
#pragma once

#include <occlude/backends/cpu_fast/detail/prim.h>

#include <algorithm>
#include <cstdint>

namespace occlude::cpu_fast {

constexpr int kStripes = kBinWidth / kStripeWidth;
constexpr int kSubTilesAcross = kStripeWidth / kSubTileWidth;
constexpr int kGroups = kBinHeight / kSubTileHeight;
constexpr int kSubTilesPerStripe = kGroups * kSubTilesAcross;
constexpr int kSubTiles = kStripes * kSubTilesPerStripe;
constexpr uint32_t kWholeSubTile = ~0u;

/// Where the sub-tile of a cell of the bin is: by stripes, then by groups of four rows.
constexpr int sub_tile_index(int x, int y)
{
    return x / kStripeWidth * kSubTilesPerStripe + y / kSubTileHeight * kSubTilesAcross +
           x % kStripeWidth / kSubTileWidth;
}

/// Cells in the mask hide what is farther than near_depth, the others what is farther than
/// far_depth. near_depth < far_depth; without a cell in the mask near_depth is 0.
struct MaskedBin {
    /// Arrays do not start in the same lines of the cache.
    static constexpr int kSkew = 16;

    alignas(64) float far_depth[kSubTiles + kSkew];
    alignas(64) float near_depth[kSubTiles + kSkew];
    alignas(64) uint32_t mask[kSubTiles + kSkew];
};

/// A piece in a bin: the cells that its triangles touch, the cells that its open edges touch, and
/// the farthest depth of the triangles that touch the sub-tile.
struct PieceBin {
    alignas(64) uint32_t touched[kSubTiles + MaskedBin::kSkew];
    alignas(64) uint32_t open[kSubTiles + MaskedBin::kSkew];
    alignas(64) float depth[kSubTiles + MaskedBin::kSkew];
};

/// Stripes of a bin, and groups of four rows by fours, the most that a vector holds; inclusive.
struct BinRange {
    int stripe0 = kStripes;
    int stripe1 = -1;
    int group0 = kGroups;
    int group1 = -1;

    /// Also the cells of the grid that lie in the bin whose first cell is (ox, oy).
    void add(const CellRect& cells, int ox, int oy)
    {
        const int y0 = std::max(cells.y0 - oy, 0) / kSubTileHeight;
        const int y1 = std::min(cells.y1 - oy, kBinHeight - 1) / kSubTileHeight;
        stripe0 = std::min(stripe0, std::max(cells.x0 - ox, 0) / kStripeWidth);
        stripe1 = std::max(stripe1, std::min(cells.x1 - ox, kBinWidth - 1) / kStripeWidth);
        group0 = std::min(group0, y0 & ~3);
        group1 = std::max(group1, y1 | 3);
    }
};

} // namespace occlude::cpu_fast
