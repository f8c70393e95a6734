#include <occlude/backends/cpu_fast/detail/mesh_setup.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace occlude::cpu_fast {

namespace {

// Why a vertex cannot be used as it is: bits of its code.
constexpr unsigned kBeforeLeastW = 1;
constexpr unsigned kBeforeNear = 2;
constexpr unsigned kBeyondGuardLeft = 4;
constexpr unsigned kBeyondGuardRight = 8;
constexpr unsigned kBeyondGuardBottom = 16;
constexpr unsigned kBeyondGuardTop = 32;
constexpr unsigned kNotFinite = 64;

// Where an edge of a clipped polygon comes from, besides the three edges of its triangle.
constexpr uint8_t kCutEdge = 3;
constexpr uint8_t kGuardEdge = 4; // far off the screen

int32_t snapped(double cells)
{
    return static_cast<int32_t>(std::nearbyint(cells * kSubcells));
}

int64_t area(const Corner& a, const Corner& b, const Corner& c)
{
    return int64_t{b.x - a.x} * (c.y - a.y) - int64_t{b.y - a.y} * (c.x - a.x);
}

} // namespace

void MeshSetup::add(const OccluderMesh& mesh, const InstanceTransform& transform, const Grid& grid,
                    PrimBatch& out)
{
    if (!transform.usable || mesh.empty()) {
        return;
    }
    grid_ = grid;
    out_ = &out;
    z_slack_ = transform.z_slack;
    growth_ = transform.growth;
    transform_vertices(mesh, transform);
    classify(mesh, transform);
    for (const OccluderMesh::Piece& piece : mesh.pieces()) {
        for (const int8_t facing : {int8_t{1}, int8_t{-1}}) {
            if (side_wanted(mesh, piece, facing, transform)) {
                emit_piece(mesh, piece, facing);
            }
        }
    }
}

// A closed piece that is seen as a whole is hidden from the inside by its own outside.
bool MeshSetup::side_wanted(const OccluderMesh& mesh, const OccluderMesh::Piece& piece,
                            int8_t facing, const InstanceTransform& transform) const
{
    const bool counterclockwise = static_cast<float>(facing) * transform.front_sign > 0.0f;
    if (mesh.faces() != MeshFaces::both) {
        return counterclockwise == (mesh.faces() == MeshFaces::counterclockwise);
    }
    return !piece.closed || any_clipped_ || counterclockwise == piece.outward;
}

void MeshSetup::transform_vertices(const OccluderMesh& mesh, const InstanceTransform& transform)
{
    const std::span<const glm::vec3> positions = mesh.positions();
    if (vertices_.size() < positions.size()) {
        vertices_.resize(positions.size());
    }
    const std::array<glm::vec4, 4>& column = transform.column;
    for (size_t i = 0; i < positions.size(); ++i) {
        const glm::vec3& p = positions[i];
        const glm::vec4 c = column[0] * p.x + column[1] * p.y + column[2] * p.z + column[3];
        unsigned code = c.w >= transform.least_w ? 0u : kBeforeLeastW;
        code |= c.z < transform.least_z ? kBeforeNear : 0u;
        code |= c.x < transform.guard_low.x * c.w ? kBeyondGuardLeft : 0u;
        code |= c.x > transform.guard_high.x * c.w ? kBeyondGuardRight : 0u;
        code |= c.y < transform.guard_low.y * c.w ? kBeyondGuardBottom : 0u;
        code |= c.y > transform.guard_high.y * c.w ? kBeyondGuardTop : 0u;
        code |= 0.0f * (c.x + c.y + c.z + c.w) == 0.0f ? 0u : kNotFinite;
        Vertex& vertex = vertices_[i];
        vertex.clip = c;
        vertex.code = static_cast<uint8_t>(code);
        if (code == 0) {
            const float inverse_w = 1.0f / c.w;
            vertex.corner = {static_cast<int32_t>(
                                 std::nearbyint(c.x * inverse_w * static_cast<float>(kSubcells))),
                             static_cast<int32_t>(
                                 std::nearbyint(c.y * inverse_w * static_cast<float>(kSubcells))),
                             std::max(c.z * inverse_w + z_slack_, 0.0f)};
        }
    }
}

