// Filling one bin: by vectors, and one sub-tile after the other as the specification says.
#pragma once

#include <occlude/backends/cpu_fast/detail/masked_bin.h>
#include <occlude/backends/cpu_fast/detail/prim.h>
#include <occlude/screen/kernel.h>

#include <algorithm>
#include <span>

namespace occlude::cpu_fast {

/// A prim as it lies in one bin: columns and rows count from the bin's first cell.
struct BinPrim {
    std::array<Line, 2> left;
    std::array<Line, 2> right;
    float zx = 0.0f;
    float zy = 0.0f;
    float z = 0.0f;
    float z_max = 0.0f;
    int x0 = 0; ///< inclusive
    int y0 = 0;
    int x1 = -1;
    int y1 = -1;

    /// Of the bin whose first cell is (ox, oy).
    BinPrim(const Prim& prim, int ox, int oy)
        : left(prim.left)
        , right(prim.right)
        , zx(prim.zx)
        , zy(prim.zy)
        , z_max(prim.z_max)
        , x0(std::max(prim.cells.x0 - ox, 0))
        , y0(std::max(prim.cells.y0 - oy, 0))
        , x1(std::min(prim.cells.x1 - ox, kBinWidth - 1))
        , y1(std::min(prim.cells.y1 - oy, kBinHeight - 1))
    {
        const auto columns = static_cast<float>(ox - prim.cells.x0);
        const auto rows = static_cast<float>(oy - prim.cells.y0);
        for (size_t i = 0; i < 2; ++i) {
            left[i].at = (left[i].at + left[i].slope * rows) - columns;
            right[i].at = (right[i].at + right[i].slope * rows) - columns;
        }
        z = (prim.z + prim.zx * columns) + prim.zy * rows;
    }
    int cells() const { return (x1 - x0 + 1) * (y1 - y0 + 1); }
};

/// The inner loops.
struct BinKernels {
    /// Hides what is behind the prim in the cells that it fills.
    void (*lower)(const BinPrim& prim, MaskedBin& bin);
    /// Adds the cells that the prim fills, and its depth, to those that the piece touches.
    void (*touch)(const BinPrim& prim, PieceBin& piece);
    /// Adds the cells that the prim fills to those that open edges touch.
    void (*open)(const BinPrim& prim, PieceBin& piece);
    void (*clear)(const BinRange& range, PieceBin& piece);
    /// Hides what is behind the piece in the cells that it touches and no open edge touches.
    void (*merge)(const BinRange& range, const PieceBin& piece, MaskedBin& bin);
    /// The farthest depth of all sub-tiles.
    float (*farthest)(const MaskedBin& bin);
};

const BinKernels& bin_kernels(Kernel kernel);
const BinKernels& simd_bin_kernels();

/// Makes a bin of which the first `width` x `height` cells are on the grid hide nothing.
void reset(MaskedBin& bin, int width, int height);

/// Fills what the batches have for the bin whose first cell is (ox, oy) and of which nothing is
/// farther than `far_depth`. Returns its farthest depth from now on.
float fill_bin(const BinKernels& kernels, std::span<const PrimBatch> batches, size_t bin_index,
               int ox, int oy, float far_depth, MaskedBin& bin, PieceBin& scratch);

namespace scalar {
/// The rule of the two layers, for one sub-tile: `covered` cells hide what is behind `depth`.
void merge_layer(uint32_t covered, float depth, float& far_depth, float& near_depth,
                 uint32_t& mask);
} // namespace scalar

} // namespace occlude::cpu_fast
