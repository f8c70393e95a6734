// What the rasteriser fills: triangles and open edges, on a grid of cells.
//
// A cell is a square of the grid, one pixel or a few of the target. Cell (i, j) reaches from (i, j)
// to (i + 1, j + 1); row 0 is the bottom row. Positions are snapped to 1/256 cell, and everything
// after that is exact or rounds by less than kRounding.
#pragma once

#include <glm/vec2.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace occlude::cpu_fast {

constexpr int kSubcellBits = 8;
constexpr int32_t kSubcells = 1 << kSubcellBits;
/// The largest side of a grid, in cells.
constexpr int kMaxSide = 4096;
/// Cells of one tile, the unit of work of a thread.
constexpr int kTileWidth = 64;
constexpr int kTileHeight = 32;

/// By how much edge functions and bounds may be off when they are compared, in cells: positions up
/// to 2^14 cells away, edge normals of 24 bits.
constexpr float kRounding = 0x1p-8f;
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

/// Depth of cells that a piece does not touch, and that an open edge takes away from it.
constexpr float kUntouched = -1.0f;
constexpr float kErased = 2.0f;

enum class PrimKind : uint8_t {
    triangle, ///< raises the depth of its piece in the cells that it touches
    edge,     ///< takes the cells that it touches away from its piece
    alone,    ///< a piece of one triangle, all of whose edges are open: lowers depth inside of it
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

/// Something to fill, in the coordinates of the whole grid.
struct Prim {
    /// Edge functions nx * x + ny * y + c, in cells, positive inside; |nx| + |ny| = 1, or all 0. c
    /// is that of the corner.
    std::array<float, 3> nx{};
    std::array<float, 3> ny{};
    std::array<int32_t, 3> x{};
    std::array<int32_t, 3> y{};
    float zx = 0.0f; ///< depth per cell
    float zy = 0.0f;
    float z = 0.0f;         ///< depth at the first corner
    float z_max = 0.0f;     ///< nothing of it is farther
    float growth = 0.0f;    ///< depth is that of cells that grew by this
    float threshold = 0.0f; ///< a cell counts where all edge functions are at least this
    CellRect cells;
    uint32_t piece = 0;
    PrimKind kind = PrimKind::triangle;
};

/// A triangle, its corners counter-clockwise on the grid. False if it touches no cell of the grid.
/// Precondition: its area is positive.
bool make_triangle(const Corner& a, const Corner& b, const Corner& c, PrimKind kind,
                   const Growth& growth, glm::ivec2 size_cells, Prim& prim);
/// A band around an edge. False if it has no length, or touches no cell of the grid.
bool make_edge(const Corner& a, const Corner& b, const Growth& growth, glm::ivec2 size_cells,
               Prim& prim);
/// False only if the prim touches no cell of tile (tx, ty).
bool meets_tile(const Prim& prim, int tx, int ty);

/// The same in one tile: coordinates are cells from its corner, at the cells' middles.
struct TilePrim {
    std::array<float, 3> nx{};
    std::array<float, 3> ny{};
    std::array<float, 3> c{};
    float threshold = 0.0f; ///< a cell counts where all edge functions are at least this
    float zx = 0.0f;
    float zy = 0.0f;
    float z = 0.0f;
    float z_max = 0.0f;
    CellRect cells;
};

/// What one thread makes of some occluders: prims, and which of them each tile needs. Pieces never
/// straddle batches.
struct PrimBatch {
    std::vector<Prim> prims;
    std::vector<std::vector<uint32_t>> tiles;
    uint32_t piece_count = 0;
    uint64_t instances = 0;
    uint64_t triangles = 0;

    void clear(size_t tile_count)
    {
        prims.clear();
        tiles.resize(tile_count);
        for (std::vector<uint32_t>& tile : tiles) {
            tile.clear();
        }
        piece_count = 0;
        instances = 0;
        triangles = 0;
    }
};

} // namespace occlude::cpu_fast
