// Occlusion culling inside OpenSceneGraph 3.6: what lies hidden below a node is not drawn.
//
//   osg::ref_ptr<occlude::OsgCulling> culling =
//   occlude::OsgCulling::attach(*viewer.getSceneData());
//
// The engine's cull traversal stays as it is: levels of detail, switches, paging, callbacks, bins
// and sorting work as before. The adapter takes the opaque leaves that the traversal has put below
// the node, and draws those that may be seen, in the engine's order within each batch.
//
// Which leaves   Geometry in the bin that the node itself is drawn in. Leaves in other bins, such
//                as transparent ones, are drawn by the engine, in their order, afterwards.
// Which state    A leaf is left out only if it is drawn as opaque triangles: depth test LESS or
//                LEQUAL, depth written, no blending, stencil, logic operation or colour mask.
//                Everything else in the bin is drawn, in its place.
// Boxes          Drawable::getBoundingBox(), as for the engine's own frustum culling: call
//                dirtyBound() when vertices change. A drawable whose setCullingActive(false) is set
//                is always drawn.
// Image          The same as without the adapter, pixel by pixel, with two exceptions that
//                docs/adapters/osg.md explains: surfaces at equal depth, and llvmpipe's needles.
// Threads        All threading models of osgViewer. Cameras and contexts are independent.
// State          osg::State never notices: what tests change in OpenGL is put back exactly.
// Cost           About a tenth of a microsecond per leaf and frame, besides what culling saves.
#pragma once

#include <occlude/core/frame_report.h>
#include <occlude/core/messages.h>

#include <osg/Callback>
#include <osg/Node>
#include <osg/StateSet>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace osgUtil {
class CullVisitor;
class StateGraph;
} // namespace osgUtil

namespace occlude {

class ViewTable;

struct OsgCullingOptions {
    /// The algorithm, by the name that the registry knows (cull/registry.h). `adaptive` measures
    /// what drawing and testing cost, and draws everything where culling does not pay.
    std::string algorithm = "adaptive";
    /// Fewer leaves than this in a view are drawn without culling.
    uint32_t min_leaves = 16;
    /// Hears of faults, in the thread that draws.
    MessageHandler on_message = {};
};

/// What the last frame of one view came to. Leaves are those that the cull traversal of the engine
/// found below the node, in the bin of the node.
struct OsgCullingStats {
    uint64_t leaves = 0;
    uint64_t hidden_leaves = 0;  ///< found hidden, and not drawn
    uint64_t unknown_leaves = 0; ///< not in the hierarchy yet, and drawn first
    uint64_t exempt_leaves = 0;  ///< drawn as they came, because of their state or their kind
    uint64_t moved_leaves = 0;   ///< whose box has changed since the last frame
    uint64_t rebuilds = 0;       ///< hierarchies built since the view was first drawn
    FrameReport report;
};

/// Culls what is below the nodes that it is the cull callback of. One object may serve several
/// nodes, cameras and contexts. Thread-safe as the engine's nodes are: change it where you would
/// change the scene.
class OsgCulling final : public osg::NodeCallback {
public:
    explicit OsgCulling(OsgCullingOptions options = {});

    /// Adds a new OsgCulling to the cull callbacks of `node`, before those that are there.
    static osg::ref_ptr<OsgCulling> attach(osg::Node& node, OsgCullingOptions options = {});
    /// Takes the callback away again. What it holds in OpenGL goes with its last reference, or with
    /// the context.
    void detach(osg::Node& node);

    /// When false, the frames from the next on are drawn by the engine alone.
    void set_enabled(bool enabled);
    bool enabled() const;

    /// The sum over all views of what their last frames came to; `report` is that of the view that
    /// was drawn last.
    OsgCullingStats stats() const;

    void operator()(osg::Node* node, osg::NodeVisitor* visitor) override;
    void releaseGLObjects(osg::State* state) const override;

private:
    ~OsgCulling() override;
    void take_leaves(osg::Node& node, osgUtil::CullVisitor& cull,
                     std::vector<osgUtil::StateGraph*>& graphs, size_t before);

    osg::ref_ptr<osg::StateSet> leaves_state_; ///< empty: keeps our leaves in graphs of their own
    osg::ref_ptr<osg::StateSet> proxy_state_;  ///< empty: ... and what stands for them in another
    std::shared_ptr<ViewTable> views_;
};

} // namespace occlude
