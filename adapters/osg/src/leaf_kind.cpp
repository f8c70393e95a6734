#include "leaf_kind.h"

#include <osg/ColorMask>
#include <osg/Depth>
#include <osg/GLDefines>
#include <osg/Geometry>
#include <osg/PolygonMode>

namespace occlude {

namespace {

bool draws_triangles(GLenum mode)
{
    switch (mode) {
    case GL_TRIANGLES:
    case GL_TRIANGLE_STRIP:
    case GL_TRIANGLE_FAN:
    case GL_QUADS:
    case GL_QUAD_STRIP:
    case GL_POLYGON:
        return true;
    default:
        return false; // lines and points are wider than their box
    }
}

LeafKind kind_of_depth(const osg::Depth& depth)
{
    const bool nearest_wins =
        depth.getFunction() == osg::Depth::LESS || depth.getFunction() == osg::Depth::LEQUAL;
    if (!nearest_wins || !depth.getWriteMask()) {
        return LeafKind::ordered;
    }
    return depth.getZNear() == 0.0 && depth.getZFar() == 1.0 ? LeafKind::testable
                                                             : LeafKind::opaque;
}

LeafKind kind_of_mask(const osg::ColorMask& mask)
{
    const bool all =
        mask.getRedMask() && mask.getGreenMask() && mask.getBlueMask() && mask.getAlphaMask();
    return all ? LeafKind::testable : LeafKind::ordered;
}

LeafKind kind_of_mode(const osg::PolygonMode& mode)
{
    const bool fills = mode.getMode(osg::PolygonMode::FRONT) == osg::PolygonMode::FILL &&
                       mode.getMode(osg::PolygonMode::BACK) == osg::PolygonMode::FILL;
    return fills ? LeafKind::testable : LeafKind::opaque;
}

} // namespace

LeafKind kind_of(const osg::Drawable& drawable)
{
    const osg::Geometry* geometry = drawable.asGeometry();
    if (geometry == nullptr || drawable.getDrawCallback() != nullptr) {
        return LeafKind::ordered; // draws what it likes, with state of its own
    }
    if (!drawable.isCullingActive() || !drawable.getBoundingBox().valid()) {
        return LeafKind::opaque;
    }
    for (unsigned int i = 0; i < geometry->getNumPrimitiveSets(); ++i) {
        if (!draws_triangles(geometry->getPrimitiveSet(i)->getMode())) {
            return LeafKind::opaque;
        }
    }
    return LeafKind::testable;
}

void StateKinds::begin_frame(const osg::Viewport& viewport)
{
    viewport_ = &viewport;
    levels_.clear();
}

LeafKind StateKinds::kind_of(const osgUtil::StateGraph& graph)
{
    return kind_of(level_of(graph));
}

const StateKinds::Level& StateKinds::level_of(const osgUtil::StateGraph& graph)
{
    const auto depth = static_cast<size_t>(graph._depth);
    if (depth < levels_.size() && levels_[depth].graph == &graph) {
        return levels_[depth];
    }
    Level level;
    level.modes[depth_test].on = true; // as osg::State begins
    if (graph._parent != nullptr) {
        level = level_of(*graph._parent);
    }
    level.graph = &graph;
    if (graph.getStateSet() != nullptr) {
        apply(*graph.getStateSet(), level);
    }
    levels_.resize(depth); // what was below another graph is of no use
    levels_.push_back(level);
    return levels_.back();
}

StateKinds::Mode StateKinds::tracked_mode(GLenum mode)
{
    switch (mode) {
    case GL_BLEND:
        return blend;
    case GL_STENCIL_TEST:
        return stencil;
    case GL_COLOR_LOGIC_OP:
        return logic_op;
    case GL_DEPTH_TEST:
        return depth_test;
    case GL_POLYGON_OFFSET_FILL:
        return offset;
    case GL_DEPTH_CLAMP:
        return clamp;
    case GL_POLYGON_SMOOTH:
        return smooth;
    default:
        return mode_count;
    }
}

StateKinds::Setting StateKinds::tracked_setting(const osg::StateAttribute& attribute) const
{
    using osg::StateAttribute;
    switch (attribute.getType()) {
    case StateAttribute::DEPTH:
        return {depth, kind_of_depth(static_cast<const osg::Depth&>(attribute))};
    case StateAttribute::COLORMASK:
        return {color_mask, kind_of_mask(static_cast<const osg::ColorMask&>(attribute))};
    case StateAttribute::POLYGONMODE:
        return {polygon_mode, kind_of_mode(static_cast<const osg::PolygonMode&>(attribute))};
    case StateAttribute::VIEWPORT:
        return {viewport,
                attribute.compare(*viewport_) == 0 ? LeafKind::testable : LeafKind::opaque};
    default:
        return {attribute_count, LeafKind::testable};
    }
}

// The rules of osg::State: a parent that overrides wins, unless the child is protected.
void StateKinds::apply(const osg::StateSet& state, Level& level) const
{
    using osg::StateAttribute;
    const auto wins = [](bool overridden, unsigned int value) {
        return !overridden || (value & StateAttribute::PROTECTED) != 0;
    };
    const auto overrides = [](unsigned int value) {
        return (value & StateAttribute::OVERRIDE) != 0;
    };
    for (const auto& [gl_mode, value] : state.getModeList()) {
        const Mode mode = tracked_mode(gl_mode);
        if (mode != mode_count && wins(level.modes[mode].overrides, value)) {
            level.modes[mode] = {(value & StateAttribute::ON) != 0, overrides(value)};
        }
    }
    for (const auto& [type, entry] : state.getAttributeList()) {
        const auto& [attribute, value] = entry;
        const Setting setting = tracked_setting(*attribute);
        if (setting.attribute == attribute_count) {
            continue;
        }
        auto& [kind, overridden] = level.attributes[setting.attribute];
        if (wins(overridden, value)) {
            kind = setting.kind;
            overridden = overrides(value);
        }
    }
}

LeafKind StateKinds::kind_of(const Level& level)
{
    if (level.modes[blend].on || level.modes[stencil].on || level.modes[logic_op].on ||
        !level.modes[depth_test].on) {
        return LeafKind::ordered;
    }
    LeafKind kind = LeafKind::testable;
    if (level.modes[offset].on || level.modes[clamp].on || level.modes[smooth].on) {
        kind = LeafKind::opaque;
    }
    for (const KindOfAttribute& attribute : level.attributes) {
        kind = stricter(kind, attribute.kind);
    }
    return kind;
}

} // namespace occlude
