#include <occlude/cull/stop_and_wait.h>

#include <occlude/cull/parts/cull_frame.h>
#include <occlude/cull/parts/near_to_far.h>

namespace occlude {

void StopAndWait::cull_frame(CullFrame& frame)
{
    stack_.assign(1, {hierarchy().root(), Frustum::kAllPlanes});
    while (!stack_.empty()) {
        auto [node, mask] = stack_.back();
        stack_.pop_back();
        if (!frame.visit(node, mask)) {
            continue;
        }
        Decision decision = Decision::drawn_near;
        if (!frame.near(node)) {
            frame.flush_draws();
            if (!is_visible(frame.wait(frame.query(node)), options_.threshold)) {
                frame.decide(node, Decision::hidden);
                continue;
            }
            decision = Decision::drawn_revealed;
        }
        if (hierarchy().is_leaf(node)) {
            frame.draw_leaf(node, mask, decision);
            continue;
        }
        frame.draw_own(node, mask, decision);
        push_far_to_near(hierarchy(), frame.view(), node, children_,
                         [&, planes = mask](NodeId child) {
                             stack_.push_back({child, planes});
                         });
    }
}

} // namespace occlude
