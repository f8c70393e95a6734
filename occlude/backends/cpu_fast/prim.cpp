#include <occlude/backends/cpu_fast/detail/prim.h>

#include <algorithm>
#include <cmath>

namespace occlude::cpu_fast {

namespace {

// The cells of the grid that meet the range after they grew by `growth` subcells.
CellRect cells_touched(const std::array<int32_t, 3>& x, const std::array<int32_t, 3>& y,
                       float growth_cells, glm::ivec2 size)
{
    const auto growth =
        static_cast<int32_t>(std::ceil(growth_cells * static_cast<float>(kSubcells)));
    const auto first = [&](const std::array<int32_t, 3>& v) {
        return std::max((std::min({v[0], v[1], v[2]}) - growth - 1) >> kSubcellBits, 0);
    };
    const auto last = [&](const std::array<int32_t, 3>& v, int side) {
        return std::min((std::max({v[0], v[1], v[2]}) + growth) >> kSubcellBits, side - 1);
    };
    CellRect rect;
    const int x1 = last(x, size.x);
    const int y1 = last(y, size.y);
    if (x1 < 0 || y1 < 0 || first(x) > x1 || first(y) > y1) {
        return rect;
    }
    rect.x0 = static_cast<int16_t>(first(x));
    rect.y0 = static_cast<int16_t>(first(y));
    rect.x1 = static_cast<int16_t>(x1);
    rect.y1 = static_cast<int16_t>(y1);
    return rect;
}

void set_edge(Prim& prim, size_t i, const Corner& from, const Corner& to)
{
    const auto dx = static_cast<float>(to.x - from.x);
    const auto dy = static_cast<float>(to.y - from.y);
    const float scale = 1.0f / (std::abs(dx) + std::abs(dy));
    prim.nx[i] = -dy * scale;
    prim.ny[i] = dx * scale;
    prim.x[i] = from.x;
    prim.y[i] = from.y;
}

} // namespace

bool make_triangle(const Corner& a, const Corner& b, const Corner& c, PrimKind kind,
                   const Growth& growth, glm::ivec2 size_cells, Prim& prim)
{
    const CellRect cells =
        cells_touched({a.x, b.x, c.x}, {a.y, b.y, c.y}, growth.touch, size_cells);
    const float z_max = std::max({a.z, b.z, c.z});
    // Triangles beyond the far plane are not drawn, but count: their depth, 1 or more, hides
    // nothing in all cells that they touch.
    if (cells.empty()) {
        return false;
    }
    prim = {};
    set_edge(prim, 0, a, b);
    set_edge(prim, 1, b, c);
    set_edge(prim, 2, c, a);
    constexpr double kCells = 1.0 / kSubcells;
    const double bx = (b.x - a.x) * kCells;
    const double by = (b.y - a.y) * kCells;
    const double cx = (c.x - a.x) * kCells;
    const double cy = (c.y - a.y) * kCells;
    const double scale = 1.0 / (bx * cy - by * cx);
    const double bz = double{b.z} - double{a.z};
    const double cz = double{c.z} - double{a.z};
    prim.zx = static_cast<float>((bz * cy - cz * by) * scale);
    prim.zy = static_cast<float>((cz * bx - bz * cx) * scale);
    prim.z = a.z;
    prim.z_max = z_max;
    prim.cells = cells;
    prim.kind = kind;
    prim.growth = growth.touch + kRounding;
    prim.threshold = kind == PrimKind::alone ? 0.5f + growth.edge : -(0.5f + growth.touch);
    return true;
}

bool make_edge(const Corner& a, const Corner& b, const Growth& growth, glm::ivec2 size_cells,
               Prim& prim)
{
    const CellRect cells = cells_touched({a.x, b.x, b.x}, {a.y, b.y, b.y}, growth.edge, size_cells);
    if (cells.empty() || (a.x == b.x && a.y == b.y)) {
        return false;
    }
    prim = {};
    set_edge(prim, 0, a, b);
    set_edge(prim, 1, b, a);
    prim.z = kErased;
    prim.z_max = kErased;
    prim.cells = cells;
    prim.kind = PrimKind::edge;
    prim.threshold = -(0.5f + growth.edge);
    return true;
}

bool meets_tile(const Prim& prim, int tx, int ty)
{
    const float x = (static_cast<float>(tx) + 0.5f) * static_cast<float>(kTileWidth);
    const float y = (static_cast<float>(ty) + 0.5f) * static_cast<float>(kTileHeight);
    constexpr float kCells = 1.0f / static_cast<float>(kSubcells);
    for (size_t i = 0; i < 3; ++i) {
        const float middle = prim.nx[i] * (x - static_cast<float>(prim.x[i]) * kCells) +
                             prim.ny[i] * (y - static_cast<float>(prim.y[i]) * kCells);
        const float most = middle + std::abs(prim.nx[i]) * static_cast<float>(kTileWidth / 2) +
                           std::abs(prim.ny[i]) * static_cast<float>(kTileHeight / 2);
        if (most < -2.0f) { // any growth, and rounding
            return false;
        }
    }
    return true;
}

} // namespace occlude::cpu_fast