// Which way each triangle faces.
void MeshSetup::classify(const OccluderMesh& mesh, const InstanceTransform& transform)
{
    const std::span<const OccluderMesh::Triangle> triangles = mesh.triangles();
    if (facings_.size() < triangles.size()) {
        facings_.resize(triangles.size());
        polygon_of_.resize(triangles.size());
    }
    polygons_.clear();
    any_clipped_ = false;
    for (size_t t = 0; t < triangles.size(); ++t) {
        const Vertex& a = vertices_[triangles[t].corners[0]];
        const Vertex& b = vertices_[triangles[t].corners[1]];
        const Vertex& c = vertices_[triangles[t].corners[2]];
        if ((a.code | b.code | c.code) == 0) {
            const int64_t twice = area(a.corner, b.corner, c.corner);
            facings_[t] = static_cast<int8_t>(twice > 0 ? 1 : twice < 0 ? -1 : 0);
            continue;
        }
        any_clipped_ = true;
        const bool gone =
            (a.code & b.code & c.code) != 0 || ((a.code | b.code | c.code) & kNotFinite) != 0;
        polygon_of_[t] = static_cast<uint32_t>(polygons_.size());
        facings_[t] = gone ? int8_t{0} : clipped_facing(triangles[t], transform);
    }
}

// Clips the triangle, and keeps the polygon if all triangles of its fan face the same way.
int8_t MeshSetup::clipped_facing(const OccluderMesh::Triangle& triangle,
                                 const InstanceTransform& transform)
{
    Polygon polygon;
    for (uint8_t i = 0; i < 3; ++i) {
        const Vertex& vertex = vertices_[triangle.corners[i]];
        polygon.corners[i] = {glm::dvec4{vertex.clip}, vertex.corner, vertex.code == 0, i};
    }
    polygon.count = 3;
    clip(transform, polygon);
    if (polygon.count < 3) {
        return 0;
    }
    bool left = true;
    bool right = true;
    for (size_t i = 2; i < polygon.count; ++i) {
        const int64_t twice = area(polygon.corners[0].corner, polygon.corners[i - 1].corner,
                                   polygon.corners[i].corner);
        left = left && twice > 0;
        right = right && twice < 0;
    }
    if (!left && !right) {
        return 0;
    }
    polygons_.push_back(polygon);
    return left ? int8_t{1} : int8_t{-1};
}

