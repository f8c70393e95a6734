// The one tree that every algorithm walks: a flat array of nodes over the items of a scene.
//
//   node 0 is the root                      children of a node are contiguous
//   parents come before their children      items of a subtree are contiguous:
//
//     items():  [ own items of N | subtree of child 0 | subtree of child 1 | ... ]
//               |                |                                           |
//               first_item       first_item + own_items                      first_item +
//                                                                            subtree_items
//
// Leaf-only trees (BVH, octree) and trees with items in inner nodes (BSP) are the same type. A node
// can also be marked a *virtual leaf*: algorithms treat it as a leaf, while its real descendants
// still give tighter bounds (ShaderX7 8.4, "Tighter bounding volumes").
#pragma once

#include <occlude/core/aabb.h>
#include <occlude/core/assert.h>
#include <occlude/core/ids.h>
#include <occlude/hierarchy/object_nodes.h>

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace occlude {

/// How an item takes part in culling. CullFrame applies this, the same way for every algorithm.
enum class ItemFlags : uint8_t {
    none = 0,
    never_cull = 1,    ///< always drawn, before everything else, unless its box is empty
    never_occlude = 2, ///< drawn after all tests: hides nothing
    translucent = 4,   ///< occludee only, drawn last, back to front
    alpha_tested = 8,  ///< alpha-tested: drawn with its test, and occludes the pixels that it
                       ///< covers
};
constexpr ItemFlags operator|(ItemFlags a, ItemFlags b)
{
    return static_cast<ItemFlags>(static_cast<uint8_t>(a) | static_cast<uint8_t>(b));
}
constexpr bool has_flag(ItemFlags flags, ItemFlags flag)
{
    return (static_cast<uint8_t>(flags) & static_cast<uint8_t>(flag)) != 0;
}
/// The flags of items whose drawing an algorithm does not decide.
inline constexpr ItemFlags kDrawnOutOfTurn =
    ItemFlags::never_cull | ItemFlags::never_occlude | ItemFlags::translucent;

/// Everything that a builder needs to know of one item.
struct ItemBounds {
    Aabb box; ///< world space
    uint32_t triangles = 0;
    ItemFlags flags = ItemFlags::none;
};

struct Node {
    Aabb box;           ///< around the items of the whole subtree; empty if all of them are
    NodeId parent;      ///< invalid for the root
    NodeId first_child; ///< invalid for a node without children
    uint32_t child_count = 0;
    uint32_t first_item = 0; ///< into Hierarchy::items()
    uint32_t own_items = 0;
    uint32_t subtree_items = 0;
    uint32_t subtree_triangles = 0; ///< clamped to the largest number that fits
    uint32_t leaf = 0;              ///< 1 for real and virtual leaves, below which nothing is
                                    ///< walked
};
static_assert(sizeof(Node) == 56);

class ItemShapes;

class Hierarchy {
public:
    Hierarchy() = default;
    Hierarchy(const Hierarchy&) = default;
    Hierarchy& operator=(const Hierarchy&) = default;
    /// Leaves `from` empty, with moved_from() true. Cullers keep a reference to their hierarchy, so
    /// move it before they are made.
    Hierarchy(Hierarchy&& from) noexcept { *this = std::move(from); }
    Hierarchy& operator=(Hierarchy&& from) noexcept;
    ~Hierarchy() = default;

    /// True after a move until another hierarchy is assigned.
    bool moved_from() const { return structure_version_ == kMovedFrom; }

    std::span<const Node> nodes() const { return nodes_; }
    const Node& node(NodeId id) const { return nodes_[id.value]; }
    bool empty() const { return nodes_.empty(); }
    NodeId root() const { return NodeId{0u}; }

    /// Item ids in tree order: the order of draws.
    std::span<const ItemId> items() const { return items_; }
    std::span<const ItemId> own_items(NodeId id) const
    {
        return items().subspan(node(id).first_item, node(id).own_items);
    }
    std::span<const ItemId> subtree_items(NodeId id) const
    {
        return items().subspan(node(id).first_item, node(id).subtree_items);
    }
    /// Bounds of the items, in tree order: item_bounds()[i] belongs to items()[i]. NaN boxes have
    /// become Aabb::everything().
    std::span<const ItemBounds> item_bounds() const { return item_bounds_; }

    /// The item at a position of items(), and its bounds. Precondition: `at` is less than the
    /// number of items.
    ItemId item(ItemPosition at) const
    {
        OCCLUDE_ASSERT(at.value < items_.size(), "the position belongs to another tree");
        return items_[at.value];
    }
    const ItemBounds& item_bounds(ItemPosition at) const
    {
        OCCLUDE_ASSERT(at.value < item_bounds_.size(), "the position belongs to another tree");
        return item_bounds_[at.value];
    }

    /// True if an item has one of the flags kDrawnOutOfTurn.
    struct FlaggedItem {
        ItemId item;
        ItemPosition position;

        auto operator<=>(const FlaggedItem&) const = default;
    };
    /// These items by ascending id. Usually there are none.
    std::span<const FlaggedItem> flagged_items() const { return flagged_; }
    bool has_flags() const { return !flagged_.empty(); }

    /// A leaf for the algorithms: a node without children, or a virtual leaf.
    bool is_leaf(NodeId id) const { return node(id).leaf != 0; }

    /// Marks as virtual leaf every node whose subtree has at most `triangles` triangles and whose
    /// parent has more. A node without children is always a leaf; 0 makes only those leaves. A node
    /// that is unbounded, or has a child with an empty box, is never a virtual leaf, because it
    /// would draw items that its children keep apart. Takes a new structure version. O(nodes).
    void set_virtual_leaves(uint32_t triangles);

    /// Takes new boxes, triangle counts and flags of all items, indexed by ItemId, and refits all
    /// nodes bottom-up. Keeps the structure and the virtual leaves. An item with an empty box is
    /// never drawn, so that objects can vanish, and their ids can be reused, without a new
    /// structure. An item beyond the end of `bounds_by_item` becomes unbounded and keeps its other
    /// values (this is a caller's bug). O(items + nodes).
    void refit(std::span<const ItemBounds> bounds_by_item);

    /// The same if only the items in `moved` have changed. Each must be in the hierarchy; naming
    /// one twice is harmless. Touches these items and those of their ancestors that change, with
    /// the results of a full refit bit for bit. An item costs more than in a full refit, so that it
    /// pays up to about a tenth of the items (docs/scale.md). The first call after a change of
    /// structure makes an index of 8 bytes per item, O(items). The rest is O(moved * depth + nodes
    /// / 64). Adds the nodes whose box or sum has changed to `changed`, children before their
    /// parents.
    void refit(std::span<const ItemId> moved, std::span<const ItemBounds> bounds_by_item,
               std::vector<NodeId>* changed = nullptr);

    /// The memory of nodes, items, bounds and the data of partial refits, in bytes. Counts used
    /// memory, without the reserve of vectors.
    size_t memory_bytes() const;

    /// Tighter bounds of some items (item_shapes.h), for the cullers that use them; null: none.
    const ItemShapes* shapes() const { return shapes_; }
    /// `shapes` must keep their address and match the boxes while cullers walk the tree. They
    /// survive a refit, but a new tree has none.
    void set_shapes(const ItemShapes* shapes) { shapes_ = shapes; }

    /// What the builder knows about the objects of nodes. Empty if it knows none, and after
    /// refit(), because the caller does not say how the objects moved.
    const ObjectNodes& object_nodes() const { return object_nodes_; }
    /// Precondition: one entry per node in `object`, `box` and `key`. Node ids keep their meaning.
    void set_object_nodes(ObjectNodes nodes);
    /// Takes it out, to be changed and set again.
    ObjectNodes take_object_nodes() { return std::exchange(object_nodes_, {}); }

    /// Changes whenever node ids or leaves lose their meaning. Two structures of a process never
    /// share a version, but copies do. Cullers forget their state when it changes.
    uint64_t structure_version() const { return structure_version_; }

    /// Assembles a hierarchy from the shape that a builder found. For each node, the builder sets
    /// first_child, child_count, first_item and own_items, laid out as in the picture above. It
    /// gives the item ids in tree order (each at most once) and their bounds in the same order.
    /// Everything else in a node (parent, box, sums, leaf) is derived here and need not be set. No
    /// nodes and no items make an empty hierarchy. Builds with assertions check the layout. O(items
    /// + nodes).
    static Hierarchy from_arrays(std::vector<Node> nodes, std::vector<ItemId> items,
                                 std::vector<ItemBounds> item_bounds);
    /// The same for nodes whose fields are all set, over boxes none of which is NaN.
    static Hierarchy from_finished_arrays(std::vector<Node> nodes, std::vector<ItemId> items,
                                          std::vector<ItemBounds> item_bounds);

private:
    static constexpr uint64_t kMovedFrom = ~uint64_t{0};

    /// An index of items, for partial refits.
    struct PositionIndex {
        std::vector<ItemPosition> of_item; ///< by ItemId; invalid for an item that is not here
        std::vector<NodeId> owner_of;      ///< by position: the node whose own items include it
        std::vector<uint64_t> marked;      ///< a bit per node, all clear between calls
        uint64_t structure_version = 0;    ///< the structure that it was made for; 0: none
    };

    void refit_nodes();
    void collect_flagged();
    void index_positions();
    bool take_bounds(ItemPosition at, std::span<const ItemBounds> bounds_by_item);

    std::vector<Node> nodes_;
    std::vector<ItemId> items_;
    std::vector<ItemBounds> item_bounds_;
    std::vector<FlaggedItem> flagged_;
    ObjectNodes object_nodes_;
    PositionIndex positions_;
    const ItemShapes* shapes_ = nullptr;
    uint64_t structure_version_ = 0;
};

/// The first broken rule of the picture above as a sentence, or an empty string.
/// O(nodes + items log items).
std::string validate(const Hierarchy& hierarchy);

/// The expected cost of a random ray through the tree (surface area heuristic): the sum over nodes
/// of area(node) / area(scene) * (1 if it has children, + its own items). Virtual leaves count as
/// inner nodes. Empty and unbounded boxes are left out: the scene is the box around the bounded
/// items. If its area is 0, every node counts fully. O(items + nodes).
double sah_cost(const Hierarchy& hierarchy);

} // namespace occlude
