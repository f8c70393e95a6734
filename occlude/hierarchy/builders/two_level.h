// Two-level tree for scenes whose objects move: a scene BSP over objects, and below each complex
// object a local BSP over its parts, in the object's own space.
//
// Implements  V. Kovalcik, P. Tobola, "Fast Rendering of Complex Dynamic Scenes",
//             sections 3.1 and 3.2, and the shrinking of boxes of 3.4.
// Map         Figure 1, object partitioning     -> LocalTree, build_local_tree
//             scene partitioning                -> TwoLevelTree::build_scene, choose_plane
//             relinking of moved objects        -> TwoLevelTree::relink
//             lazy reconstruction               -> TwoLevelTree::reconstruct
//             shrinking of boxes                -> TwoLevelOptions::quiet_frames, scene_test_box
// Deviations  The papers name no criteria: a subtree is rebuilt when the links changed in it exceed
// a
//             share of its objects. The tree is handed out as an ordinary Hierarchy, so that every
//             algorithm runs on it, and laid out anew when more than one in 64 objects were
//             relinked: until then they are drawn where they were. Its boxes are tight in every
//             frame, because drawing needs them so. Only the boxes to be tested can be the cells of
//             a restless node (quiet_frames). A large object of one item is complex too: a local
//             tree of one node, tested by itself wherever the object is linked.
// Guarantees  The hierarchy is valid() and its boxes bound the items as update() was told, wherever
//             the objects are linked. Deterministic.
// Cost        update(): O(moved objects * depth) to relink and to refit, at most O(items + nodes);
//             several times that to lay out, O(m log m) for the one rebuilt subtree of m objects.
#pragma once

#include <occlude/hierarchy/hierarchy.h>

#include <map>
#include <span>
#include <vector>

namespace occlude {

/// The axis-aligned BSP tree over the parts of one object, in the space of the object.
struct LocalTree {
    static constexpr uint32_t kNone = 0xffffffffu;

    struct Node {
        Aabb box;                     ///< around the parts of the subtree
        uint32_t first_child = kNone; ///< of two adjacent ones; kNone for a leaf
        uint32_t part = kNone;        ///< the one part of a leaf
    };
    std::vector<Node> nodes; ///< the root first, parents before their children
};

/// A local tree over parts with these boxes: each node is cut by the plane that parts its boxes
/// best, so that the tree of parts cut by planes (split_triangles) finds those planes again.
/// Deterministic. Empty for no parts. O(n log^2 n).
LocalTree build_local_tree(std::span<const Aabb> part_boxes);

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
    /// contents again after this many updates without motion. 0: always as the latter.
    uint32_t quiet_frames = 0;
};

class TwoLevelTree {
public:
    /// An object of this tree; used again after remove().
    using Slot = uint32_t;

    explicit TwoLevelTree(const TwoLevelOptions& options = {});

    /// Adds an object; it is linked by the next update(). O(items of it).
    Slot add(const TwoLevelObject& object);
    /// Says that the object has moved. Precondition for all: `slot` is in use.
    void move(Slot slot, const glm::mat4& world_from_object);
    void remove(Slot slot);

    /// Brings the hierarchy up to date: once per frame, before culling. `bounds_by_item` are the
    /// world bounds of all items now, indexed by ItemId; only those of objects that were added or
    /// moved since the last call have changed. Nothing moved: O(1).
    void update(std::span<const ItemBounds> bounds_by_item);

    /// What hierarchy().shapes() is from now on.
    void set_shapes(const ItemShapes* shapes) { hierarchy_.set_shapes(shapes); }

    /// The tree as of the last update(): of a scene node, the children are the parts of its cell
    /// and then its complex objects, the own items its simple objects. Lives as long as this does.
    const Hierarchy& hierarchy() const { return hierarchy_; }

    /// How often update() has moved an object to another node, and rebuilt a subtree.
    uint64_t relink_count() const { return relinks_; }
    uint64_t rebuild_count() const { return rebuilds_; }

    /// The first broken rule as a sentence, or nothing: links and counts agree, objects are inside
    /// their cells, keys are unique, test boxes bound their nodes. For tests; O(everything).
    std::string check() const;

private:
    static constexpr uint32_t kNone = 0xffffffffu;
    static constexpr uint32_t kRoot = 0;

