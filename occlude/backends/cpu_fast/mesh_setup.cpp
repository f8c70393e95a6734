#include <occlude/backends/cpu_fast/detail/mesh_setup.h>

#include <algorithm>
#include <cmath>

namespace occlude::cpu_fast {

namespace {

// More bins than this: which of them a prim meets is worth finding out.
constexpr int kFewBins = 3;

// Grids reach beyond the view to the end of their sub-tiles.
glm::ivec2 whole_sub_tiles(glm::ivec2 size)
{
    return {(size.x + kSubTileWidth - 1) / kSubTileWidth * kSubTileWidth,
            (size.y + kSubTileHeight - 1) / kSubTileHeight * kSubTileHeight};
}

} // namespace

void MeshSetup::add(const OccluderMesh& mesh, const InstanceTransform& transform, const Grid& grid,
                    const SetupKernels& kernels, PrimBatch& out)
{
    if (!transform.usable || mesh.empty()) {
        return;
    }
    grid_ = grid;
    out_ = &out;
    transform_ = &transform;
    kernels_ = &kernels;
    setup_ = TriangleSetup{};
    setup_.size = whole_sub_tiles(grid.size_cells);
    setup_.growth = transform.growth;
    any_code_ = kernels.transform(mesh.positions(), transform, vertices_);
    polygons_.clear();
    classify(mesh);
    for (const OccluderMesh::Piece& piece : mesh.pieces()) {
        for (const int8_t facing : {int8_t{1}, int8_t{-1}}) {
            if (side_wanted(mesh, piece, facing)) {
                add_piece(mesh, piece, facing);
            }
        }
    }
    add_loose(mesh);
}

// A closed piece that is seen as a whole is hidden from the inside by its own outside.
bool MeshSetup::side_wanted(const OccluderMesh& mesh, const OccluderMesh::Piece& piece,
                            int8_t facing) const
{
    const bool counterclockwise = static_cast<float>(facing) * transform_->front_sign > 0.0f;
    if (mesh.faces() != MeshFaces::both) {
        return counterclockwise == (mesh.faces() == MeshFaces::counterclockwise);
    }
    return !piece.closed || any_code_ != 0 || counterclockwise == piece.outward;
}

uint32_t MeshSetup::codes_of(const Triangle& t) const
{
    return vertices_.code[t[0]] | vertices_.code[t[1]] | vertices_.code[t[2]];
}

// Which way each triangle of the pieces faces.
void MeshSetup::classify(const OccluderMesh& mesh)
{
    const std::span<const Triangle> triangles = mesh.triangles().first(mesh.loose_begin());
    if (facings_.size() < triangles.size()) {
        facings_.resize(triangles.size());
        polygon_of_.resize(triangles.size());
    }
    kernels_->facings(triangles, vertices_, facings_.data());
    if (any_code_ == 0) {
        return;
    }
    for (size_t t = 0; t < triangles.size(); ++t) {
        if (codes_of(triangles[t]) != 0) {
            polygon_of_[t] = static_cast<uint32_t>(polygons_.size());
            facings_[t] = clip_triangle(mesh, triangles[t]);
        }
    }
}

// Clips the triangle, and keeps the polygon if all triangles of its fan face the same way.
int8_t MeshSetup::clip_triangle(const OccluderMesh& mesh, const Triangle& triangle)
{
    const uint32_t shared =
        vertices_.code[triangle[0]] & vertices_.code[triangle[1]] & vertices_.code[triangle[2]];
    if (shared != 0 || (codes_of(triangle) & kNotFinite) != 0) {
        return 0;
    }
    Polygon polygon;
    for (uint8_t i = 0; i < 3; ++i) {
        const uint32_t v = triangle[i];
        polygon.corners[i] = {glm::dvec4{clip_position(*transform_, mesh.positions()[v])},
                              vertices_.corner(v), vertices_.code[v] == 0, i};
    }
    polygon.count = 3;
    clip(*transform_, polygon);
    const int8_t facing = polygon.facing();
    if (facing != 0) {
        polygons_.push_back(polygon);
    }
    return facing;
}

// Triangles without neighbours, whichever way they face. One that is clipped is a piece.
void MeshSetup::add_loose(const OccluderMesh& mesh)
{
    const std::span<const Triangle> loose = mesh.triangles().subspan(mesh.loose_begin());
    const bool counterclockwise =
        (mesh.faces() == MeshFaces::counterclockwise) == (transform_->front_sign > 0.0f);
    setup_.counterclockwise = mesh.faces() == MeshFaces::both || counterclockwise;
    setup_.clockwise = mesh.faces() == MeshFaces::both || !counterclockwise;
    const size_t first_prim = out_->prims.size();
    if (any_code_ == 0) {
        add_triangles(loose, PrimKind::alone);
        bin_from(first_prim);
        return;
    }
    alone_.clear();
    std::ranges::copy_if(loose, std::back_inserter(alone_),
                         [&](const Triangle& t) { return codes_of(t) == 0; });
    add_triangles(alone_, PrimKind::alone);
    bin_from(first_prim);
    for (const Triangle& t : loose) {
        if (codes_of(t) == 0) {
            continue;
        }
        const int8_t facing = clip_triangle(mesh, t);
        if (facing > 0 ? setup_.counterclockwise : facing < 0 && setup_.clockwise) {
            const size_t first = out_->prims.size();
            add_polygon(polygons_.back(), {true, true, true});
            finish_piece(first);
        }
    }
}

// The triangles of a piece that face one way, and the edges that they share with none of them.
void MeshSetup::add_piece(const OccluderMesh& mesh, const OccluderMesh::Piece& piece, int8_t facing)
{
    const size_t first_prim = out_->prims.size();
    const std::span<const Triangle> triangles = mesh.triangles();
    setup_.piece = out_->piece_count;
    setup_.counterclockwise = facing > 0;
    setup_.clockwise = facing < 0;
    alone_.clear();
    joined_.clear();
    for (uint32_t t = piece.first; t < piece.first + piece.count; ++t) {
        if (facings_[t] != facing) {
            continue;
        }
        const Triangle& triangle = triangles[t];
        std::array<bool, 3> open{};
        for (size_t i = 0; i < 3; ++i) {
            const uint32_t mate = mesh.mates()[t][i];
            open[i] = mate == OccluderMesh::kNoTriangle || facings_[mate] != facing;
        }
        if (any_code_ != 0 && codes_of(triangle) != 0) {
            add_polygon(polygons_[polygon_of_[t]], open);
            continue;
        }
        if (open[0] && open[1] && open[2]) {
            alone_.push_back(triangle);
            continue;
        }
        joined_.push_back(triangle);
        for (size_t i = 0; i < 3; ++i) {
            if (open[i]) {
                add_edge(vertices_.corner(triangle[i]), vertices_.corner(triangle[(i + 1) % 3]));
            }
        }
    }
    add_triangles(joined_, PrimKind::triangle);
    finish_piece(first_prim);
    const size_t first_alone = out_->prims.size();
    add_triangles(alone_, PrimKind::alone);
    bin_from(first_alone);
}

void MeshSetup::add_triangles(std::span<const Triangle> triangles, PrimKind kind)
{
    if (!triangles.empty()) {
        setup_.kind = kind;
        out_->prims.add(kernels_->triangles(triangles, vertices_, setup_,
                                            out_->prims.reserve(triangles.size())));
    }
}

void MeshSetup::add_polygon(const Polygon& polygon, const std::array<bool, 3>& open)
{
    setup_.kind = PrimKind::triangle;
    setup_.piece = out_->piece_count;
    const auto corner = [&](size_t i) -> const Corner& {
        return polygon.corners[i % polygon.count].corner;
    };
    for (size_t i = 2; i < polygon.count; ++i) {
        const bool added =
            make_triangle(corner(0), corner(i - 1), corner(i), setup_, *out_->prims.reserve(1));
        out_->prims.add(added ? 1 : 0);
    }
    for (size_t i = 0; i < polygon.count; ++i) {
        const uint8_t edge = polygon.corners[i].edge;
        if (edge == kCutEdge || (edge < 3 && open[edge])) {
            add_edge(corner(i), corner(i + 1));
        }
    }
}

void MeshSetup::add_edge(const Corner& a, const Corner& b)
{
    out_->prims.add(make_edge(a, b, setup_, *out_->prims.reserve(1)) ? 1 : 0);
}

// Hands the prims since `first_prim` to the bins that need them, if they can fill a cell at all.
void MeshSetup::finish_piece(size_t first_prim)
{
    PrimList& prims = out_->prims;
    int triangles = 0;
    CellRect all{INT16_MAX, INT16_MAX, INT16_MIN, INT16_MIN};
    for (size_t i = first_prim; i < prims.size(); ++i) {
        if (prims[i].kind() != PrimKind::edge) {
            ++triangles;
            const CellRect& cells = prims[i].cells;
            all.x0 = std::min(all.x0, cells.x0);
            all.y0 = std::min(all.y0, cells.y0);
            all.x1 = std::max(all.x1, cells.x1);
            all.y1 = std::max(all.y1, cells.y1);
        }
    }
    const int width = all.x1 - all.x0;
    const int height = all.y1 - all.y0;
    // A cell that is covered whole has neighbours that are touched, but for the border of the grid.
    const bool on_border =
        all.x0 == 0 || all.y0 == 0 || all.x1 == setup_.size.x - 1 || all.y1 == setup_.size.y - 1;
    if (triangles == 0 || (!on_border && (width < 2 || height < 2))) {
        prims.shrink(first_prim);
        return;
    }
    bin_from(first_prim);
    ++out_->piece_count;
}

void MeshSetup::bin_from(size_t first_prim)
{
    for (size_t i = first_prim; i < out_->prims.size(); ++i) {
        bin(static_cast<uint32_t>(i));
    }
}

void MeshSetup::bin(uint32_t index)
{
    const Prim& prim = out_->prims[index];
    const CellRect& cells = prim.cells;
    const int tx0 = cells.x0 / kBinWidth;
    const int tx1 = cells.x1 / kBinWidth;
    const int ty0 = cells.y0 / kBinHeight;
    const int ty1 = cells.y1 / kBinHeight;
    const auto bin_at = [&](int tx, int ty) -> std::vector<uint32_t>& {
        return out_->bins[grid_.bin_index(tx, ty)];
    };
    if (tx0 == tx1 && ty0 == ty1) {
        bin_at(tx0, ty0).push_back(index);
        return;
    }
    const bool few = (tx1 - tx0 + 1) * (ty1 - ty0 + 1) <= kFewBins;
    for (int ty = ty0; ty <= ty1; ++ty) {
        int first = tx0;
        int last = tx1;
        if (!few) {
            // The columns that the lines leave of the rows of these bins, and one to spare.
            const auto low_row =
                static_cast<float>(std::max(ty * kBinHeight, int{cells.y0}) - cells.y0);
            const auto high_row =
                static_cast<float>(std::min((ty + 1) * kBinHeight - 1, int{cells.y1}) - cells.y0);
            const auto least = [&](const Line& line) {
                return std::min(line.slope * low_row, line.slope * high_row) + line.at;
            };
            const auto most = [&](const Line& line) {
                return std::max(line.slope * low_row, line.slope * high_row) + line.at;
            };
            const float width = static_cast<float>(cells.x1 - cells.x0) + 1.0f;
            const float from = std::max(least(prim.left[0]), least(prim.left[1])) - 1.0f;
            const float to = std::min(most(prim.right[0]), most(prim.right[1])) + 1.0f;
            if (from > width || to < 0.0f) {
                continue;
            }
            first =
                std::max(first, (cells.x0 + static_cast<int>(std::max(from, 0.0f))) / kBinWidth);
            last = std::min(last, (cells.x0 + static_cast<int>(std::min(to, width))) / kBinWidth);
        }
        for (int tx = first; tx <= last; ++tx) {
            bin_at(tx, ty).push_back(index);
        }
    }
}

} // namespace occlude::cpu_fast
