// The walk of frustum culling: every leaf in the frustum, near to far.
#pragma once

#include <occlude/cull/parts/cull_frame.h>

#include <utility>
#include <vector>

namespace occlude {

/// Walks trees; an object keeps its memory from frame to frame.
class FrustumWalk {
public:
    /// Queues everything in the frustum. Precondition: the tree is not empty.
    void draw_all(CullFrame& frame);

private:
    struct Pending {
        NodeId node;
        PlaneMask mask;
    };

    std::vector<Pending> stack_;
    std::vector<std::pair<float, NodeId>> children_;
};

} // namespace occlude