// Sutherland and Hodgman. An edge is cut from its inside to its outside, whichever way it runs, so
// that both of its triangles find the same point; vertices that need no clipping count as inside.
void MeshSetup::clip(const InstanceTransform& transform, Polygon& polygon) const
{
    struct Plane {
        glm::dvec4 normal;
        double offset;
        uint8_t edge;
    };
    const glm::dvec2 low{transform.guard_low};
    const glm::dvec2 high{transform.guard_high};
    const std::array<Plane, 6> planes{{
        {{0.0, 0.0, 0.0, 1.0}, double{transform.least_w}, kCutEdge},
        {{0.0, 0.0, 1.0, 0.0}, double{transform.least_z}, kCutEdge},
        {{1.0, 0.0, 0.0, -low.x}, 0.0, kGuardEdge},
        {{-1.0, 0.0, 0.0, high.x}, 0.0, kGuardEdge},
        {{0.0, 1.0, 0.0, -low.y}, 0.0, kGuardEdge},
        {{0.0, -1.0, 0.0, high.y}, 0.0, kGuardEdge},
    }};
    for (const Plane& plane : planes) {
        if (std::isinf(plane.offset)) {
            continue; // no near plane
        }
        const auto distance = [&](const PolygonCorner& corner) {
            const double d = glm::dot(plane.normal, corner.clip) - plane.offset;
            return corner.given ? std::max(d, 0.0) : d;
        };
        Polygon kept;
        for (size_t i = 0; i < polygon.count; ++i) {
            const PolygonCorner& from = polygon.corners[i];
            const PolygonCorner& to = polygon.corners[(i + 1) % polygon.count];
            const double d_from = distance(from);
            const double d_to = distance(to);
            const bool from_inside = d_from >= 0.0;
            const bool to_inside = d_to >= 0.0;
            if (from_inside) {
                kept.corners[kept.count++] = from;
            }
            if (from_inside != to_inside) {
                const PolygonCorner& in = from_inside ? from : to;
                const PolygonCorner& out = from_inside ? to : from;
                const double t = from_inside ? d_from / (d_from - d_to) : d_to / (d_to - d_from);
                PolygonCorner& cut = kept.corners[kept.count++];
                cut.clip = in.clip + t * (out.clip - in.clip);
                cut.given = false;
                cut.edge = from_inside ? plane.edge : from.edge;
            }
        }
        polygon = kept;
    }
    snap(polygon);
}

// Gives the corners that clipping made their places on the grid, and drops edges of length 0.
void MeshSetup::snap(Polygon& polygon) const
{
    for (size_t i = 0; i < polygon.count; ++i) {
        PolygonCorner& corner = polygon.corners[i];
        if (!corner.given) {
            const glm::dvec4& c = corner.clip;
            corner.corner = {snapped(c.x / c.w), snapped(c.y / c.w),
                             std::max(static_cast<float>(c.z / c.w) + z_slack_ + 0x1p-24f, 0.0f)};
        }
    }
    size_t kept = 0;
    for (size_t i = 0; i < polygon.count; ++i) {
        const Corner& here = polygon.corners[i].corner;
        const Corner& next = polygon.corners[(i + 1) % polygon.count].corner;
        if (here.x != next.x || here.y != next.y) {
            polygon.corners[kept++] = polygon.corners[i];
        } else {
            // The next corner takes its place, with the farther depth of both.
            Corner& other = polygon.corners[(i + 1) % polygon.count].corner;
            other.z = std::max(other.z, here.z);
        }
    }
    polygon.count = kept;
}

// The triangles of a piece that face one way, and the edges that they share with none of them.
void MeshSetup::emit_piece(const OccluderMesh& mesh, const OccluderMesh::Piece& piece,
                           int8_t facing)
{
    const size_t first_prim = out_->prims.size();
    const std::span<const OccluderMesh::Triangle> triangles = mesh.triangles();
    for (uint32_t t = piece.first; t < piece.first + piece.count; ++t) {
        if (facings_[t] != facing) {
            continue;
        }
        const OccluderMesh::Triangle& triangle = triangles[t];
        std::array<bool, 3> open{};
        unsigned needs_clipping = 0;
        for (size_t i = 0; i < 3; ++i) {
            const uint32_t mate = triangle.mates[i];
            open[i] = mate == OccluderMesh::kNoTriangle || facings_[mate] != facing;
            needs_clipping |= vertices_[triangle.corners[i]].code;
        }
        if (needs_clipping != 0) {
            emit_polygon(polygons_[polygon_of_[t]], open, facing);
            continue;
        }
        const Corner& a = vertices_[triangle.corners[0]].corner;
        const Corner& b = vertices_[triangle.corners[1]].corner;
        const Corner& c = vertices_[triangle.corners[2]].corner;
        const bool alone = open[0] && open[1] && open[2];
        emit_triangle(a, facing > 0 ? b : c, facing > 0 ? c : b,
                      alone ? PrimKind::alone : PrimKind::triangle);
        if (!alone) {
            const std::array<const Corner*, 4> corners{&a, &b, &c, &a};
            for (size_t i = 0; i < 3; ++i) {
                if (open[i]) {
                    emit_edge(*corners[i], *corners[i + 1]);
                }
            }
        }
    }
    finish_piece(first_prim);
}

