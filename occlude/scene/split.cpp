#include <occlude/scene/split.h>

#include <occlude/core/assert.h>
#include <occlude/core/rng.h>
#include <occlude/scene/detail/split_plane.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <utility>

namespace occlude {
namespace {

constexpr uint32_t kMaxDepth = 64;
/// A plane cuts a triangle into at most three pieces, two more than before.
constexpr uint64_t kMostAddedPerCut = 2;

using Plane = detail::SplitPlane;

struct Triangle {
    std::array<uint32_t, 3> corner{};
};

uint64_t pair_key(uint32_t a, uint32_t b)
{
    return uint64_t{a} << 32 | b;
}

struct KeyHash {
    size_t operator()(uint64_t key) const { return mix64(key); }
};

struct PositionHash {
    size_t operator()(const glm::vec3& v) const
    {
        const auto bits = [](float x) { return std::bit_cast<uint32_t>(x == 0.0f ? 0.0f : x); };
        return hash64(bits(v.x), bits(v.y), bits(v.z));
    }
};

bool finite(const glm::vec3& v)
{
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

class Splitter {
public:
    Splitter(std::span<const glm::vec3> positions, std::span<const glm::vec3> normals,
             uint32_t max_triangles)
        : max_triangles_(max_triangles)
    {
        out_.positions.assign(positions.begin(), positions.end());
        out_.normals.assign(normals.begin(), normals.end());
        for (const glm::vec3& position : out_.positions) {
            points_.push_back(point_at(position));
        }
    }

    SplitMesh run(std::span<const uint32_t> indices)
    {
        std::vector<Triangle> triangles;
        for (size_t i = 0; i + 3 <= indices.size(); i += 3) {
            triangles.push_back({{indices[i], indices[i + 1], indices[i + 2]}});
        }
        if (!triangles.empty()) {
            growth_left_ = (kMaxSplitGrowth - 1) * uint64_t{triangles.size()};
            out_.tree.nodes.resize(1);
            split(0, std::move(triangles), 0);
            emit_parts();
            const size_t before = indices.size() / 3;
            const size_t now = out_.indices.size() / 3;
            out_.cut_triangles = static_cast<uint32_t>(now > before ? now - before : 0);
        }
        return std::move(out_);
    }

private:
    /// The point at which an edge between two points was cut.
    struct Cut {
        uint32_t point = 0;
        float share = 0.0f; ///< share of the way from the point with the smaller position to the
                            ///< other
    };

    // Vertices at the same position are the same point, whatever their normals.
    uint32_t point_at(const glm::vec3& position)
    {
        const auto next = static_cast<uint32_t>(places_.size());
        if (!finite(position)) {
            places_.push_back(position);
            return next;
        }
        const auto [at, is_new] = point_ids_.try_emplace(position, next);
        if (is_new) {
            places_.push_back(position);
        }
        return at->second;
    }

    bool smaller(uint32_t a, uint32_t b) const
    {
        const glm::vec3& p = places_[a];
        const glm::vec3& q = places_[b];
        return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : p.z < q.z;
    }

    uint64_t edge_key(uint32_t a, uint32_t b) const
    {
        return smaller(a, b) ? pair_key(a, b) : pair_key(b, a);
    }

    // Cuts the edge between two points, always from the smaller to the larger.
    void cut_edge(uint32_t a, uint32_t b, const Plane& plane)
    {
        if (smaller(b, a)) {
            std::swap(a, b);
        }
        const glm::vec3 from = places_[a];
        const glm::vec3 to = places_[b];
        const double low = from[plane.axis];
        const double share = (plane.at - low) / (double{to[plane.axis]} - low);
        const glm::dvec3 from_exact{from};
        glm::vec3 place{from_exact + share * (glm::dvec3{to} - from_exact)};
        place[plane.axis] = plane.at;
        const uint32_t point = point_at(place);
        cuts_.try_emplace(pair_key(a, b), Cut{point, static_cast<float>(share)});
    }

    // The vertex where the edge between two vertices was cut, with its normal.
    uint32_t cut_vertex(uint32_t a, uint32_t b, const Cut& cut)
    {
        if (smaller(points_[b], points_[a])) {
            std::swap(a, b);
        }
        const auto next = static_cast<uint32_t>(out_.positions.size());
        const auto [at, is_new] = cut_vertices_.try_emplace(pair_key(a, b), next);
        if (is_new) {
            const glm::vec3 sum = glm::mix(out_.normals[a], out_.normals[b], cut.share);
            const float length = glm::length(sum);
            out_.normals.push_back(length > 0.0f ? sum / length : out_.normals[a]);
            out_.positions.push_back(places_[cut.point]);
            points_.push_back(cut.point);
        }
        return at->second;
    }

    const Cut* find_cut(uint32_t a, uint32_t b) const
    {
        const auto found = cuts_.find(edge_key(points_[a], points_[b]));
        return found != cuts_.end() ? &found->second : nullptr;
    }

    // True for triangles that still have three corners.
    bool has_corners(const Triangle& t) const
    {
        const uint32_t a = points_[t.corner[0]];
        const uint32_t b = points_[t.corner[1]];
        const uint32_t c = points_[t.corner[2]];
        return a != b && b != c && c != a;
    }

    // Appends the triangle, cut at every point where its edges were cut already.
    void close(const Triangle& triangle, std::vector<Triangle>& closed)
    {
        open_.assign(1, triangle);
        while (!open_.empty()) {
            const Triangle t = open_.back();
            open_.pop_back();
            bool whole = true;
            for (size_t i = 0; i < 3 && whole; ++i) {
                const uint32_t a = t.corner[i];
                const uint32_t b = t.corner[(i + 1) % 3];
                const uint32_t c = t.corner[(i + 2) % 3];
                if (const Cut* cut = find_cut(a, b)) {
                    const uint32_t m = cut_vertex(a, b, *cut);
                    for (const Triangle& half : {Triangle{{m, b, c}}, Triangle{{a, m, c}}}) {
                        if (has_corners(half)) {
                            open_.push_back(half);
                        }
                    }
                    whole = false;
                }
            }
            if (whole) {
                closed.push_back(t);
            }
        }
    }

    float coordinate(uint32_t vertex, int axis) const { return out_.positions[vertex][axis]; }

    Aabb box_of(const Triangle& t) const
    {
        Aabb box;
        for (const uint32_t corner : t.corner) {
            if (!finite(out_.positions[corner])) {
                return Aabb::everything();
            }
            box = merge(box, {out_.positions[corner], out_.positions[corner]});
        }
        return box;
    }

    // Divides one closed triangle by a plane: into two or three pieces if it straddles the plane.
    void clip(const Triangle& t, const Plane& plane, std::vector<Triangle>& low,
              std::vector<Triangle>& high)
    {
        const Aabb box = box_of(t);
        if (!box.is_bounded() || box.max[plane.axis] <= plane.at) {
            low.push_back(t);
            return;
        }
        if (box.min[plane.axis] >= plane.at) {
            high.push_back(t);
            return;
        }
        for (size_t i = 0; i < 3; ++i) {
            const uint32_t a = t.corner[i];
            const uint32_t b = t.corner[(i + 1) % 3];
            const float at_a = coordinate(a, plane.axis);
            const float at_b = coordinate(b, plane.axis);
            if ((at_a < plane.at && at_b > plane.at) || (at_a > plane.at && at_b < plane.at)) {
                cut_edge(points_[a], points_[b], plane);
            }
        }
        std::vector<Triangle> pieces;
        close(t, pieces);
        for (const Triangle& piece : pieces) {
            // A piece touches the plane but does not straddle it.
            const bool above = box_of(piece).max[plane.axis] > plane.at;
            (above ? high : low).push_back(piece);
        }
    }

    // Nothing if no plane separates the triangles, or if each plane that does would add more
    // triangles than are allowed.
    std::optional<Plane> choose_plane(std::span<const Triangle> triangles)
    {
        std::vector<Aabb> boxes;
        for (const Triangle& t : triangles) {
            boxes.push_back(box_of(t));
        }
        const detail::SplitChoice choice =
            detail::choose_split_plane(boxes, growth_left_ / kMostAddedPerCut);
        out_.unsplit_parts += !choice.plane && choice.cuts_too_many ? 1 : 0;
        return choice.plane;
    }

    void make_leaf(uint32_t node, std::vector<Triangle> triangles)
    {
        out_.tree.nodes[node].part = static_cast<uint32_t>(leaves_.size());
        leaves_.push_back(std::move(triangles));
    }

    void split(uint32_t node, std::vector<Triangle> triangles, uint32_t depth)
    {
        const bool large = triangles.size() > max_triangles_ && depth < kMaxDepth;
        const std::optional<Plane> plane = large ? choose_plane(triangles) : std::nullopt;
        if (!plane) {
            make_leaf(node, std::move(triangles));
            return;
        }
        std::vector<Triangle> low;
        std::vector<Triangle> high;
        std::vector<Triangle> closed;
        for (const Triangle& t : triangles) {
            closed.clear();
            close(t, closed);
            for (const Triangle& piece : closed) {
                clip(piece, *plane, low, high);
            }
        }
        const size_t pieces = low.size() + high.size();
        const size_t added = pieces > triangles.size() ? pieces - triangles.size() : 0;
        growth_left_ -= std::min<uint64_t>(growth_left_, added);
        triangles = {};
        if (low.empty() || high.empty()) { // the pieces shrank to lines
            make_leaf(node, std::move(low.empty() ? high : low));
            return;
        }
        const auto child = static_cast<uint32_t>(out_.tree.nodes.size());
        out_.tree.nodes[node].first_child = child;
        out_.tree.nodes.resize(child + 2);
        split(child, std::move(low), depth + 1);
        split(child + 1, std::move(high), depth + 1);
    }

    // Adds the corners that its neighbours' cuts put on its edges to every leaf, and writes it out.
    void emit_parts()
    {
        std::vector<Triangle> closed;
        for (const std::vector<Triangle>& leaf : leaves_) {
            PartitionPart part;
            part.first_index = static_cast<uint32_t>(out_.indices.size());
            closed.clear();
            for (const Triangle& t : leaf) {
                close(t, closed);
            }
            for (const Triangle& t : closed) {
                out_.indices.insert(out_.indices.end(), t.corner.begin(), t.corner.end());
                part.box = merge(part.box, box_of(t));
            }
            part.index_count = static_cast<uint32_t>(3 * closed.size());
            out_.parts.push_back(part);
        }
        for (size_t i = out_.tree.nodes.size(); i-- > 0;) {
            LocalTree::Node& node = out_.tree.nodes[i];
            node.box = node.first_child == LocalTree::kNone
                           ? out_.parts[node.part].box
                           : merge(out_.tree.nodes[node.first_child].box,
                                   out_.tree.nodes[node.first_child + 1].box);
        }
    }

    uint32_t max_triangles_;
    uint64_t growth_left_ = 0; ///< how many triangles may still be added
    SplitMesh out_;
    std::vector<uint32_t> points_;  ///< per vertex: its point
    std::vector<glm::vec3> places_; ///< per point
    std::unordered_map<glm::vec3, uint32_t, PositionHash> point_ids_;
    std::unordered_map<uint64_t, Cut, KeyHash> cuts_;
    std::unordered_map<uint64_t, uint32_t, KeyHash> cut_vertices_; ///< by the ends' vertices
    std::vector<std::vector<Triangle>> leaves_;
    std::vector<Triangle> open_;
};

} // namespace

SplitMesh split_triangles(std::span<const glm::vec3> positions, std::span<const glm::vec3> normals,
                          std::span<const uint32_t> indices, uint32_t max_triangles)
{
    OCCLUDE_ASSERT(indices.size() % 3 == 0,
                   "split_triangles() needs three indices for each triangle");
    OCCLUDE_ASSERT(max_triangles > 0, "split_triangles() needs max_triangles > 0");
    const bool inside = positions.size() == normals.size() &&
                        std::all_of(indices.begin(), indices.end(),
                                    [&](uint32_t index) { return index < positions.size(); });
    OCCLUDE_ASSERT(inside, "split_triangles() needs a position and a normal for each index");
    if (!inside) {
        return {};
    }
    return Splitter{positions, normals, std::max(max_triangles, 1u)}.run(
        indices.first(indices.size() / 3 * 3));
}

} // namespace occlude
