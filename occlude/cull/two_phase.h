// Two-phase occlusion culling with a hierarchical z-buffer on the CPU.
//
// Implements  the scheme of U. Haar, S. Aaltonen, "GPU-Driven Rendering Pipelines", SIGGRAPH 2015
//             courses, over the z pyramid of N. Greene, M. Kass, G. Miller, "Hierarchical Z-Buffer
//             Visibility", SIGGRAPH 1993.
// Map         phase 1, draw what was visible last frame -> CutTraversal::draw_visible
//             build the depth pyramid                   -> DepthTraversal::read
//             phase 2, test and draw the rest           -> DepthTraversal::test_candidates, reveal
//             the visible set of the next frame         -> DepthTraversal::retest
// Deviations  The pyramid is built on the CPU from one read-back of the target, by pixels or by
//             tiles that the device reduced (`tile`), and boxes are tested there: by their
//             rectangles, and then by their faces. Tests are hierarchical: the traversal starts
//             from the cut of the last frame (cut_traversal.h), and a hidden node hides its
//             subtree. Phase 2 reads depth again after `reread_triangles` newly
//             visible triangles, so that a camera cut, where phase 1 draws nothing, does not draw
//             everything in the frustum.
// Guarantees  exact: every item in the frustum is drawn, or it, or a node that holds it, was found
//             in this frame to lie wholly behind what was drawn. An item that phase 1 draws
//             although it is now hidden costs time, never pixels, and the next frame drops it.
// Cost        O(entries of the cut): one depth read-back per frame and one more per
//             `reread_triangles` revealed; well below a microsecond per test; no queries. Without
//             caps.read_depth nothing can be hidden: everything in the frustum is drawn in one
//             batch, and the frame is still exact.
#pragma once

#include <occlude/core/option_range.h>
#include <occlude/cull/culler.h>
#include <occlude/cull/parts/cut_traversal.h>
#include <occlude/cull/parts/depth_traversal.h>

#include <cstdint>

namespace occlude {

struct TwoPhaseOptions {
    /// Stop at virtual leaves. false: single items are tested, because a test costs less than
    /// drawing three triangles.
    bool virtual_leaves = false;
    /// Test down to single pixels where the coarse levels do not decide, and test the faces of
    /// boxes where their rectangles do not hide them. false: at most 4x4 texels are looked at, as
    /// on a GPU.
    bool refine = true;
    /// Read depth again when this many newly visible triangles wait to be drawn in phase 2, before
    /// the next test. 0: never.
    uint64_t reread_triangles = 16384;
    /// Choose the visible set of the next frame by the depth of the finished frame, which costs one
    /// more read-back, instead of by the depth that was read last.
    bool final_depth = false;
    /// Read the farthest depth of tiles of this many pixels along a side, which the device reduces,
    /// if it offers such tiles. Less is read back, and somewhat less is found hidden. 1: single
    /// pixels.
    uint32_t tile = 1;
    /// Test the shapes of items (item_shapes.h) if their boxes are not hidden.
    bool shapes = true;
};

class TwoPhase final : public Culler {
public:
    using Options = TwoPhaseOptions;
    static constexpr AlgorithmTraits kTraits{
        .name = "two_phase",
        .paper = "Greene, Kass, Miller 1993; Haar, Aaltonen 2015",
        .summary =
            "draws what was visible last frame, then tests the rest on the CPU against that depth",
        .needs = {.depth_read = true},
    };

    explicit TwoPhase(HierarchyRef hierarchy, TwoPhaseOptions options = {});

private:
    friend class CullerProbe; // of the tests
    void cull_frame(CullFrame& frame) override;
    void reset_state() override;

    TwoPhaseOptions options_;
    CutTraversal cut_;
    DepthTraversal depth_;
};

template <class Visit>
void visit_options(TwoPhaseOptions& o, Visit&& visit)
{
    visit("virtual_leaves", o.virtual_leaves, "stop at virtual leaves instead of testing items");
    visit("refine", o.refine,
          "test faces of boxes, down to pixels, where the coarse levels do not decide");
    visit("reread_triangles", o.reread_triangles, {},
          "newly visible triangles after which depth is read again; 0: never");
    visit("final_depth", o.final_depth,
          "choose what the next frame draws first by the depth of the finished frame");
    visit("tile", o.tile, {1, 1024},
          "read the farthest depth of tiles of this many pixels along a side; 1: pixels");
    visit("shapes", o.shapes,
          "test the boxes of an item's shape if the item's own box is not hidden");
}

} // namespace occlude
