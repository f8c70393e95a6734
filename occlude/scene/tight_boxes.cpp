#include <occlude/scene/tight_boxes.h>

#include <occlude/core/assert.h>

#include <glm/common.hpp>

#include <algorithm>
#include <array>
#include <numeric>

namespace occlude {
namespace {

constexpr size_t kSlices = 16; // slices of the centroids along an axis; planes lie between them

// A box counts as thicker by this share of the longest side of the whole mesh.
constexpr float kThickness = 1.0f / 64.0f;

// Two boxes replace one if together they have less than this share of its volume.
constexpr double kWorthCutting = 0.9;

struct Triangle {
    Aabb box;
    glm::vec3 center;
};

struct Cut {
    int axis = -1; ///< -1: none
    float at = 0.0f;
};

struct Node {
    Aabb box;
    size_t first = 0; ///< of its triangles
    size_t count = 0;
    size_t children = 0; ///< the first of two; 0: a leaf
    bool whole = false;  ///< cannot be cut
};

class Cutter {
public:
    explicit Cutter(std::vector<Triangle> triangles)
        : triangles_(std::move(triangles))
    {
        nodes_.push_back(node_of(0, triangles_.size()));
        const glm::vec3 size = nodes_[0].box.extent();
        thickness_ = kThickness * std::max({size.x, size.y, size.z});
    }

    // Cuts the largest leaf.
    bool cut_one()
    {
        size_t largest = nodes_.size();
        for (size_t i = 0; i < nodes_.size(); ++i) {
            const Node& node = nodes_[i];
            if (node.children == 0 && !node.whole &&
                (largest == nodes_.size() || volume(node.box) > volume(nodes_[largest].box))) {
                largest = i;
            }
        }
        if (largest == nodes_.size()) {
            return false;
        }
        Node& node = nodes_[largest];
        const Cut cut = best_cut(node);
        if (cut.axis < 0) {
            node.whole = true;
            return true;
        }
        const auto from = triangles_.begin() + static_cast<ptrdiff_t>(node.first);
        const auto middle =
            std::partition(from, from + static_cast<ptrdiff_t>(node.count),
                           [&](const Triangle& t) { return t.center[cut.axis] < cut.at; });
        const auto left = static_cast<size_t>(middle - from);
        const size_t first = node.first;
        const size_t count = node.count;
        node.children = nodes_.size();
        nodes_.push_back(node_of(first, left));
        nodes_.push_back(node_of(first + left, count - left));
        return true;
    }

    Shape boxes() const
    {
        Shape out;
        collect(0, out);
        std::stable_sort(out.begin(), out.end(),
                         [this](const Aabb& a, const Aabb& b) { return volume(a) > volume(b); });
        return out;
    }

private:
    double volume(const Aabb& box) const
    {
        const glm::dvec3 size = glm::dvec3{box.extent()} + double{thickness_};
        return size.x * size.y * size.z;
    }

    Node node_of(size_t first, size_t count) const
    {
        Node node;
        node.first = first;
        node.count = count;
        for (size_t i = first; i < first + count; ++i) {
            node.box = merge(node.box, triangles_[i].box);
        }
        return node;
    }

    Cut best_cut(const Node& node) const
    {
        Aabb centers;
        for (size_t i = node.first; i < node.first + node.count; ++i) {
            centers = merge(centers, {triangles_[i].center, triangles_[i].center});
        }
        Cut best;
        double best_volume = 0.0;
        for (int axis = 0; axis < 3; ++axis) {
            const float low = centers.min[axis];
            const float step = (centers.max[axis] - low) / float{kSlices};
            if (!(step > 0.0f)) {
                continue;
            }
            const auto place = [&](size_t slice) { return low + step * static_cast<float>(slice); };
            std::array<Aabb, kSlices> slices;
            for (size_t i = node.first; i < node.first + node.count; ++i) {
                const Triangle& t = triangles_[i];
                auto slice =
                    std::min(static_cast<size_t>((t.center[axis] - low) / step), kSlices - 1);
                // As the cut will compute it.
                slice -= slice > 0 && t.center[axis] < place(slice) ? 1 : 0;
                slice += slice + 1 < kSlices && t.center[axis] >= place(slice + 1) ? 1 : 0;
                slices[slice] = merge(slices[slice], t.box);
            }
            std::array<Aabb, kSlices> above;
            above[kSlices - 1] = slices[kSlices - 1];
            for (size_t i = kSlices - 1; i > 0; --i) {
                above[i - 1] = merge(slices[i - 1], above[i]);
            }
            Aabb below;
            for (size_t i = 1; i < kSlices; ++i) {
                below = merge(below, slices[i - 1]);
                if (below.is_empty() || above[i].is_empty()) {
                    continue;
                }
                const double both = volume(below) + volume(above[i]);
                if (best.axis < 0 || both < best_volume) {
                    best = {axis, place(i)};
                    best_volume = both;
                }
            }
        }
        return best;
    }

    // The least volume of the subtree of a node, in boxes that are worth it; appends these to
    // `out`.
    double collect(size_t at, Shape& out) const
    {
        const Node& node = nodes_[at];
        const size_t before = out.size();
        const double whole = volume(node.box);
        if (node.children != 0) {
            const double parts = collect(node.children, out) + collect(node.children + 1, out);
            if (parts < kWorthCutting * whole) {
                return parts;
            }
            out.resize(before);
        }
        out.push_back(node.box);
        return whole;
    }

    std::vector<Triangle> triangles_;
    std::vector<Node> nodes_;
    float thickness_ = 0.0f;
};

} // namespace

Shape tight_boxes(std::span<const glm::vec3> positions, std::span<const uint32_t> indices,
                  uint32_t most_boxes)
{
    OCCLUDE_ASSERT(indices.size() % 3 == 0, "there must be three indices per triangle");
    const bool inside = std::all_of(indices.begin(), indices.end(),
                                    [&](uint32_t index) { return index < positions.size(); });
    OCCLUDE_ASSERT(inside, "every index must be less than the number of positions");
    if (!inside) {
        return {Aabb::everything()};
    }
    std::vector<Triangle> triangles;
    triangles.reserve(indices.size() / 3);
    for (size_t i = 0; i + 2 < indices.size(); i += 3) {
        const glm::vec3& a = positions[indices[i]];
        const glm::vec3& b = positions[indices[i + 1]];
        const glm::vec3& c = positions[indices[i + 2]];
        const Aabb box{glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))};
        const glm::vec3 sum = a + b + c; // not finite if any of them is not
        if (!Aabb{sum, sum}.is_bounded()) {
            return {Aabb::everything()};
        }
        triangles.push_back({box, box.center()});
    }
    if (triangles.empty() || most_boxes == 0) {
        return {};
    }
    Cutter cutter{std::move(triangles)};
    for (uint32_t boxes = 1; boxes < most_boxes && cutter.cut_one(); ++boxes) {
    }
    return cutter.boxes();
}

} // namespace occlude
