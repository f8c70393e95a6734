// Filling one tile: by vectors, and one cell after the other as the specification says.
#pragma once

#include <occlude/backends/cpu_fast/detail/prim.h>
#include <occlude/screen/kernel.h>

#include <cstddef>
#include <span>

namespace occlude::cpu_fast {

/// The depth of one piece in one tile, row by row: kUntouched, the farthest of what touches the
/// cell, or kErased.
struct PieceTile {
    alignas(64) float depth[kTileWidth * kTileHeight];
};

/// A tile of the depth of all occluders; `columns` of them are on the grid.
struct DepthTile {
    float* depth = nullptr; ///< of its first cell
    ptrdiff_t stride = 0;
    int columns = 0;
};

/// The inner loops. Rectangles are cells of the tile, and not empty.
struct TileKernels {
    /// Raises the cells of the piece where all edge functions reach the threshold.
    void (*raise)(const TilePrim& prim, PieceTile& piece);
    /// Lowers the cells of the tile there.
    void (*lower)(const TilePrim& prim, const DepthTile& tile);
    void (*clear)(const CellRect& cells, PieceTile& piece);
    /// Lowers the cells of the tile to the piece, where it is touched and not erased.
    void (*merge)(const CellRect& cells, const PieceTile& piece, const DepthTile& tile);
};

const TileKernels& tile_kernels(Kernel kernel);

/// Fills what the batches have for tile (tx, ty).
void fill_tile(const TileKernels& kernels, std::span<const PrimBatch> batches, int tx, int ty,
               size_t tile_index, const DepthTile& tile, PieceTile& scratch);

namespace scalar {
void raise(const TilePrim& prim, PieceTile& piece);
/// From column `first` of the prim's cells on, if that is later than they start.
void lower_from(const TilePrim& prim, const DepthTile& tile, int row, int first);
void lower(const TilePrim& prim, const DepthTile& tile);
void clear(const CellRect& cells, PieceTile& piece);
void merge(const CellRect& cells, const PieceTile& piece, const DepthTile& tile);
} // namespace scalar

const TileKernels& simd_tile_kernels();

} // namespace occlude::cpu_fast
