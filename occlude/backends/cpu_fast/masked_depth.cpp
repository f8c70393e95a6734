#include <occlude/backends/cpu_fast/detail/masked_depth.h>

#include <occlude/backends/cpu_fast/detail/bin_raster.h>

#include <algorithm>
#include <array>
#include <bit>

namespace occlude::cpu_fast {

namespace {

// Bits of columns [first, last] in each row of a sub-tile, and of its rows [first, last].
constexpr std::array<uint32_t, kSubTileWidth* kSubTileWidth> kColumns = [] {
    std::array<uint32_t, kSubTileWidth * kSubTileWidth> masks{};
    for (uint32_t first = 0; first < kSubTileWidth; ++first) {
        for (uint32_t last = first; last < kSubTileWidth; ++last) {
            const uint32_t row = (0xffu << first) & (0xffu >> (kSubTileWidth - 1 - last));
            masks[first * kSubTileWidth + last] = row * 0x01010101u;
        }
    }
    return masks;
}();
constexpr std::array<uint32_t, kSubTileHeight* kSubTileHeight> kRows = [] {
    std::array<uint32_t, kSubTileHeight * kSubTileHeight> masks{};
    for (uint32_t first = 0; first < kSubTileHeight; ++first) {
        for (uint32_t last = first; last < kSubTileHeight; ++last) {
            masks[first * kSubTileHeight + last] =
                (~0u << (kSubTileWidth * first)) &
                (~0u >> (kSubTileWidth * (kSubTileHeight - 1 - last)));
        }
    }
    return masks;
}();

// The cells [x0, x1] x [y0, y1] of the bin that lie in the sub-tile at (x, y).
uint32_t cells_of(int x, int y, const CellRect& r)
{
    const int x0 = std::max(r.x0 - x, 0);
    const int y0 = std::max(r.y0 - y, 0);
    const int x1 = std::min(r.x1 - x, kSubTileWidth - 1);
    const int y1 = std::min(r.y1 - y, kSubTileHeight - 1);
    return kColumns[static_cast<size_t>(x0 * kSubTileWidth + x1)] &
           kRows[static_cast<size_t>(y0 * kSubTileHeight + y1)];
}

// Whether sub-tiles [begin, end) hide it, whichever of their cells are asked about.
bool all_hide(const MaskedBin& bin, int begin, int end, float nearest)
{
    float most = 0.0f;
    for (int i = begin; i < end; ++i) {
        most = most < bin.far_depth[i] ? bin.far_depth[i] : most;
    }
    return most < nearest;
}

// Cells of the bin.
bool bin_hides(const MaskedBin& bin, const CellRect& r, float nearest)
{
    for (int x = r.x0 & -kSubTileWidth; x <= r.x1; x += kSubTileWidth) {
        if (x % kStripeWidth == 0 && x + kStripeWidth - 1 <= r.x1 &&
            all_hide(bin, sub_tile_index(x, r.y0), sub_tile_index(x, r.y1) + kSubTilesAcross,
                     nearest)) {
            x += kStripeWidth - kSubTileWidth; // the whole width of a stripe
            continue;
        }
        for (int y = r.y0 & -kSubTileHeight; y <= r.y1; y += kSubTileHeight) {
            const int i = sub_tile_index(x, y);
            if (bin.far_depth[i] < nearest) {
                continue;
            }
            const uint32_t cells = cells_of(x, y, r);
            if ((cells & ~bin.mask[i]) != 0 || !(bin.near_depth[i] < nearest)) {
                return false;
            }
        }
    }
    return true;
}

} // namespace

void MaskedDepth::clear(const Grid& grid)
{
    grid_ = grid;
    const size_t count = grid.bin_count();
    if (bins_.size() < count) {
        bins_ = std::vector<MaskedBin>(count);
    }
    farthest_.assign(count, 1.0f);
    written_.assign(count, 0);
}

MaskedBin& MaskedDepth::write(size_t bin)
{
    if (written_[bin] == 0) {
        written_[bin] = 1;
        const auto across = static_cast<size_t>(grid_.size_bins.x);
        const int x = static_cast<int>(bin % across) * kBinWidth;
        const int y = static_cast<int>(bin / across) * kBinHeight;
        reset(bins_[bin], grid_.size_cells.x - x, grid_.size_cells.y - y);
    }
    return bins_[bin];
}

// The depth of one cell.
float MaskedDepth::depth_at(int x, int y) const
{
    const size_t index = grid_.bin_index(x / kBinWidth, y / kBinHeight);
    if (written_[index] == 0) {
        return 1.0f;
    }
    const MaskedBin& bin = bins_[index];
    const int i = sub_tile_index(x % kBinWidth, y % kBinHeight);
    const int bit = y % kSubTileHeight * kSubTileWidth + x % kSubTileWidth;
    return (bin.mask[i] >> bit & 1) != 0 ? bin.near_depth[i] : bin.far_depth[i];
}

bool MaskedDepth::hides(const CellRect& cells, float nearest) const
{
    // Of what can be seen, the middle mostly can.
    if (!(depth_at((cells.x0 + cells.x1) / 2, (cells.y0 + cells.y1) / 2) < nearest)) {
        return false;
    }
    for (int ty = cells.y0 / kBinHeight; ty <= cells.y1 / kBinHeight; ++ty) {
        for (int tx = cells.x0 / kBinWidth; tx <= cells.x1 / kBinWidth; ++tx) {
            const size_t bin = grid_.bin_index(tx, ty);
            if (farthest_[bin] < nearest) {
                continue;
            }
            if (written_[bin] == 0) {
                return false;
            }
            const CellRect inside{
                static_cast<int16_t>(std::max(cells.x0 - tx * kBinWidth, 0)),
                static_cast<int16_t>(std::max(cells.y0 - ty * kBinHeight, 0)),
                static_cast<int16_t>(std::min(cells.x1 - tx * kBinWidth, kBinWidth - 1)),
                static_cast<int16_t>(std::min(cells.y1 - ty * kBinHeight, kBinHeight - 1))};
            if (!bin_hides(bins_[bin], inside, nearest)) {
                return false;
            }
        }
    }
    return true;
}

void MaskedDepth::expand(std::span<float> out) const
{
    const glm::ivec2 size = grid_.size_cells;
    for (int y = 0; y < size.y; ++y) {
        float* row = out.data() + static_cast<ptrdiff_t>(y) * size.x;
        for (int x = 0; x < size.x; x += kSubTileWidth) {
            const size_t index = grid_.bin_index(x / kBinWidth, y / kBinHeight);
            const int count = std::min(kSubTileWidth, size.x - x);
            if (written_[index] == 0) {
                std::fill(row + x, row + x + count, 1.0f);
                continue;
            }
            const MaskedBin& bin = bins_[index];
            const int i = sub_tile_index(x % kBinWidth, y % kBinHeight);
            const uint32_t bits = bin.mask[i] >> (y % kSubTileHeight * kSubTileWidth);
            for (int k = 0; k < count; ++k) {
                row[x + k] = (bits >> k & 1) != 0 ? bin.near_depth[i] : bin.far_depth[i];
            }
        }
    }
}

} // namespace occlude::cpu_fast
