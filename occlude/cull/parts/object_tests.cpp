#include <occlude/cull/parts/object_tests.h>

#include <glm/common.hpp>

#include <algorithm>

namespace occlude {

float screen_share(const View& view, const Aabb& box)
{
    if (!box.is_bounded()) {
        return box.is_empty() ? 0.0f : 1.0f;
    }
    glm::dvec2 low{1.0};
    glm::dvec2 high{-1.0};
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p{(corner & 1) != 0 ? box.max.x : box.min.x,
                           (corner & 2) != 0 ? box.max.y : box.min.y,
                           (corner & 4) != 0 ? box.max.z : box.min.z};
        const glm::dvec4 clip = view.clip_from_relative() * glm::dvec4{p - view.origin(), 1.0};
        if (!(clip.w > 0.0)) {
            return 1.0f;
        }
        low = glm::min(low, glm::dvec2{clip} / clip.w);
        high = glm::max(high, glm::dvec2{clip} / clip.w);
    }
    const glm::dvec2 size = glm::min(high, 1.0) - glm::max(low, -1.0);
    return size.x > 0.0 && size.y > 0.0 ? static_cast<float>(0.25 * size.x * size.y) : 0.0f;
}

bool ObjectTests::in_frustum(CullFrame& frame, NodeId node, PlaneMask& mask) const
{
    return options_.sphere_elongation > 0.0f
               ? frame.visit_sphere_first(node, mask, options_.sphere_elongation)
               : frame.visit(node, mask);
}

std::span<const ObjectTests::Object> ObjectTests::collect_near_to_far(CullFrame& frame)
{
    const Hierarchy& hierarchy = frame.hierarchy();
    objects_.clear();
    stack_.assign(1, {hierarchy.root(), Frustum::kAllPlanes});
    while (!stack_.empty()) {
        auto [node, mask] = stack_.back();
        stack_.pop_back();
        if (!in_frustum(frame, node, mask)) {
            continue;
        }
        const Node& n = hierarchy.node(node);
        if (hierarchy.is_leaf(node)) {
            objects_.push_back({frame.view().distance_key(n.box), node, mask});
            continue;
        }
        frame.draw_own(node, mask, Decision::drawn);
        for (uint32_t i = 0; i < n.child_count; ++i) {
            stack_.push_back({NodeId{n.first_child.value + i}, mask});
        }
    }
    std::sort(objects_.begin(), objects_.end(), [](const Object& a, const Object& b) {
        return a.distance != b.distance ? a.distance < b.distance : a.node < b.node;
    });
    return objects_;
}

bool ObjectTests::worth_testing(const CullFrame& frame, NodeId node) const
{
    const Node& n = frame.hierarchy().node(node);
    if (n.subtree_triangles < options_.skip_triangles_below) {
        return false;
    }
    const View& view = frame.view();
    if (options_.skip_nearer_than > 0.0f) {
        const float key = view.distance_key(n.box); // squared unless orthographic
        const float distance = options_.skip_nearer_than;
        if (key < (view.orthographic() ? distance : distance * distance)) {
            return false;
        }
    }
    const glm::ivec2 size = view.size_px();
    const bool high_resolution =
        int64_t{size.x} * int64_t{size.y} >= int64_t{options_.high_resolution};
    return options_.skip_larger_than >= 1.0f || !high_resolution ||
           screen_share(view, n.box) <= options_.skip_larger_than;
}

void ObjectTests::add_test(const CullFrame& frame, NodeId node, TestBatch& batch)
{
    for (const NodeId part : tight_bounds_.collect(frame.hierarchy(), node, options_.sub_box_depth,
                                                   options_.sub_box_area)) {
        batch.add_box(frame.test_box(part), node);
    }
    batch.end_test();
}

} // namespace occlude
