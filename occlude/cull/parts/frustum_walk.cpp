#include <occlude/cull/parts/frustum_walk.h>

#include <occlude/cull/parts/near_to_far.h>

namespace occlude {

void FrustumWalk::draw_all(CullFrame& frame)
{
    const Hierarchy& hierarchy = frame.hierarchy();
    stack_.assign(1, {hierarchy.root(), Frustum::kAllPlanes});
    while (!stack_.empty()) {
        auto [node, mask] = stack_.back();
        stack_.pop_back();
        if (!frame.visit(node, mask)) {
            continue;
        }
        if (hierarchy.is_leaf(node)) {
            frame.draw_leaf(node, mask, Decision::drawn);
            continue;
        }
        frame.draw_own(node, mask, Decision::drawn);
        push_far_to_near(hierarchy, frame.view(), node, children_,
                         [&, planes = mask](NodeId child) {
                             stack_.push_back({child, planes});
                         });
    }
}

} // namespace occlude
