#include "leaf_kind.h"

#include <osg/BlendFunc>
#include <osg/ColorMask>
#include <osg/Depth>
#include <osg/Geometry>
#include <osg/PolygonMode>
#include <osg/PolygonOffset>

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

namespace occlude {
namespace {

using osg::StateAttribute;

// The kind of leaves whose states are these, from the root down.
LeafKind kind_below(const std::vector<osg::ref_ptr<osg::StateSet>>& states)
{
    const osg::ref_ptr<osg::Viewport> viewport = new osg::Viewport(0, 0, 100, 100);
    const osg::ref_ptr<osgUtil::StateGraph> root = new osgUtil::StateGraph;
    osgUtil::StateGraph* graph = root.get();
    for (const auto& state : states) {
        graph = graph->find_or_insert(state.get());
    }
    StateKinds kinds;
    kinds.begin_frame(*viewport);
    return kinds.kind_of(*graph);
}

osg::ref_ptr<osg::StateSet> state(const std::function<void(osg::StateSet&)>& set)
{
    osg::ref_ptr<osg::StateSet> made = new osg::StateSet;
    set(*made);
    return made;
}

TEST(LeafKind, EachStateHasItsKind)
{
    struct Case {
        std::string name;
        std::function<void(osg::StateSet&)> set;
        LeafKind kind;
    };
    const std::vector<Case> cases{
        {"nothing", [](osg::StateSet&) {}, LeafKind::testable},
        {"blending", [](auto& s) { s.setMode(GL_BLEND, StateAttribute::ON); }, LeafKind::ordered},
        {"stencil", [](auto& s) { s.setMode(GL_STENCIL_TEST, StateAttribute::ON); },
         LeafKind::ordered},
        {"no depth test", [](auto& s) { s.setMode(GL_DEPTH_TEST, StateAttribute::OFF); },
         LeafKind::ordered},
        {"LEQUAL", [](auto& s) { s.setAttribute(new osg::Depth(osg::Depth::LEQUAL)); },
         LeafKind::testable},
        {"ALWAYS", [](auto& s) { s.setAttribute(new osg::Depth(osg::Depth::ALWAYS)); },
         LeafKind::ordered},
        {"no depth writes",
         [](auto& s) { s.setAttribute(new osg::Depth(osg::Depth::LESS, 0.0, 1.0, false)); },
         LeafKind::ordered},
        {"a depth range",
         [](auto& s) { s.setAttribute(new osg::Depth(osg::Depth::LESS, 0.0, 0.5)); },
         LeafKind::opaque},
        {"a colour mask",
         [](auto& s) { s.setAttribute(new osg::ColorMask(false, false, false, false)); },
         LeafKind::ordered},
        {"polygon offset",
         [](auto& s) { s.setAttributeAndModes(new osg::PolygonOffset(-1.0f, -1.0f)); },
         LeafKind::opaque},
        {"lines",
         [](auto& s) {
             s.setAttribute(
                 new osg::PolygonMode(osg::PolygonMode::FRONT_AND_BACK, osg::PolygonMode::LINE));
         },
         LeafKind::opaque},
        {"the view's viewport", [](auto& s) { s.setAttribute(new osg::Viewport(0, 0, 100, 100)); },
         LeafKind::testable},
        {"another viewport", [](auto& s) { s.setAttribute(new osg::Viewport(0, 0, 100, 50)); },
         LeafKind::opaque},
    };
    for (const Case& one : cases) {
        EXPECT_EQ(kind_below({state(one.set)}), one.kind) << one.name;
        EXPECT_EQ(kind_below({state(one.set), new osg::StateSet}), one.kind)
            << one.name << ", inherited";
    }
}

TEST(LeafKind, OverridesAndProtectionsAreThoseOfTheEngine)
{
    const auto blend = [](unsigned int value) {
        return state([=](osg::StateSet& s) { s.setMode(GL_BLEND, value); });
    };
    const unsigned int on = StateAttribute::ON;
    const unsigned int off = StateAttribute::OFF;
    const unsigned int override_ = StateAttribute::OVERRIDE;
    const unsigned int protected_ = StateAttribute::PROTECTED;
    EXPECT_EQ(kind_below({blend(on), blend(off)}), LeafKind::testable);
    EXPECT_EQ(kind_below({blend(on | override_), blend(off)}), LeafKind::ordered);
    EXPECT_EQ(kind_below({blend(on | override_), blend(off | protected_)}), LeafKind::testable);
    EXPECT_EQ(kind_below({blend(off | override_), blend(on)}), LeafKind::testable);
}

TEST(LeafKind, OnlyTrianglesInABoxCanBeTested)
{
    const osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    geometry->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLES, 0, 3));
    EXPECT_EQ(kind_of(*geometry), LeafKind::opaque) << "it has no box";
    const osg::ref_ptr<osg::Vec3Array> corners = new osg::Vec3Array(3);
    (*corners)[1].x() = (*corners)[2].y() = 1.0f;
    geometry->setVertexArray(corners.get());
    EXPECT_EQ(kind_of(*geometry), LeafKind::testable);
    geometry->addPrimitiveSet(new osg::DrawArrays(GL_LINES, 0, 2));
    EXPECT_EQ(kind_of(*geometry), LeafKind::opaque);
    geometry->removePrimitiveSet(1);
    geometry->setCullingActive(false);
    EXPECT_EQ(kind_of(*geometry), LeafKind::opaque);
    geometry->setDrawCallback(new osg::Drawable::DrawCallback);
    EXPECT_EQ(kind_of(*geometry), LeafKind::ordered);
    EXPECT_EQ(kind_of(*osg::ref_ptr(new osg::Drawable)), LeafKind::ordered);
}

} // namespace
} // namespace occlude
