// The boxes of a two-level tree as tests see them: in the space of their object if that is tighter
// than a box in the world. Only this class projects and inflates them (rule R2).
#pragma once

#include <occlude/core/view.h>
#include <occlude/hierarchy/hierarchy.h>
#include <occlude/screen/projection.h>

#include <vector>

namespace occlude {

/// A box to test, in the space of `world_from_box`; in the world if that is null.
struct SpacedBox {
    Aabb box;
    const glm::mat4* world_from_box = nullptr;
};

class ObjectSpaces {
public:
    /// Forgets the spaces of the last frame. A tree that is not two-level has none.
    void start_frame(const Hierarchy& hierarchy);

    /// The inflated box of a node, in the space of its object if that is rotated and its map has an
    /// inverse. Valid as long as the tree.
    SpacedBox test_box(const View& view, const Hierarchy& hierarchy, NodeId node);

    /// The node's box on the screen, not inflated.
    ScreenBounds project(const View& view, const Hierarchy& hierarchy, NodeId node);

private:
    /// The space of one object, computed when a frame first reaches one of its nodes.
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
