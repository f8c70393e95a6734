// What the rasteriser fills: triangles and open edges, on a grid of cells.
//
// A cell is a square of the grid, one pixel or a few of the target. Cell (i, j) reaches from (i, j)
// to (i + 1, j + 1); row 0 is the bottom row. Positions are snapped to 1/256 cell; everything after
// that is exact, or rounds by less than kRounding.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace occlude::cpu_fast {

constexpr int kSubcellBits = 8;
constexpr int32_t kSubcells = 1 << kSubcellBits;
/// The largest side of a grid, in cells.
constexpr int kMaxSide = 4096;

/// A sub-tile has one bit per cell in a mask of 32: bit 8 * row + column.
constexpr int kSubTileWidth = 8;
constexpr int kSubTileHeight = 4;
/// Columns that one word per row covers: four sub-tiles side by side.
constexpr int kStripeWidth = 32;
/// Cells of a bin, the unit of work of a thread.
constexpr int kBinWidth = 256;
constexpr int kBinHeight = 64;

/// By how much lines and bounds may be off where they are compared, in cells. Lines are in float:
/// 5 roundings of 2^-24 over at most 2^14 cells.
constexpr float kRounding = 0x1p-7f;
/// What snapping here and there and the division may move a point of an occluder by, in cells.
constexpr float kSnapping = 1.0f / 128.0f;

/// How much cells grow for the comparisons of one instance, in cells.
struct Growth {
    /// For an instance whose points the transforms in float, there and here, may move by up to
    /// `displacement` cells.
    explicit Growth(float displacement = kLeastDisplacement)
        : touch(displacement + kSnapping + kRounding)
        , edge(touch + displacement + kSnapping + 2.0f * kRounding)
    {
    }
    static constexpr float kLeastDisplacement = 1.0f / 128.0f;
    static constexpr float kMostDisplacement = 1.0f / 4.0f;

    float touch; ///< a triangle counts for a cell that grew by this: wherever a device draws it
    float edge;  ///< an open edge counts for a cell that grew by this: before a device moves it in
};

enum class PrimKind : uint32_t {
    triangle, ///< touches cells of its piece, at its depth
    edge,     ///< takes the cells that it touches away from its piece
    alone,    ///< all of its edges are open: hides in the cells that lie inside of it
};

/// A corner on the grid.
struct Corner {
    int32_t x = 0; ///< 1/256 cell
    int32_t y = 0;
    float z = 0.0f; ///< window depth, 0 near to 1 far
};

/// Inclusive.
struct CellRect {
    int16_t x0 = 0;
    int16_t y0 = 0;
    int16_t x1 = -1;
    int16_t y1 = -1;

    bool empty() const { return x0 > x1 || y0 > y1; }
};

/// A line that bounds the columns of each row: slope * row + at.
struct Line {
    float slope = 0.0f;
    float at = 0.0f;
};

/// Something to fill: the cells of `cells` whose column is at least that of both left lines and at
/// most that of both right lines. Columns and rows are those of the cells' middles and count from
/// the first of `cells`.
struct alignas(16) Prim {
    std::array<Line, 2> left;
    std::array<Line, 2> right;
    float zx = 0.0f; ///< depth per column
    float zy = 0.0f; ///< depth per row
    /// The farthest depth of a grown sub-tile whose middle is at (0, 0); nothing is beyond z_max.
    float z = 0.0f;
    float z_max = 0.0f;
    CellRect cells;
    uint32_t piece_and_kind = 0;
    float z_min = 0.0f; ///< of the corners

    uint32_t piece() const { return piece_and_kind >> 2; }
    PrimKind kind() const { return static_cast<PrimKind>(piece_and_kind & 3); }
    static uint32_t pack(uint32_t piece, PrimKind kind)
    {
        return piece << 2 | static_cast<uint32_t>(kind);
    }
};
static_assert(sizeof(Prim) == 64, "one line of a cache");

/// Prims one behind the other. Room for them is not initialised, which would cost as much as
/// setting them up.
class PrimList {
public:
    /// Room for `count` more behind the last; add() then says how many of them there are.
    Prim* reserve(size_t count)
    {
        if (size_ + count > capacity_) {
            const size_t capacity = 2 * (size_ + count);
            auto larger = std::make_unique_for_overwrite<Prim[]>(capacity);
            for (size_t i = 0; i < size_; ++i) {
                larger[i] = prims_[i];
            }
            prims_ = std::move(larger);
            capacity_ = capacity;
        }
        return prims_.get() + size_;
    }
    void add(size_t count) { size_ += count; }
    void shrink(size_t size) { size_ = size; }
    size_t size() const { return size_; }
    Prim& operator[](size_t i) { return prims_[i]; }
    const Prim& operator[](size_t i) const { return prims_[i]; }

private:
    std::unique_ptr<Prim[]> prims_;
    size_t size_ = 0;
    size_t capacity_ = 0;
};

/// What one thread makes of some occluders: prims, and which of them each bin needs. Pieces never
/// straddle batches.
struct PrimBatch {
    PrimList prims;
    std::vector<std::vector<uint32_t>> bins;
    uint32_t piece_count = 0;
    uint64_t instances = 0;
    uint64_t triangles = 0;

    void clear(size_t bin_count)
    {
        prims.shrink(0);
        bins.resize(bin_count);
        for (std::vector<uint32_t>& bin : bins) {
            bin.clear();
        }
        piece_count = 0;
        instances = 0;
        triangles = 0;
    }
};

} // namespace occlude::cpu_fast