    struct Object {
        ItemId first_item;
        uint32_t item_count = 0; ///< 0: the slot is free
        glm::mat4 world_from_object{1.0f};
        LocalTree tree;
        Aabb box;               ///< world space, as linked
        uint32_t first_key = 0; ///< of its local nodes
        uint32_t node = kNone;  ///< the scene node that it is linked to
        uint32_t previous = kNone;
        uint32_t next = kNone;
        bool complex = true;
        bool moved = false; ///< is in moved_
    };
    struct SceneNode {
        Aabb cell;
        uint32_t parent = kNone;
        uint32_t first_child = kNone; ///< of two adjacent ones
        uint32_t depth = 0;
        uint32_t first_object = kNone;
        uint32_t own_objects = 0;
        uint32_t subtree_objects = 0;
        uint32_t changes = 0; ///< links changed in the subtree since it was built
        uint32_t key = 0;
        uint64_t restless_at = 0; ///< the last update in which something in it moved
    };
    struct Plane {
        int axis = 0;
        float at = 0.0f;
    };
    class KeyPool {
    public:
        uint32_t take(uint32_t count);
        void give_back(uint32_t first, uint32_t count);
        uint32_t end() const { return end_; }

    private:
        uint32_t end_ = 0;
        std::map<uint32_t, std::vector<uint32_t>> free_; ///< first keys of free runs, by length
    };

    void mark_moved(Slot slot);
    void place(Object& object, std::span<const ItemBounds> bounds);
    void relink(Slot slot);
    uint32_t home_of(const Aabb& box, uint32_t start) const;
    void link(Slot slot, uint32_t node);
    void unlink(Slot slot);
    void count_change(uint32_t from, uint32_t to);
    void mark_restless(uint32_t node);

    bool needs_layout() const;
    void reconstruct();
    bool needs_rebuild(const SceneNode& node) const;
    void rebuild(uint32_t node);
    void build_scene(uint32_t node, std::vector<Slot> slots);
    bool choose_plane(std::span<const Slot> slots, Plane& best) const;
    uint32_t take_pair(uint32_t parent);
    void clear_subtree(uint32_t node, std::vector<Slot>& slots);

    struct Layout;
    void lay_out(std::span<const ItemBounds> bounds);
    void emit_scene(Layout& layout, uint32_t node, uint32_t at) const;
    void emit_local(Layout& layout, const Object& object, Slot slot, uint32_t local,
                    uint32_t at) const;
    void refresh_two_level(TwoLevelNodes nodes);
    void refit(std::span<const ItemBounds> bounds);
    void refit_moved(std::span<const ItemBounds> bounds);
    bool oriented_as_before() const;
    Aabb test_box(const TwoLevelNodes& nodes, size_t node) const;
    Aabb scene_test_box(const SceneNode& node, const Aabb& tight, const Aabb& scene) const;

    TwoLevelOptions options_;
    std::vector<Object> objects_;
    std::vector<Slot> free_slots_;
    std::vector<Slot> moved_;
    std::vector<ItemId> moved_items_; ///< scratch
    std::vector<NodeId> changed_;     ///< scratch
    std::vector<SceneNode> scene_;    ///< the root, a gap, and pairs of siblings
    std::vector<uint32_t> free_pairs_;
    std::vector<uint32_t> walk_; ///< scratch
    KeyPool keys_;
    Hierarchy hierarchy_;
    std::vector<uint32_t> scene_of_;  ///< per hierarchy node: its scene node, or kNone ...
    std::vector<uint32_t> local_of_;  ///< ... or its local node
    std::vector<uint32_t> object_of_; ///< ... of this object
    uint64_t lineage_ = 0;
    uint64_t updates_ = 0;
    uint64_t reconstruct_at_ = 1; ///< the first update that looks for a subtree to rebuild
    uint64_t restless_until_ = 0; ///< the last update at which some test box may still change
    uint64_t relinks_ = 0;
    uint64_t rebuilds_ = 0;
    bool layout_stale_ = true;
    size_t stale_links_ = 0; ///< relinks since the tree was laid out
};

/// The two-level tree of objects of one item each that stand still, for where nobody knows of
/// objects.
Hierarchy build_two_level(std::span<const ItemBounds> items, const TwoLevelOptions& options = {});

/// Names of the options; see core/option_text.h.
template <class Visit>
void visit_options(TwoLevelOptions& o, Visit&& visit)
{
    visit("complex_triangles", o.complex_triangles,
          "an object of one item gets a node of its own from so many triangles on");
    visit("leaf_objects", o.leaf_objects, "a scene node of at most so many objects is not split");
    visit("leaf_triangles", o.leaf_triangles, "nodes of at most so many become leaves; 0: none");
    visit("rebuild_period", o.rebuild_period, "updates from one rebuilt subtree to the next");
    visit("rebuild_share", o.rebuild_share,
          "a subtree is rebuilt when more links changed in it than this share of its objects");
    visit("quiet_frames", o.quiet_frames,
          "updates without motion after which a node's box is tight again; 0: it always is");
}

} // namespace occlude
