#include <occlude/backends/cpu_fast/detail/triangle_setup.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace occlude::cpu_fast {

namespace {

constexpr size_t kMostLanes = 16;
constexpr float kCellsPerSubcell = 1.0f / static_cast<float>(kSubcells);

struct Extent {
    int32_t x0, y0, x1, y1; // 1/256 cell
};

Extent extent_of(const Corner& a, const Corner& b, const Corner& c)
{
    return {std::min({a.x, b.x, c.x}), std::min({a.y, b.y, c.y}), std::max({a.x, b.x, c.x}),
            std::max({a.y, b.y, c.y})};
}

int16_t clamped(int32_t value, int32_t low, int32_t high)
{
    return static_cast<int16_t>(std::min(std::max(value, low), high));
}

// The cells of the grid that the extent meets after they grew.
CellRect cells_touched(const Extent& extent, int32_t growth, glm::ivec2 size)
{
    return {clamped((extent.x0 - growth - 1) >> kSubcellBits, 0, size.x),
            clamped((extent.y0 - growth - 1) >> kSubcellBits, 0, size.y),
            clamped((extent.x1 + growth) >> kSubcellBits, -1, size.x - 1),
            clamped((extent.y1 + growth) >> kSubcellBits, -1, size.y - 1)};
}

// The cells of the grid that lie in the extent after they grew.
CellRect cells_inside(const Extent& extent, int32_t growth, glm::ivec2 size)
{
    constexpr int32_t kUp = kSubcells - 1;
    return {clamped((extent.x0 + growth + kUp) >> kSubcellBits, 0, size.x),
            clamped((extent.y0 + growth + kUp) >> kSubcellBits, 0, size.y),
            clamped(((extent.x1 - growth) >> kSubcellBits) - 1, -1, size.x - 1),
            clamped(((extent.y1 - growth) >> kSubcellBits) - 1, -1, size.y - 1)};
}

float cells(int32_t subcells)
{
    return static_cast<float>(subcells) * kCellsPerSubcell;
}

// Where an edge from (x, y) crosses the rows, moved outward by `outward` cells along rows. The edge
// function over |dx| + |dy| grows by 1 / (|slope| + 1) per column.
Line edge_line(float x, float y, float dx, float dy, float outward)
{
    const float slope = dx / (dy == 0.0f ? 1.0f : dy);
    const float moved = outward * (std::abs(slope) + 1.0f);
    const float at = x - slope * y;
    return {slope, dy < 0.0f ? at - moved : at + moved};
}

// The plane through the corners; its depth anywhere in a grown sub-tile around (0, 0).
void set_plane(Prim& prim, const Corner& a, const Corner& b, const Corner& c, const Extent& extent,
               float ax, float ay, float growth)
{
    const float bx = cells(b.x - a.x);
    const float by = cells(b.y - a.y);
    const float cx = cells(c.x - a.x);
    const float cy = cells(c.y - a.y);
    const float p = bx * cy;
    const float q = by * cx;
    const float area = p - q;
    const float terms = std::abs(p) + std::abs(q);
    prim.z_max = std::max(std::max(a.z, b.z), c.z);
    prim.z_min = std::min(std::min(a.z, b.z), c.z);
    if (!(area > terms * kThinnest)) {
        prim.zx = 0.0f;
        prim.zy = 0.0f;
        prim.z = prim.z_max;
        return;
    }
    const float inverse = 1.0f / area;
    const float bz = b.z - a.z;
    const float cz = c.z - a.z;
    prim.zx = (bz * cy - cz * by) * inverse;
    prim.zy = (cz * bx - bz * cx) * inverse;
    const float reach = cells((extent.x1 - extent.x0) + (extent.y1 - extent.y0)) + 16.0f;
    const float spread =
        std::abs(bz) * (std::abs(cx) + std::abs(cy)) + std::abs(cz) * (std::abs(bx) + std::abs(by));
    const float condition = 1.0f + terms * inverse;
    const float error = kPlaneRounding * condition * (spread * inverse) * reach;
    const float sub_tile = std::abs(prim.zx) * (0.5f * float{kSubTileWidth} + growth) +
                           std::abs(prim.zy) * (0.5f * float{kSubTileHeight} + growth);
    prim.z = ((a.z - prim.zx * ax) - prim.zy * ay) + (sub_tile + (error + kDepthRounding));
}

uint32_t code_of(const glm::vec4& c, const InstanceTransform& t)
{
    uint32_t code = c.w >= t.least_w ? 0 : kBeforeLeastW;
    code |= c.z < t.least_z ? kBeforeNear : 0;
    code |= c.x < t.guard_low.x * c.w ? kBeyondGuardLeft : 0;
    code |= c.x > t.guard_high.x * c.w ? kBeyondGuardRight : 0;
    code |= c.y < t.guard_low.y * c.w ? kBeyondGuardBottom : 0;
    code |= c.y > t.guard_high.y * c.w ? kBeyondGuardTop : 0;
    return code | (0.0f * (((c.x + c.y) + c.z) + c.w) == 0.0f ? 0 : kNotFinite);
}

uint32_t transform(std::span<const glm::vec3> positions, const InstanceTransform& t,
                   ScreenVertices& out)
{
    out.reserve(positions.size());
    uint32_t all = 0;
    for (size_t i = 0; i < positions.size(); ++i) {
        const glm::vec4 c = clip_position(t, positions[i]);
        const uint32_t code = code_of(c, t);
        Corner corner;
        if (code == 0) {
            const float inverse_w = 1.0f / c.w;
            const auto snapped = [&](float v) {
                return static_cast<int32_t>(
                    std::nearbyint((v * inverse_w) * static_cast<float>(kSubcells)));
            };
            corner = {snapped(c.x), snapped(c.y), std::max(c.z * inverse_w + t.z_slack, 0.0f)};
        }
        out.x[i] = corner.x;
        out.y[i] = corner.y;
        out.z[i] = corner.z;
        out.code[i] = code;
        all |= code;
    }
    return all;
}

void facings(std::span<const OccluderMesh::Triangle> triangles, const ScreenVertices& vertices,
             int8_t* facings)
{
    for (size_t i = 0; i < triangles.size(); ++i) {
        const int64_t area =
            twice_area(vertices.corner(triangles[i][0]), vertices.corner(triangles[i][1]),
                       vertices.corner(triangles[i][2]));
        facings[i] = static_cast<int8_t>(area > 0 ? 1 : area < 0 ? -1 : 0);
    }
}

size_t triangles(std::span<const OccluderMesh::Triangle> triangles, const ScreenVertices& vertices,
                 const TriangleSetup& setup, Prim* out)
{
    size_t count = 0;
    for (const OccluderMesh::Triangle& t : triangles) {
        count += make_triangle(vertices.corner(t[0]), vertices.corner(t[1]), vertices.corner(t[2]),
                               setup, out[count])
                     ? 1
                     : 0;
    }
    return count;
}

} // namespace

