// Two-level tree for scenes whose objects move: a scene BSP over objects, and below each complex
// object a local BSP over its parts, in the object's own space.
//
// Implements  V. Kovalcik, P. Tobola, "Fast Rendering of Complex Dynamic Scenes",
//             sections 3.1 and 3.2, and the shrinking of boxes of 3.4.
// Map         Figure 1, object partitioning     -> build_local_tree (local_tree.h)
//             scene partitioning                -> detail::SceneBsp::build_cells, choose_plane
//             relinking of moved objects        -> detail::SceneBsp::relink
//             lazy reconstruction               -> detail::SceneBsp::reconstruct
//             shrinking of boxes                -> TwoLevelOptions::quiet_frames,
//                                                  detail::TwoLevelLayout::cell_test_box
// Deviations  The papers name no criterion for a rebuild. Here a subtree is rebuilt when the number
//             of links changed in it exceeds a share of its objects. The tree is handed out as an
//             ordinary Hierarchy, so that every algorithm runs on it. It is laid out again when
//             more than one object in 64 was relinked; until then an object is drawn with its
//             former node. Boxes are tight in every frame, because drawing needs tight boxes; only
//             the box to be tested can be the cell of a restless node (quiet_frames). A large
//             object of one item is complex too: it has a local tree of one node, tested wherever
//             the object is linked.
// Guarantees  validate() finds nothing wrong with the hierarchy, and its boxes bound the items as
//             update() was told, wherever the objects are linked. Deterministic.
// Cost        update(): O(moved objects * depth) to relink and to refit, at most O(items + nodes);
//             several times that to lay out, O(m log m) for the one rebuilt subtree of m objects.
#pragma once

#include <occlude/hierarchy/builders/local_tree.h>
#include <occlude/hierarchy/hierarchy.h>

#include <memory>
#include <span>
#include <string>

namespace occlude {

/// One object: a run of items that move together.
struct TwoLevelObject {
    ItemId first_item;
    glm::mat4 world_from_object{1.0f};
    std::span<const Aabb> local_boxes; ///< of its items, in its own space; at least one
    const LocalTree* tree = nullptr;   ///< over its items; null: build_local_tree(local_boxes)
};

struct TwoLevelOptions {
    /// An object of one item with at least this many triangles gets a node of its own. With fewer,
    /// it is drawn with the scene node that it is linked to. Objects of several items always have a
    /// local tree.
    uint32_t complex_triangles = 256;
    /// A scene node of at most this many objects is not split further.
    uint32_t leaf_objects = 1;
    /// Nodes of either level with at most this many triangles become virtual leaves; 0: none do.
    uint32_t leaf_triangles = 1024;
    /// The number of updates between two rebuilds. Each rebuilds the subtree of the scene tree that
    /// needs it most, with the next layout or when nothing moves.
    uint32_t rebuild_period = 4;
    /// A subtree needs a rebuild when the number of links that changed in it since it was built
    /// exceeds this share of its objects.
    float rebuild_share = 0.5f;
    /// After motion in a scene node, the node is tested as its whole cell. After this many updates
    /// without motion, it is tested as the box around its contents again. 0: always the box around
    /// its contents.
    uint32_t quiet_frames = 0;
};

class TwoLevelTree {
public:
    /// An object of this tree. The slot is reused after remove().
    using Slot = uint32_t;

    explicit TwoLevelTree(const TwoLevelOptions& options = {});
    TwoLevelTree(TwoLevelTree&&) noexcept;
    /// hierarchy() stays at its address and takes over the other tree's contents, so that cullers
    /// go on.
    TwoLevelTree& operator=(TwoLevelTree&&) noexcept;
    ~TwoLevelTree();

    /// Adds an object, which the next update() links. O(its items).
    Slot add(const TwoLevelObject& object);
    /// Tells that the object has moved. Precondition here and below: `slot` is in use.
    void move(Slot slot, const glm::mat4& world_from_object);
    void remove(Slot slot);

    /// Brings the hierarchy up to date; call it once per frame, before culling. `bounds_by_item`
    /// are the current world bounds of all items, indexed by ItemId. Only bounds of objects that
    /// were added or moved since the last call may have changed. If nothing moved: O(1).
    void update(std::span<const ItemBounds> bounds_by_item);

    /// Sets hierarchy().shapes() from now on, across all updates.
    void set_shapes(const ItemShapes* shapes);

    /// The tree as of the last update(): of a scene node, the children are the parts of its cell
    /// and then its complex objects, the own items its simple objects. Lives as long as this does.
    const Hierarchy& hierarchy() const;

    /// How often update() has moved an object to another node, and how often it rebuilt a subtree.
    uint64_t relink_count() const;
    uint64_t rebuild_count() const;

    /// The first broken rule as a sentence, or an empty string: links and counts agree, objects are
    /// inside their cells, keys are unique, test boxes bound their nodes. O(everything).
    std::string check() const;

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

/// A two-level tree of static objects of one item each, for hosts without objects.
Hierarchy build_two_level(std::span<const ItemBounds> items, const TwoLevelOptions& options = {});

/// Names of the options; see core/option_text.h.
template <class Visit>
void visit_options(TwoLevelOptions& o, Visit&& visit)
{
    visit("complex_triangles", o.complex_triangles, {},
          "an object of one item gets a node of its own if it has at least this many triangles");
    visit("leaf_objects", o.leaf_objects, {1},
          "a scene node with at most this many objects is not split");
    visit("leaf_triangles", o.leaf_triangles, {},
          "nodes with at most this many triangles become virtual leaves; 0: none do");
    visit("rebuild_period", o.rebuild_period, {1}, "updates between two rebuilds of a subtree");
    visit("rebuild_share", o.rebuild_share, {},
          "a subtree is rebuilt when the links changed in it exceed this share of its objects");
    visit("quiet_frames", o.quiet_frames, {},
          "updates without motion after which a node is tested by its tight box; 0: always");
}

} // namespace occlude
