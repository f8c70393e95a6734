// What may be done with a leaf: leave it out when it is hidden, draw it at any time, or keep its
// place in the order.
#pragma once

#include <osg/Drawable>
#include <osg/StateSet>
#include <osg/Viewport>
#include <osgUtil/StateGraph>

#include <cstdint>
#include <vector>

namespace occlude {

enum class LeafKind : uint8_t {
    testable, ///< opaque triangles inside of their box
    opaque,   ///< may come at any time among opaque leaves, but is always drawn
    ordered,  ///< what it shows depends on what was drawn before: it keeps its place
};

/// The larger of two is what holds for a leaf with both properties.
constexpr LeafKind stricter(LeafKind a, LeafKind b)
{
    return a < b ? b : a;
}

/// By its primitives and callbacks. About a microsecond per primitive set.
LeafKind kind_of(const osg::Drawable& drawable);

/// Finds the kinds of leaves by the states that they are drawn with.
class StateKinds {
public:
    /// Forgets everything: states may have changed between frames. `viewport` is the view's.
    void begin_frame(const osg::Viewport& viewport);

    /// The kind of the leaves of `graph` as far as their state decides. O(attributes of the graph)
    /// for graphs that come in the order of a traversal.
    LeafKind kind_of(const osgUtil::StateGraph& graph);

private:
    // Indices of what is tracked.
    enum Mode : uint8_t { blend, stencil, logic_op, depth_test, offset, clamp, smooth, mode_count };
    enum Attribute : uint8_t { depth, color_mask, polygon_mode, viewport, attribute_count };

    struct Value {
        bool on = false;
        bool overrides = false;
    };
    struct KindOfAttribute {
        LeafKind kind = LeafKind::testable;
        bool overrides = false;
    };
    struct Setting {
        Attribute attribute = attribute_count;
        LeafKind kind = LeafKind::testable;
    };
    // The state on the way from the root to a graph.
    struct Level {
        const osgUtil::StateGraph* graph = nullptr;
        Value modes[mode_count];
        KindOfAttribute attributes[attribute_count];
    };

    const Level& level_of(const osgUtil::StateGraph& graph);
    static Mode tracked_mode(GLenum mode); // mode_count: not tracked
    Setting tracked_setting(const osg::StateAttribute& attribute) const;
    void apply(const osg::StateSet& state, Level& level) const;
    static LeafKind kind_of(const Level& level);

    const osg::Viewport* viewport_ = nullptr;
    std::vector<Level> levels_; ///< by depth: the way to the last graph
};

} // namespace occlude
