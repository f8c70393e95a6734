// One camera in one context: its hierarchy, culler and device, and how a frame of leaves is drawn.
#pragma once

#include "host_culler.h"
#include "leaf_items.h"
#include "leaf_kind.h"
#include "leaf_scene.h"

#include <occlude/core/view.h>
#include <occlude/osg/osg_culling.h>

#include <osg/Matrix>
#include <osg/Viewport>
#include <osg/ref_ptr>
#include <osgUtil/RenderLeaf>
#include <osgUtil/StateGraph>

#include <vector>

namespace occlude {

/// What the cull traversal found below the node for one view, to be drawn later.
struct LeafFrame {
    std::vector<osgUtil::StateGraph*> graphs; ///< in the engine's order; they live until drawn
    osg::Matrixd eye_from_world;
    osg::ref_ptr<osg::Viewport> viewport;
    /// All drawables below the node, for a view that is new; else empty.
    std::vector<PlacedDrawable> expected;
    std::vector<osg::ref_ptr<const osg::Drawable>> expected_owners;
};

class ViewCuller {
public:
    explicit ViewCuller(const OsgCullingOptions& options);

    /// Draws the leaves of the frame. `proxy` is the leaf in whose place they are drawn, and whose
    /// state is set, before and after.
    void draw(osg::RenderInfo& info, osgUtil::RenderLeaf& proxy, const LeafFrame& frame);

    const OsgCullingStats& stats() const { return stats_; }

private:
    void collect(const LeafFrame& frame);
    void choose_segment();
    void place_items(const LeafFrame& frame, const osg::RefMatrix* projection);
    void draw_plain(size_t begin, size_t end);
    void cull(const LeafFrame& frame, osg::RenderInfo& info);

    OsgCullingOptions options_;
    LeafItems items_;
    LeafScene scene_;
    LeafRenderer renderer_;
    StateKinds state_kinds_;
    HostCuller culler_;

    // Of the frame that is drawn.
    struct Frame {
        std::vector<osgUtil::RenderLeaf*> leaves; ///< by place, the engine's order
        std::vector<LeafKind> kinds;              ///< by place
        size_t segment_begin = 0;                 ///< the places among which order does not matter
        size_t segment_end = 0;
        std::vector<uint32_t> testable;    ///< places
        std::vector<PlacedDrawable> poses; ///< of testable
        std::vector<ItemId> ids;           ///< of testable
        std::vector<uint32_t> first;       ///< places to be drawn before all tests
        std::vector<uint32_t> place_of_item;
    };
    Frame frame_;
    OsgCullingStats stats_;
};

} // namespace occlude
