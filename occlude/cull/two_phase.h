// Two-phase occlusion culling with a hierarchical z-buffer on the CPU.
//
// Implements  the scheme of U. Haar, S. Aaltonen, "GPU-Driven Rendering Pipelines", SIGGRAPH 2015
//             courses, over the z pyramid of N. Greene, M. Kass, G. Miller, "Hierarchical Z-Buffer
//             Visibility", SIGGRAPH 1993.
// Map         phase 1, draw what was visible last frame -> draw_last_visible
//             build the depth pyramid                   -> read_pyramid
//             phase 2, test and draw the rest           -> test_the_rest
//             the visible set of the next frame         -> keep_visible
// Deviations  The pyramid is built on the CPU from one read-back of the target, and boxes are tested
//             there. Tests are hierarchical: a hidden node hides its subtree. Phase 2 reads depth
//             again after `reread_triangles` newly visible triangles, so that a camera cut, where
//             phase 1 draws nothing, is not drawn as a whole.
// Guarantees  exact: every item in the frustum is drawn, or lies in a node whose screen rectangle
//             was, in this frame, wholly nearer than the node. What is drawn in phase 1 and hidden
//             now costs time, never pixels, and is dropped in the next frame.
// Cost        one depth read-back per frame and one more per `reread_triangles` revealed; well below
//             a microsecond per tested node; no queries. Without caps.read_depth nothing can be
//             hidden: everything in the frustum is drawn, in one batch, still exact.
#pragma once

#include <occlude/core/depth_pyramid.h>
#include <occlude/cull/culler.h>

#include <cstdint>
#include <utility>
#include <vector>

namespace occlude {

struct TwoPhaseOptions {
    /// Stop at virtual leaves. Otherwise single items are tested: a test here costs less than
    /// drawing three triangles.
    bool virtual_leaves = false;
    /// Go down to single pixels where the coarse levels do not decide. Otherwise at most 4x4 texels
    /// are looked at, as on a GPU.
    bool refine = true;
    /// Read depth again when so many newly visible triangles wait to be drawn in phase 2, before
    /// more is tested. 0: never.
    uint64_t reread_triangles = 16384;
    /// Choose the visible set of the next frame by the depth of the finished frame, read back once
    /// more, instead of that of phase 1.
    bool final_depth = false;
};

class TwoPhase final : public Culler {
public:
    explicit TwoPhase(const Hierarchy& hierarchy, TwoPhaseOptions options = {})
        : Culler(hierarchy)
        , options_(options)
    {
    }

    /// True if `node` was found visible by the last frame and will be drawn first in the next.
    bool visible(NodeId node) const;

private:
    struct Entry {
        NodeId node;
        PlaneMask mask;
    };

    void cull_frame(CullFrame& frame) override;
    void reset_state() override { draw_first_.clear(); }

    void draw_last_visible(CullFrame& frame);
    void read_pyramid(CullFrame& frame);
    void test_the_rest(CullFrame& frame);
    void keep_visible(CullFrame& frame);

    bool is_leaf(NodeId node) const;
    bool hidden(const CullFrame& frame, NodeId node) const;
    void open(CullFrame& frame, const Entry& entry, Decision decision);

    TwoPhaseOptions options_;
    std::vector<uint32_t> draw_first_; ///< per node: stamp of the last frame whose phase 1 draws it
    uint32_t next_stamp_ = 1;          ///< of the next frame
    DepthPyramid pyramid_;
    bool depth_known_ = false; ///< the pyramid holds depth of this frame
    std::vector<Entry> stack_;
    std::vector<Entry> boundary_; ///< in the frustum and not visible last frame, near to far
    std::vector<NodeId> opened_;  ///< drawn or opened in this frame, parents first
    size_t opened_untested_ = 0;  ///< how many of them in phase 1
    std::vector<std::pair<float, NodeId>> children_;
};

template <class Visit>
void visit_options(TwoPhaseOptions& o, Visit&& visit)
{
    visit("virtual_leaves", o.virtual_leaves, "stop at virtual leaves instead of testing items");
    visit("refine", o.refine, "go down to pixels where the coarse levels do not decide");
    visit("reread_triangles", o.reread_triangles,
          "newly visible triangles after which depth is read again; 0 is never");
    visit("final_depth", o.final_depth,
          "choose what is drawn first in the next frame by this frame's final depth");
}

} // namespace occlude
