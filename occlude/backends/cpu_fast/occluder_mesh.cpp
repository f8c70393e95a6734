#include <occlude/backends/cpu_fast/occluder_mesh.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>
#include <tuple>
#include <utility>

namespace occlude {

namespace {

constexpr uint32_t kNone = OccluderMesh::kNoTriangle;

bool finite(const glm::vec3& p)
{
    return 0.0f * (p.x + p.y + p.z) == 0.0f;
}

// One side of a triangle, by the edge that it lies on.
struct Side {
    uint32_t low; // of its two vertices
    uint32_t high;
    uint32_t triangle;
    uint32_t corner; // where it starts
    bool descending; // it runs from the higher vertex to the lower one

    std::pair<uint32_t, uint32_t> edge() const { return {low, high}; }
};

// Sides in groups of those on the same edge.
std::vector<Side> sides_by_edge(std::span<const OccluderMesh::Triangle> triangles)
{
    std::vector<Side> sides;
    sides.reserve(3 * triangles.size());
    for (uint32_t t = 0; t < triangles.size(); ++t) {
        for (uint32_t corner = 0; corner < 3; ++corner) {
            const uint32_t from = triangles[t][corner];
            const uint32_t to = triangles[t][(corner + 1) % 3];
            sides.push_back({std::min(from, to), std::max(from, to), t, corner, from > to});
        }
    }
    std::ranges::sort(sides, [](const Side& a, const Side& b) {
        return std::tuple{a.low, a.high, a.triangle, a.corner} <
               std::tuple{b.low, b.high, b.triangle, b.corner};
    });
    return sides;
}

// Calls use(group) for each group of sides on one edge.
template <class Use>
void for_each_edge(std::span<const Side> sides, Use&& use)
{
    for (size_t begin = 0; begin < sides.size();) {
        size_t end = begin + 1;
        while (end < sides.size() && sides[end].edge() == sides[begin].edge()) {
            ++end;
        }
        use(sides.subspan(begin, end - begin));
        begin = end;
    }
}

// Which triangles to turn around so that neighbours across edges of two triangles agree, wherever
// that is possible.
std::vector<bool> triangles_to_turn(std::span<const Side> sides, size_t triangle_count)
{
    struct Neighbour {
        uint32_t triangle = kNone;
        bool agrees = true;
    };
    std::vector<std::array<Neighbour, 3>> neighbours(triangle_count);
    for_each_edge(sides, [&](std::span<const Side> group) {
        if (group.size() == 2) {
            const bool agrees = group[0].descending != group[1].descending;
            neighbours[group[0].triangle][group[0].corner] = {group[1].triangle, agrees};
            neighbours[group[1].triangle][group[1].corner] = {group[0].triangle, agrees};
        }
    });
    std::vector<bool> turn(triangle_count, false);
    std::vector<bool> reached(triangle_count, false);
    std::vector<uint32_t> open;
    for (uint32_t seed = 0; seed < triangle_count; ++seed) {
        if (reached[seed]) {
            continue;
        }
        reached[seed] = true;
        open.assign(1, seed);
        while (!open.empty()) {
            const uint32_t t = open.back();
            open.pop_back();
            for (const Neighbour& next : neighbours[t]) {
                if (next.triangle != kNone && !reached[next.triangle]) {
                    reached[next.triangle] = true;
                    turn[next.triangle] = turn[t] == next.agrees;
                    open.push_back(next.triangle);
                }
            }
        }
    }
    return turn;
}

uint32_t find_root(std::vector<uint32_t>& parents, uint32_t i)
{
    while (parents[i] != i) {
        parents[i] = parents[parents[i]];
        i = parents[i];
    }
    return i;
}

} // namespace

glm::vec3 PositionStream::operator[](size_t i) const
{
    glm::vec3 position;
    std::memcpy(&position, data + i * stride_bytes, sizeof(position));
    return position;
}

OccluderMesh OccluderMesh::prepare(const PositionStream& positions,
                                   std::span<const uint32_t> indices,
                                   const OccluderMeshOptions& options)
{
    OccluderMesh mesh;
    mesh.faces_ = options.faces;
    mesh.welding_ = options.welding;
    mesh.weld(positions, indices, options.welding);
    mesh.connect();
    mesh.sort_pieces();
    mesh.sort_positions();
    mesh.update_bounds();
    return mesh;
}

OccluderMesh OccluderMesh::prepare(const PositionStream& positions,
                                   std::span<const uint16_t> indices,
                                   const OccluderMeshOptions& options)
{
    const std::vector<uint32_t> wide(indices.begin(), indices.end());
    return prepare(positions, wide, options);
}

// Keeps one vertex of equal ones, and the triangles that have three of them.
void OccluderMesh::weld(const PositionStream& positions, std::span<const uint32_t> indices,
                        MeshWelding welding)
{
    // The used indices, in order; then by position.
    std::vector<uint32_t> used(indices.begin(), indices.end());
    std::ranges::sort(used);
    used.erase(std::unique(used.begin(), used.end()), used.end());
    std::erase_if(used, [&](uint32_t index) { return index >= positions.count; });
    struct Vertex {
        glm::vec3 position;
        uint32_t index;
        uint32_t welded;
    };
    std::vector<Vertex> vertices;
    vertices.reserve(used.size());
    for (const uint32_t index : used) {
        // Adding 0 makes -0 and 0 the same.
        vertices.push_back({positions[index] + glm::vec3{0.0f}, index, 0});
    }
    std::erase_if(vertices, [](const Vertex& v) { return !finite(v.position); });
    const auto key = [](const Vertex& v) {
        return std::tuple{v.position.x, v.position.y, v.position.z};
    };
    if (welding == MeshWelding::by_position) {
        std::ranges::stable_sort(vertices,
                                 [&](const Vertex& a, const Vertex& b) { return key(a) < key(b); });
    }
    for (size_t i = 0; i < vertices.size(); ++i) {
        const bool same = welding == MeshWelding::by_position && i > 0 &&
                          key(vertices[i]) == key(vertices[i - 1]);
        if (!same) {
            positions_.push_back(vertices[i].position);
            sources_.push_back(vertices[i].index);
        }
        vertices[i].welded = static_cast<uint32_t>(positions_.size() - 1);
    }
    std::ranges::sort(vertices, [](const Vertex& a, const Vertex& b) { return a.index < b.index; });
    const auto welded = [&](uint32_t index) {
        const auto found = std::ranges::lower_bound(vertices, index, {}, &Vertex::index);
        return found != vertices.end() && found->index == index ? found->welded : kNone;
    };
    for (size_t i = 0; i + 2 < indices.size(); i += 3) {
        const std::array<uint32_t, 3> corners{welded(indices[i]), welded(indices[i + 1]),
                                              welded(indices[i + 2])};
        const bool whole = corners[0] != kNone && corners[1] != kNone && corners[2] != kNone;
        if (whole && corners[0] != corners[1] && corners[1] != corners[2] &&
            corners[2] != corners[0]) {
            triangles_.push_back(corners);
        }
    }
}

// Finds the mates: on each edge, sides that run in opposite directions, two by two.
void OccluderMesh::connect()
{
    std::vector<Side> sides = sides_by_edge(triangles_);
    if (faces_ == MeshFaces::both) {
        const std::vector<bool> turn = triangles_to_turn(sides, triangles_.size());
        for (size_t t = 0; t < triangles_.size(); ++t) {
            if (turn[t]) {
                std::swap(triangles_[t][1], triangles_[t][2]);
            }
        }
        sides = sides_by_edge(triangles_);
    }
    mates_.assign(triangles_.size(), {kNone, kNone, kNone});
    for_each_edge(sides, [&](std::span<const Side> group) {
        size_t down = 0;
        for (const Side& up : group) {
            if (up.descending) {
                continue;
            }
            while (down < group.size() && !group[down].descending) {
                ++down;
            }
            if (down == group.size()) {
                return;
            }
            mates_[up.triangle][up.corner] = group[down].triangle;
            mates_[group[down].triangle][group[down].corner] = up.triangle;
            ++down;
        }
    });
}

// Puts the triangles of each piece behind one another, those without mates behind all of them, and
// looks which pieces are closed.
void OccluderMesh::sort_pieces()
{
    const auto count = static_cast<uint32_t>(triangles_.size());
    std::vector<uint32_t> parents(count);
    std::iota(parents.begin(), parents.end(), 0u);
    for (uint32_t t = 0; t < count; ++t) {
        for (const uint32_t mate : mates_[t]) {
            if (mate != kNone) {
                const uint32_t a = find_root(parents, t);
                const uint32_t b = find_root(parents, mate);
                parents[std::max(a, b)] = std::min(a, b);
            }
        }
    }
    std::vector<uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    for (uint32_t t = 0; t < count; ++t) {
        const bool loose = std::ranges::count(mates_[t], kNone) == 3;
        parents[t] = loose ? kNone : find_root(parents, t);
    }
    std::ranges::stable_sort(order, {}, [&](uint32_t t) { return parents[t]; });
    std::vector<uint32_t> place(count);
    for (uint32_t i = 0; i < count; ++i) {
        place[order[i]] = i;
    }
    std::vector<Triangle> sorted(count);
    std::vector<Mates> sorted_mates(count);
    loose_begin_ = count;
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t t = order[i];
        sorted[i] = triangles_[t];
        sorted_mates[i] = mates_[t];
        if (parents[t] == kNone) {
            loose_begin_ = std::min(loose_begin_, i);
            continue;
        }
        for (uint32_t& mate : sorted_mates[i]) {
            mate = mate == kNone ? kNone : place[mate];
        }
        if (i == 0 || parents[t] != parents[order[i - 1]]) {
            pieces_.push_back({.first = i, .count = 0, .closed = true});
        }
        Piece& piece = pieces_.back();
        ++piece.count;
        piece.closed = piece.closed && std::ranges::count(sorted_mates[i], kNone) == 0;
    }
    triangles_ = std::move(sorted);
    mates_ = std::move(sorted_mates);
}

