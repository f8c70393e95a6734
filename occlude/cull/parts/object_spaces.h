// The boxes of a two-level tree as tests see them: in the space of their object where that is
// tighter than a box in the world. One place projects and inflates them (rule R2).
#pragma once

#include <occlude/core/view.h>
#include <occlude/hierarchy/hierarchy.h>
#include <occlude/screen/projection.h>

#include <vector>

namespace occlude {

/// A box to test, in the space of `world_from_box`, or of the world if that is null.
struct SpacedBox {
    Aabb box;
    const glm::mat4* world_from_box = nullptr;
};

class ObjectSpaces {
public:
    /// Forgets the spaces of the last frame. On a tree that is not two-level there are none.
    void start_frame(const Hierarchy& hierarchy);

    /// The box of a node as a test gets it: inflated, in the space of its object if that is turned
    /// and its map has an inverse. Valid while the tree is.
    SpacedBox test_box(const View& view, const Hierarchy& hierarchy, NodeId node);

    /// Where the node's box is on the screen, not inflated.
    ScreenBounds project(const View& view, const Hierarchy& hierarchy, NodeId node);

private:
    /// Made once a frame, when the first node of the object is looked at.
    struct Space {
        bool known = false;
        bool usable = false; ///< the map has an inverse
        View view;           ///< from the object's space
        Inflation inflation; ///< of boxes in it
    };
    struct Tested {
        Aabb box; ///< not inflated
        const glm::mat4* world_from_box = nullptr;
        const Space* space = nullptr; ///< null: the world
    };

    Tested tested(const View& view, const Hierarchy& hierarchy, NodeId node);
    const Space& space_of(const View& view, const Hierarchy& hierarchy, uint32_t object);

    std::vector<Space> spaces_; ///< by object
};

} // namespace occlude
