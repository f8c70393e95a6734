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
// Deviations  The papers name no criterion for a rebuild: here a subtree is rebuilt when the links
//             changed in it exceed a share of its objects. The tree is handed out as an ordinary
//             Hierarchy, so that every algorithm runs on it. It is laid out again when more than
//             one object in 64 was relinked; until then an object is drawn with its former node.
//             Boxes are tight in every frame, because drawing needs tight boxes; only the box to be
//             tested can be the cell of a restless node (quiet_frames). A large object of one item
//             is complex too: it has a local tree of one node, tested wherever the object is
//             linked.
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
    /// An object of one item gets a node of its own from this many triangles on; with less it is
    /// drawn with the scene node that it is linked to. Objects of several items are always complex.
    uint32_t complex_triangles = 256;
    /// A scene node of at most this many objects is not split further.
    uint32_t leaf_objects = 1;
    /// Nodes of either level with at most this many triangles become virtual leaves; 0: none do.
    uint32_t leaf_triangles = 1024;
    /// Every this many updates, the subtree of the scene tree that needs it most is rebuilt: with
    /// the next layout, or when nothing moves.
    uint32_t rebuild_period = 4;
    /// A subtree needs it when the links changed in it since it was built are more than this share
    /// of its objects.
    float rebuild_share = 0.5f;
    /// A scene node in which something moved is tested as its whole cell, and as the box around its
    /// contents again after this many updates without motion. 0: always the box around its
    /// contents.
    uint32_t quiet_frames = 0;
};

class TwoLevelTree {
public:
    /// An object of this tree; used again after remove().
    using Slot = uint32_t;

    explicit TwoLevelTree(const TwoLevelOptions& options = {});
    TwoLevelTree(TwoLevelTree&&) noexcept;
    /// hierarchy() stays where it is and takes the other one's contents, so that cullers go on.
    TwoLevelTree& operator=(TwoLevelTree&&) noexcept;
    ~TwoLevelTree();

    /// Adds an object; it is linked by the next update(). O(items of it).
    Slot add(const TwoLevelObject& object);
    /// Says that the object has moved. Precondition for all: `slot` is in use.
    void move(Slot slot, const glm::mat4& world_from_object);
    void remove(Slot slot);

    /// Brings the hierarchy up to date: once per frame, before culling. `bounds_by_item` are the
    /// world bounds of all items now, indexed by ItemId; only those of objects that were added or
    /// moved since the last call have changed. Nothing moved: O(1).
    void update(std::span<const ItemBounds> bounds_by_item);

    /// What hierarchy().shapes() is from now on, whatever update() does.
    void set_shapes(const ItemShapes* shapes);

    /// The tree as of the last update(): of a scene node, the children are the parts of its cell
    /// and then its complex objects, the own items its simple objects. Lives as long as this does.
    const Hierarchy& hierarchy() const;

    /// How often update() has moved an object to another node, and rebuilt a subtree.
    uint64_t relink_count() const;
    uint64_t rebuild_count() const;

    /// The first broken rule as a sentence, or an empty string: links and counts agree, objects are
    /// inside their cells, keys are unique, test boxes bound their nodes. O(everything).
    std::string check() const;

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

/// The two-level tree of objects of one item each that stand still, for where nobody knows of
/// objects.
Hierarchy build_two_level(std::span<const ItemBounds> items, const TwoLevelOptions& options = {});

/// Names of the options; see core/option_text.h.
template <class Visit>
void visit_options(TwoLevelOptions& o, Visit&& visit)
{
    visit("complex_triangles", o.complex_triangles, {},
          "an object of one item gets a node of its own if it has at least this many triangles");
    visit("leaf_objects", o.leaf_objects, {1},
          "a scene node of at most this many objects is not split");
    visit("leaf_triangles", o.leaf_triangles, {},
          "nodes of at most this many triangles become leaves; 0: none");
    visit("rebuild_period", o.rebuild_period, {1}, "updates from one rebuilt subtree to the next");
    visit("rebuild_share", o.rebuild_share, {},
          "a subtree is rebuilt when more links changed in it than this share of its objects");
    visit("quiet_frames", o.quiet_frames, {},
          "updates without motion after which a node's box is tight again; 0: it always is");
}

} // namespace occlude