void MeshSetup::emit_polygon(const Polygon& polygon, const std::array<bool, 3>& open, int8_t facing)
{
    const auto corner = [&](size_t i) -> const Corner& {
        return polygon.corners[i % polygon.count].corner;
    };
    for (size_t i = 2; i < polygon.count; ++i) {
        emit_triangle(corner(0), corner(facing > 0 ? i - 1 : i), corner(facing > 0 ? i : i - 1),
                      PrimKind::triangle);
    }
    for (size_t i = 0; i < polygon.count; ++i) {
        const uint8_t edge = polygon.corners[i].edge;
        if (edge == kCutEdge || (edge < 3 && open[edge])) {
            emit_edge(corner(i), corner(i + 1));
        }
    }
}

void MeshSetup::emit_triangle(const Corner& a, const Corner& b, const Corner& c, PrimKind kind)
{
    Prim prim;
    if (make_triangle(a, b, c, kind, growth_, grid_.size_cells, prim)) {
        prim.piece = out_->piece_count;
        out_->prims.push_back(prim);
    }
}

void MeshSetup::emit_edge(const Corner& a, const Corner& b)
{
    Prim prim;
    if (make_edge(a, b, growth_, grid_.size_cells, prim)) {
        prim.piece = out_->piece_count;
        out_->prims.push_back(prim);
    }
}

// Hands the prims since `first_prim` to the tiles that need them, if they can fill a cell at all.
void MeshSetup::finish_piece(size_t first_prim)
{
    std::vector<Prim>& prims = out_->prims;
    int triangles = 0;
    int width = 0;
    int height = 0;
    CellRect all{INT16_MAX, INT16_MAX, INT16_MIN, INT16_MIN};
    for (size_t i = first_prim; i < prims.size(); ++i) {
        if (prims[i].kind != PrimKind::edge) {
            ++triangles;
            const CellRect& cells = prims[i].cells;
            all.x0 = std::min(all.x0, cells.x0);
            all.y0 = std::min(all.y0, cells.y0);
            all.x1 = std::max(all.x1, cells.x1);
            all.y1 = std::max(all.y1, cells.y1);
        }
    }
    width = all.x1 - all.x0;
    height = all.y1 - all.y0;
    // A cell that is covered whole has neighbours that are touched, but for the border of the grid.
    const bool on_border = all.x0 == 0 || all.y0 == 0 || all.x1 == grid_.size_cells.x - 1 ||
                           all.y1 == grid_.size_cells.y - 1;
    if (triangles == 0 || (!on_border && (width < 2 || height < 2))) {
        prims.resize(first_prim);
        return;
    }
    for (size_t i = first_prim; i < prims.size(); ++i) {
        bin(static_cast<uint32_t>(i));
    }
    ++out_->piece_count;
}

void MeshSetup::bin(uint32_t index)
{
    const Prim& prim = out_->prims[index];
    const CellRect& cells = prim.cells;
    const int tx0 = cells.x0 / kTileWidth;
    const int tx1 = cells.x1 / kTileWidth;
    const int ty0 = cells.y0 / kTileHeight;
    const int ty1 = cells.y1 / kTileHeight;
    const bool many = (tx1 - tx0 + 1) * (ty1 - ty0 + 1) > 3;
    for (int ty = ty0; ty <= ty1; ++ty) {
        for (int tx = tx0; tx <= tx1; ++tx) {
            if (!many || meets_tile(prim, tx, ty)) {
                out_->tiles[static_cast<size_t>(ty * grid_.size_tiles.x + tx)].push_back(index);
            }
        }
    }
}

} // namespace occlude::cpu_fast
