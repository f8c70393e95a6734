#include "leaf_items.h"

#include <occlude/core/rng.h>

#include <osg/Geometry>

#include <glm/gtc/matrix_transform.hpp>

#include <gtest/gtest.h>

#include <vector>

namespace occlude {
namespace {

osg::ref_ptr<osg::Geometry> unit_cube()
{
    osg::ref_ptr<osg::Geometry> cube = new osg::Geometry;
    const osg::ref_ptr<osg::Vec3Array> corners = new osg::Vec3Array;
    for (int i = 0; i < 8; ++i) {
        corners->push_back({i & 1 ? 1.0f : 0.0f, i & 2 ? 1.0f : 0.0f, i & 4 ? 1.0f : 0.0f});
    }
    cube->setVertexArray(corners.get());
    cube->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLES, 0, 6));
    return cube;
}

PlacedDrawable at(const osg::Geometry& drawable, double x)
{
    return {&drawable, glm::translate(glm::dmat4{1.0}, glm::dvec3{x, 0.0, 0.0})};
}

TEST(LeafItems, BoxesHoldEveryCornerUnderEveryPlacement)
{
    Rng rng(1);
    const osg::BoundingBox local(-1.0f, 0.5f, 2.0f, 3.0f, 0.75f, 90.0f);
    for (int i = 0; i < 1000; ++i) {
        const double far = rng.range(0.0f, 1e6f);
        const glm::dmat4 placement =
            glm::rotate(glm::translate(glm::dmat4{1.0}, glm::dvec3{far, -far, 0.3 * far}),
                        static_cast<double>(rng.range(0.0f, 6.3f)),
                        glm::dvec3{rng.range(0.1f, 1.0f), rng.range(-1.0f, 1.0f), 0.5});
        const Aabb box = world_box(local, placement);
        for (unsigned int corner = 0; corner < 8; ++corner) {
            const osg::Vec3 point = local.corner(corner);
            const glm::dvec4 image = placement * glm::dvec4{point.x(), point.y(), point.z(), 1.0};
            for (int axis = 0; axis < 3; ++axis) {
                ASSERT_LE(static_cast<double>(box.min[axis]), image[axis]);
                ASSERT_GE(static_cast<double>(box.max[axis]), image[axis]);
            }
        }
        const glm::dvec3 size = glm::dvec3{box.max} - glm::dvec3{box.min};
        ASSERT_LT(size.x, 100.0 + 1e-6 * far) << "tight, but for rounding";
    }
}

TEST(LeafItems, ProjectivePlacementsAndUnknownBoxesAreUnbounded)
{
    glm::dmat4 projective{1.0};
    projective[2][3] = 0.1;
    EXPECT_FALSE(world_box(osg::BoundingBox(0, 0, 0, 1, 1, 1), projective).is_bounded());
    EXPECT_FALSE(world_box(osg::BoundingBox(), glm::dmat4{1.0}).is_bounded());
}

TEST(LeafItems, KnowALeafAgainWhateverComesAndGoesBeforeIt)
{
    const osg::ref_ptr<osg::Geometry> shared = unit_cube();
    LeafItems items;
    std::vector<ItemId> first;
    std::vector<ItemId> second;
    items.update(std::vector{at(*shared, 0), at(*shared, 5), at(*shared, 9)}, first);
    EXPECT_TRUE(items.in_hierarchy(first[2]));
    // The first is gone, and the places are off by what another view's inverse rounds.
    items.update(std::vector{at(*shared, 5.0 + 1e-13), at(*shared, 9.0 - 1e-13)}, second);
    EXPECT_EQ(second[0], first[1]);
    EXPECT_EQ(second[1], first[2]);
    EXPECT_EQ(items.moved(), 0u);
    EXPECT_EQ(items.size(), 3u);
}

TEST(LeafItems, TakeALeafAtANewPlaceForTheMissingOneOfTheSameDrawable)
{
    const osg::ref_ptr<osg::Geometry> shared = unit_cube();
    LeafItems items;
    std::vector<ItemId> before;
    std::vector<ItemId> after;
    items.update(std::vector{at(*shared, 0), at(*shared, 5)}, before);
    items.update(std::vector{at(*shared, 0), at(*shared, 6)}, after);
    EXPECT_EQ(after, before);
    EXPECT_EQ(items.moved(), 1u);
    EXPECT_EQ(items.rebuilds(), 1u);
    for (size_t i = 0; i < items.hierarchy().items().size(); ++i) {
        if (items.hierarchy().items()[i] == after[1]) {
            EXPECT_TRUE(contains(items.hierarchy().item_bounds()[i].box,
                                 {{6.0f, 0.0f, 0.0f}, {7.0f, 1.0f, 1.0f}}));
        }
    }
}

TEST(LeafItems, FollowADrawableThatDeforms)
{
    const osg::ref_ptr<osg::Geometry> cube = unit_cube();
    LeafItems items;
    std::vector<ItemId> ids;
    items.update(std::vector{at(*cube, 0)}, ids);
    static_cast<osg::Vec3Array&>(*cube->getVertexArray())[5].x() = 4.0f;
    cube->dirtyBound();
    items.update(std::vector{at(*cube, 0)}, ids);
    EXPECT_EQ(items.moved(), 1u);
    EXPECT_GE(items.hierarchy().node(items.hierarchy().root()).box.max.x, 4.0f);
}

TEST(LeafItems, NewLeavesWaitForTheNextHierarchy)
{
    const osg::ref_ptr<osg::Geometry> shared = unit_cube();
    std::vector<PlacedDrawable> leaves;
    for (int i = 0; i < 1000; ++i) {
        leaves.push_back(at(*shared, i));
    }
    LeafItems items;
    std::vector<ItemId> ids;
    items.update(leaves, ids);
    leaves.push_back(at(*shared, 2000.0));
    items.update(leaves, ids);
    EXPECT_FALSE(items.in_hierarchy(ids.back()));
    for (int frame = 0; frame < 40; ++frame) {
        items.update(leaves, ids);
    }
    EXPECT_TRUE(items.in_hierarchy(ids.back()));
    EXPECT_EQ(items.rebuilds(), 2u);
}

TEST(LeafItems, WhatIsGoneLosesItsBoxAndGetsItBack)
{
    const osg::ref_ptr<osg::Geometry> shared = unit_cube();
    const std::vector<PlacedDrawable> both{at(*shared, 0), at(*shared, 50)};
    LeafItems items;
    std::vector<ItemId> ids;
    items.update(both, ids);
    for (int frame = 0; frame < 100; ++frame) {
        items.update(std::span(both).first(1), ids);
    }
    EXPECT_LT(items.hierarchy().node(items.hierarchy().root()).box.max.x, 2.0f);
    items.update(both, ids);
    EXPECT_GT(items.hierarchy().node(items.hierarchy().root()).box.max.x, 50.0f);
    EXPECT_EQ(items.size(), 2u);
}

} // namespace
} // namespace occlude
