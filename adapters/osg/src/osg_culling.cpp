#include <occlude/osg/osg_culling.h>

#include "view_table.h"

#include <osg/Camera>
#include <osg/Drawable>
#include <osg/FrameStamp>
#include <osg/Transform>
#include <osgUtil/CullVisitor>

#include <glm/gtc/type_ptr.hpp>

#include <algorithm>
#include <utility>

namespace occlude {

namespace {

// Stands in the engine's list for the leaves that were taken from it, and draws them.
class LeavesDrawable final : public osg::Drawable {
public:
    LeavesDrawable(std::shared_ptr<ViewTable> views, const osg::Camera* camera, uint32_t pass)
        : views_(std::move(views))
        , camera_(camera)
        , pass_(pass)
    {
        setUseDisplayList(false);
        setUseVertexArrayObject(false);
        setCullingActive(false);
    }

    void drawImplementation(osg::RenderInfo& info) const override
    {
        views_->draw({camera_, pass_, info.getContextID()}, info, *leaf, frame);
    }

    LeafFrame frame;
    osgUtil::RenderLeaf* leaf = nullptr; ///< that draws this

private:
    std::shared_ptr<ViewTable> views_;
    const osg::Camera* camera_;
    uint32_t pass_;
};

// All drawables below a node, where they would be drawn. Nested cameras have views of their own.
class Collector final : public osg::NodeVisitor {
public:
    Collector(const osg::Matrixd& world_from_node, LeafFrame& frame)
        : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN)
        , matrices_{world_from_node}
        , frame_(frame)
    {
    }

    void apply(osg::Drawable& drawable) override
    {
        frame_.expected.push_back({&drawable, glm::make_mat4(matrices_.back().ptr())});
        frame_.expected_owners.emplace_back(&drawable);
    }
    void apply(osg::Transform& transform) override
    {
        osg::Matrixd matrix = matrices_.back();
        transform.computeLocalToWorldMatrix(matrix, this);
        matrices_.push_back(matrix);
        traverse(transform);
        matrices_.pop_back();
    }
    void apply(osg::Camera&) override {}

private:
    std::vector<osg::Matrixd> matrices_;
    LeafFrame& frame_;
};

bool any_dynamic(std::span<osgUtil::StateGraph* const> graphs)
{
    return std::ranges::any_of(graphs, [](const osgUtil::StateGraph* graph) {
        return std::ranges::any_of(graph->_leaves, [](const auto& leaf) { return leaf->_dynamic; });
    });
}

// What the view needs to know of the camera, as of this traversal.
void describe_camera(osgUtil::CullVisitor& cull, LeafFrame& frame)
{
    osgUtil::RenderStage& stage = *cull.getCurrentRenderStage();
    if (const osg::RefMatrix* view = stage.getInitialViewMatrix()) {
        frame.eye_from_world = *view;
    }
    if (stage.getViewport() != nullptr) {
        frame.viewport = new osg::Viewport(*stage.getViewport());
    } else {
        frame.viewport = new osg::Viewport;
    }
}

} // namespace

OsgCulling::OsgCulling(OsgCullingOptions options)
    : leaves_state_(new osg::StateSet)
    , proxy_state_(new osg::StateSet)
    , views_(std::make_shared<ViewTable>(std::move(options)))
{
}

OsgCulling::~OsgCulling() = default;

osg::ref_ptr<OsgCulling> OsgCulling::attach(osg::Node& node, OsgCullingOptions options)
{
    osg::ref_ptr<OsgCulling> culling = new OsgCulling(std::move(options));
    osg::ref_ptr<osg::Callback> others = node.getCullCallback();
    culling->setNestedCallback(others.get());
    node.setCullCallback(culling.get());
    return culling;
}

void OsgCulling::detach(osg::Node& node)
{
    node.removeCullCallback(this);
}

void OsgCulling::set_enabled(bool enabled)
{
    views_->set_enabled(enabled);
}

bool OsgCulling::enabled() const
{
    return views_->enabled();
}

OsgCullingStats OsgCulling::stats() const
{
    return views_->stats();
}

void OsgCulling::operator()(osg::Node* node, osg::NodeVisitor* visitor)
{
    osgUtil::CullVisitor* cull = visitor->asCullVisitor();
    osgUtil::RenderBin* bin = cull != nullptr ? cull->getCurrentRenderBin() : nullptr;
    if (bin == nullptr || !enabled() || bin->getSortMode() != osgUtil::RenderBin::SORT_BY_STATE) {
        traverse(node, visitor);
        return;
    }
    osgUtil::RenderBin::StateGraphList& graphs = bin->getStateGraphList();
    const size_t before = graphs.size();
    cull->pushStateSet(leaves_state_.get());
    traverse(node, visitor);
    cull->popStateSet();
    take_leaves(*node, *cull, graphs, before);
}

// Moves the graphs that the traversal has added to the bin into a drawable, and puts that one there
// instead.
void OsgCulling::take_leaves(osg::Node& node, osgUtil::CullVisitor& cull,
                             std::vector<osgUtil::StateGraph*>& graphs, size_t before)
{
    cull.pushStateSet(proxy_state_.get());
    if (graphs.size() == before) {
        // A node with two parents: the leaves are in graphs that were taken already.
        for (const auto& leaf : cull.getCurrentStateGraph()->_leaves) {
            leaf->_dynamic = true;
        }
        cull.popStateSet();
        return;
    }
    const osg::Camera* camera = cull.getCurrentCamera();
    const osg::FrameStamp* stamp = cull.getFrameStamp();
    const ViewTable::Pass pass =
        views_->next_pass(camera, stamp != nullptr ? stamp->getFrameNumber() : 0);
    osg::ref_ptr<LeavesDrawable> drawable = new LeavesDrawable(views_, camera, pass.index);
    LeafFrame& frame = drawable->frame;
    frame.graphs.assign(graphs.begin() + static_cast<ptrdiff_t>(before), graphs.end());
    graphs.resize(before);
    describe_camera(cull, frame);
    if (pass.is_new) {
        Collector collector(
            *cull.getModelViewMatrix() * osg::Matrixd::inverse(frame.eye_from_world), frame);
        node.traverse(collector);
    }
    drawable->setDataVariance(any_dynamic(frame.graphs) ? osg::Object::DYNAMIC
                                                        : osg::Object::STATIC);
    cull.addDrawable(drawable.get(), cull.getModelViewMatrix());
    drawable->leaf = cull.getCurrentStateGraph()->_leaves.back().get();
    cull.popStateSet();
}

void OsgCulling::releaseGLObjects(osg::State* state) const
{
    views_->release(state);
    osg::NodeCallback::releaseGLObjects(state);
}

} // namespace occlude