void ScreenVertices::reserve(size_t count)
{
    const size_t room = count + kMostLanes;
    if (x.size() < room) {
        x.resize(room);
        y.resize(room);
        z.resize(room);
        code.resize(room);
    }
}

glm::vec4 clip_position(const InstanceTransform& t, const glm::vec3& p)
{
    return t.column[0] * p.x + t.column[1] * p.y + t.column[2] * p.z + t.column[3];
}

bool make_triangle(const Corner& a, const Corner& second, const Corner& third,
                   const TriangleSetup& setup, Prim& prim)
{
    const int64_t area = twice_area(a, second, third);
    if (area > 0 ? !setup.counterclockwise : area < 0 ? !setup.clockwise : true) {
        return false;
    }
    const Corner& b = area > 0 ? second : third;
    const Corner& c = area > 0 ? third : second;
    const Extent extent = extent_of(a, b, c);
    const bool alone = setup.kind == PrimKind::alone;
    prim.cells = alone ? cells_inside(extent, subcells_of(setup.growth.edge), setup.size)
                       : cells_touched(extent, subcells_of(setup.growth.touch), setup.size);
    if (prim.cells.empty()) {
        return false;
    }
    prim.piece_and_kind = Prim::pack(setup.piece, setup.kind);
    // Columns and rows of the corners: cells' middles, from the first cell.
    const int32_t x0 = prim.cells.x0 * kSubcells + kSubcells / 2;
    const int32_t y0 = prim.cells.y0 * kSubcells + kSubcells / 2;
    const float ax = cells(a.x - x0);
    const float ay = cells(a.y - y0);
    const float outward = alone ? -(0.5f + setup.growth.edge) : 0.5f + setup.growth.touch;
    const std::array<const Corner*, 4> corners{&a, &b, &c, &a};
    std::array<Line, 3> lines;
    std::array<bool, 3> is_left{};
    std::array<bool, 3> is_right{};
    for (size_t i = 0; i < 3; ++i) {
        const Corner& from = *corners[i];
        const Corner& to = *corners[i + 1];
        const float dy = cells(to.y - from.y);
        lines[i] =
            edge_line(cells(from.x - x0), cells(from.y - y0), cells(to.x - from.x), dy, outward);
        is_left[i] = dy < 0.0f; // counter-clockwise: the left edges run down
        is_right[i] = dy > 0.0f;
    }
    const auto first_of = [&](const std::array<bool, 3>& is) {
        return lines[is[0] ? 0 : is[1] ? 1 : 2];
    };
    const auto last_of = [&](const std::array<bool, 3>& is) {
        return lines[is[2] ? 2 : is[1] ? 1 : 0];
    };
    prim.left = {first_of(is_left), last_of(is_left)};
    prim.right = {first_of(is_right), last_of(is_right)};
    set_plane(prim, a, b, c, extent, ax, ay, setup.growth.touch + kRounding);
    return true;
}