// Puts positions in the order in which triangles use them: what is read together lies together.
void OccluderMesh::sort_positions()
{
    std::vector<uint32_t> place(positions_.size(), kNone);
    std::vector<glm::vec3> sorted;
    std::vector<uint32_t> sources;
    sorted.reserve(positions_.size());
    sources.reserve(positions_.size());
    for (Triangle& triangle : triangles_) {
        for (uint32_t& corner : triangle) {
            if (place[corner] == kNone) {
                place[corner] = static_cast<uint32_t>(sorted.size());
                sorted.push_back(positions_[corner]);
                sources.push_back(sources_[corner]);
            }
            corner = place[corner];
        }
    }
    positions_ = std::move(sorted);
    sources_ = std::move(sources);
}

// The box, and which side of closed pieces is outside: their signed volume says so.
void OccluderMesh::update_bounds()
{
    box_ = Aabb::empty();
    for (const glm::vec3& position : positions_) {
        box_.min = glm::min(box_.min, position);
        box_.max = glm::max(box_.max, position);
    }
    for (Piece& piece : pieces_) {
        if (!piece.closed) {
            continue;
        }
        const glm::dvec3 zero{positions_[triangles_[piece.first][0]]};
        double volume = 0.0;
        for (const Triangle& t : std::span{triangles_}.subspan(piece.first, piece.count)) {
            const glm::dvec3 a = glm::dvec3{positions_[t[0]]} - zero;
            const glm::dvec3 b = glm::dvec3{positions_[t[1]]} - zero;
            const glm::dvec3 c = glm::dvec3{positions_[t[2]]} - zero;
            volume += glm::dot(a, glm::cross(b, c));
        }
        piece.outward = volume >= 0.0;
    }
}

bool OccluderMesh::set_positions(const PositionStream& positions)
{
    const auto last = std::ranges::max_element(sources_);
    if (welding_ != MeshWelding::by_index || (last != sources_.end() && *last >= positions.count)) {
        return false;
    }
    for (size_t i = 0; i < positions_.size(); ++i) {
        positions_[i] = positions[sources_[i]];
    }
    update_bounds();
    return true;
}

} // namespace occlude
