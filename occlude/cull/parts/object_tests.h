// The common parts of the two methods of GPU Gems ch. 29: they collect the objects in the frustum
// near to far, choose the objects that are worth a test, and make the boxes of each test.
//
// An *object* is a leaf of the hierarchy, virtual leaves included. Items in inner nodes (of trees
// that have them) belong to no object and are drawn untested.
#pragma once

#include <occlude/cull/parts/cull_frame.h>
#include <occlude/cull/parts/tight_bounds.h>

#include <cstdint>
#include <span>
#include <vector>

namespace occlude {

/// Which objects are tested, and by which boxes. All others are drawn untested.
struct ObjectTestOptions {
    /// 29.6.2: objects nearer to the eye than this, in world units, are not tested. A box that the
    /// near plane may touch is never tested, whatever this is (rule R1).
    float skip_nearer_than = 0.0f;
    /// 29.6.1: objects with fewer triangles are not tested. By the chapter, a box costs as much as
    /// some 200 triangles.
    uint32_t skip_triangles_below = 0;
    /// 29.6.2: objects whose box covers more than this share of the screen are not tested ...
    float skip_larger_than = 1.0f;
    /// ... if the target has at least this many pixels.
    uint32_t high_resolution = 0;
    /// 29.5.1: how many levels below an object its sub-boxes are taken from. 0: one box.
    uint32_t sub_box_depth = 3;
    /// The area of the sub-boxes is at most this many times the area of the object's box.
    float sub_box_area = 1.4f;
    /// 29.6.4: the frustum is tested against the ball around a node's box first. The box is tested
    /// only if the ball intersects the frustum and the largest extent is more than this many times
    /// the second. 0: boxes alone. Errs toward more nodes: images do not change.
    float sphere_elongation = 0.0f;
};

/// The share of the screen that the box's rectangle covers: 0 for a box outside the screen, 1 if
/// part of the box is behind the eye or the box is not bounded.
float screen_share(const View& view, const Aabb& box);

class ObjectTests {
public:
    struct Object {
        float distance = 0.0f; ///< View::distance_key
        NodeId node;
        PlaneMask mask = Frustum::kAllPlanes;
    };

    explicit ObjectTests(const ObjectTestOptions& options)
        : options_(options)
    {
    }

    /// Visits the tree and returns the objects in the frustum, near to far; valid until the next
    /// call. Queues the items of inner nodes.
    std::span<const Object> collect_near_to_far(CullFrame& frame);

    /// False if one of the options says that the object is drawn untested.
    bool worth_testing(const CullFrame& frame, NodeId node) const;

    /// Adds one test of the object to the batch. Precondition: the near plane does not touch it
    /// (R1).
    void add_test(const CullFrame& frame, NodeId node, TestBatch& batch);

private:
    struct Open {
        NodeId node;
        PlaneMask mask;
    };

    bool in_frustum(CullFrame& frame, NodeId node, PlaneMask& mask) const;

    ObjectTestOptions options_;
    std::vector<Object> objects_;
    std::vector<Open> stack_;
    TightBounds tight_bounds_;
};

template <class Visit>
void visit_options(ObjectTestOptions& o, Visit&& visit)
{
    visit("skip_nearer_than", o.skip_nearer_than, {},
          "objects nearer than this, in world units, are not tested");
    visit("skip_triangles_below", o.skip_triangles_below, {},
          "objects with fewer triangles are not tested");
    visit("skip_larger_than", o.skip_larger_than, {},
          "objects that cover more than this share of the screen are not tested ...");
    visit("high_resolution", o.high_resolution, {},
          "... if the target has at least this many pixels");
    visit("sub_box_depth", o.sub_box_depth, {0, 32},
          "levels below an object that its sub-boxes come from; 0: one box");
    visit("sub_box_area", o.sub_box_area, {0.0f, 1000.0f},
          "largest area of the sub-boxes, in areas of the object's box");
    visit("sphere_elongation", o.sphere_elongation, {},
          "frustum tests by balls first, then by boxes longer than this; 0: by boxes alone");
}

} // namespace occlude