bool make_edge(const Corner& a, const Corner& b, const TriangleSetup& setup, Prim& prim)
{
    prim.cells = cells_touched(extent_of(a, b, b), subcells_of(setup.growth.edge), setup.size);
    if (prim.cells.empty() || (a.x == b.x && a.y == b.y)) {
        return false;
    }
    prim.piece_and_kind = Prim::pack(setup.piece, PrimKind::edge);
    const float outward = 0.5f + setup.growth.edge;
    const Corner& low = a.y < b.y ? a : b;
    const Corner& high = a.y < b.y ? b : a;
    if (low.y == high.y) { // the rows of `cells` bound it
        prim.left = {Line{0.0f, -1.0f}, Line{0.0f, -1.0f}};
        prim.right = {Line{0.0f, float{kMaxSide}}, Line{0.0f, float{kMaxSide}}};
    } else {
        const int32_t x0 = prim.cells.x0 * kSubcells + kSubcells / 2;
        const int32_t y0 = prim.cells.y0 * kSubcells + kSubcells / 2;
        const float x = cells(low.x - x0);
        const float y = cells(low.y - y0);
        const float dx = cells(high.x - low.x);
        const float dy = cells(high.y - low.y);
        const Line right = edge_line(x, y, dx, dy, outward);
        const Line left = edge_line(x, y, dx, dy, -outward);
        prim.left = {left, left};
        prim.right = {right, right};
    }
    prim.zx = 0.0f;
    prim.zy = 0.0f;
    prim.z = 0.0f;
    prim.z_max = 0.0f;
    prim.z_min = 0.0f;
    return true;
}

const SetupKernels& setup_kernels(Kernel kernel)
{
    static constexpr SetupKernels kScalar{&transform, &facings, &triangles};
    return kernel == Kernel::scalar ? kScalar : simd_setup_kernels();
}

} // namespace occlude::cpu_fast
