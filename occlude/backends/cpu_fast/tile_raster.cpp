#include <occlude/backends/cpu_fast/detail/tile_raster.h>

#include <algorithm>
#include <cmath>

namespace occlude::cpu_fast {

namespace {

// Cells of the grid as cells of the tile at (ox, oy).
CellRect in_tile(const CellRect& cells, int ox, int oy)
{
    const auto within = [](int value, int size) {
        return static_cast<int16_t>(std::clamp(value, -1, size));
    };
    CellRect rect{within(cells.x0 - ox, kTileWidth), within(cells.y0 - oy, kTileHeight),
                  within(cells.x1 - ox, kTileWidth - 1), within(cells.y1 - oy, kTileHeight - 1)};
    rect.x0 = std::max<int16_t>(rect.x0, 0);
    rect.y0 = std::max<int16_t>(rect.y0, 0);
    return rect;
}

CellRect united(const CellRect& a, const CellRect& b)
{
    return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

CellRect common(const CellRect& a, const CellRect& b)
{
    return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

// In double up to here: from here on everything is near.
TilePrim tile_prim(const Prim& prim, int ox, int oy, const CellRect& cells)
{
    TilePrim out;
    constexpr double kCells = 1.0 / kSubcells;
    for (size_t i = 0; i < 3; ++i) {
        out.nx[i] = prim.nx[i];
        out.ny[i] = prim.ny[i];
        const double x = ox + 0.5 - prim.x[i] * kCells;
        const double y = oy + 0.5 - prim.y[i] * kCells;
        out.c[i] = static_cast<float>(double{prim.nx[i]} * x + double{prim.ny[i]} * y);
    }
    out.threshold = prim.threshold;
    out.cells = cells;
    out.zx = prim.zx;
    out.zy = prim.zy;
    out.z_max = prim.z_max;
    if (prim.kind == PrimKind::edge) {
        out.z = prim.z;
        return out;
    }
    // The farthest of the cell after it grew, and what rounding may take away from it.
    const double slope = std::abs(double{prim.zx}) + std::abs(double{prim.zy});
    const double x = ox + 0.5 - prim.x[0] * kCells;
    const double y = oy + 0.5 - prim.y[0] * kCells;
    out.z = static_cast<float>(double{prim.z} + double{prim.zx} * x + double{prim.zy} * y +
                               slope * (0.5 + double{prim.growth}) + 0x1p-21);
    return out;
}

} // namespace

void scalar::raise(const TilePrim& prim, PieceTile& piece)
{
    for (int j = prim.cells.y0; j <= prim.cells.y1; ++j) {
        const auto y = static_cast<float>(j);
        const float row0 = prim.ny[0] * y + prim.c[0];
        const float row1 = prim.ny[1] * y + prim.c[1];
        const float row2 = prim.ny[2] * y + prim.c[2];
        const float row_z = prim.zy * y + prim.z;
        float* depth = piece.depth + j * kTileWidth;
        for (int i = prim.cells.x0; i <= prim.cells.x1; ++i) {
            const auto x = static_cast<float>(i);
            const float least = std::min(std::min(prim.nx[0] * x + row0, prim.nx[1] * x + row1),
                                         prim.nx[2] * x + row2);
            if (least >= prim.threshold) {
                depth[i] = std::max(depth[i], std::min(prim.zx * x + row_z, prim.z_max));
            }
        }
    }
}

void scalar::lower_from(const TilePrim& prim, const DepthTile& tile, int j, int first)
{
    const auto y = static_cast<float>(j);
    const float row0 = prim.ny[0] * y + prim.c[0];
    const float row1 = prim.ny[1] * y + prim.c[1];
    const float row2 = prim.ny[2] * y + prim.c[2];
    const float row_z = prim.zy * y + prim.z;
    float* depth = tile.depth + j * tile.stride;
    for (int i = std::max<int>(first, prim.cells.x0); i <= prim.cells.x1; ++i) {
        const auto x = static_cast<float>(i);
        const float least =
            std::min(std::min(prim.nx[0] * x + row0, prim.nx[1] * x + row1), prim.nx[2] * x + row2);
        if (least >= prim.threshold) {
            depth[i] = std::min(depth[i], std::min(prim.zx * x + row_z, prim.z_max));
        }
    }
}

void scalar::lower(const TilePrim& prim, const DepthTile& tile)
{
    for (int j = prim.cells.y0; j <= prim.cells.y1; ++j) {
        lower_from(prim, tile, j, 0);
    }
}

void scalar::clear(const CellRect& cells, PieceTile& piece)
{
    for (int j = cells.y0; j <= cells.y1; ++j) {
        std::fill(piece.depth + j * kTileWidth + cells.x0,
                  piece.depth + j * kTileWidth + cells.x1 + 1, kUntouched);
    }
}

void scalar::merge(const CellRect& cells, const PieceTile& piece, const DepthTile& tile)
{
    for (int j = cells.y0; j <= cells.y1; ++j) {
        const float* from = piece.depth + j * kTileWidth;
        float* to = tile.depth + j * tile.stride;
        for (int i = cells.x0; i <= cells.x1; ++i) {
            if (from[i] >= 0.0f) {
                to[i] = std::min(to[i], from[i]);
            }
        }
    }
}

const TileKernels& tile_kernels(Kernel kernel)
{
    static constexpr TileKernels kScalar{&scalar::raise, &scalar::lower, &scalar::clear,
                                         &scalar::merge};
    return kernel == Kernel::scalar ? kScalar : simd_tile_kernels();
}

namespace {

// One piece in one tile: prims [begin, end) of the tile's list.
void fill_piece(const TileKernels& kernels, const PrimBatch& batch,
                std::span<const uint32_t> indices, int ox, int oy, const DepthTile& tile,
                PieceTile& scratch)
{
    CellRect all{kTileWidth, kTileHeight, -1, -1};
    size_t raised = 0;
    size_t edges = 0;
    const Prim* last = nullptr;
    for (const uint32_t index : indices) {
        const Prim& prim = batch.prims[index];
        const CellRect cells = in_tile(prim.cells, ox, oy);
        if (prim.kind == PrimKind::alone) {
            kernels.lower(tile_prim(prim, ox, oy, cells), tile);
        } else if (prim.kind == PrimKind::triangle) {
            all = united(all, cells);
            last = &prim;
            ++raised;
        } else {
            ++edges;
        }
    }
    if (raised == 0) {
        return;
    }
    if (raised == 1 && edges == 0) {
        kernels.lower(tile_prim(*last, ox, oy, all), tile);
        return;
    }
    kernels.clear(all, scratch);
    for (const uint32_t index : indices) {
        const Prim& prim = batch.prims[index];
        const CellRect cells = common(in_tile(prim.cells, ox, oy), all);
        if (prim.kind != PrimKind::alone && !cells.empty()) {
            kernels.raise(tile_prim(prim, ox, oy, cells), scratch);
        }
    }
    kernels.merge(all, scratch, tile);
}

} // namespace

void fill_tile(const TileKernels& kernels, std::span<const PrimBatch> batches, int tx, int ty,
               size_t tile_index, const DepthTile& tile, PieceTile& scratch)
{
    const int ox = tx * kTileWidth;
    const int oy = ty * kTileHeight;
    for (const PrimBatch& batch : batches) {
        const std::span<const uint32_t> indices = batch.tiles[tile_index];
        for (size_t begin = 0; begin < indices.size();) {
            const uint32_t piece = batch.prims[indices[begin]].piece;
            size_t end = begin + 1;
            while (end < indices.size() && batch.prims[indices[end]].piece == piece) {
                ++end;
            }
            fill_piece(kernels, batch, indices.subspan(begin, end - begin), ox, oy, tile, scratch);
            begin = end;
        }
    }
}

} // namespace occlude::cpu_fast
