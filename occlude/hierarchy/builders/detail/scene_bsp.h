// The upper level of a two-level tree: a BSP over the objects of a scene, each linked to the
// smallest cell around it. Internal; two_level.h says what it implements.
#pragma once

#include <occlude/hierarchy/builders/two_level.h>

#include <map>
#include <string>
#include <vector>

namespace occlude::detail {

/// Numbers that nodes keep while other nodes come and go. Runs that were given back are reused.
class KeyPool {
public:
    /// The first of `count` consecutive keys.
    uint32_t take(uint32_t count);
    void give_back(uint32_t first, uint32_t count);
    uint32_t end() const { return end_; }

private:
    uint32_t end_ = 0;
    std::map<uint32_t, std::vector<uint32_t>> free_; ///< first keys of free runs, by length
};

class SceneBsp {
public:
    using Slot = TwoLevelTree::Slot;
    static constexpr uint32_t kNone = 0xffffffffu;
    static constexpr uint32_t kRoot = 0;

    struct Object {
        ItemId first_item;
        uint32_t item_count = 0; ///< 0: the slot is free
        glm::mat4 world_from_object{1.0f};
        LocalTree tree;
        Aabb box;               ///< world space, as linked
        uint32_t first_key = 0; ///< of its local nodes
        uint32_t cell = kNone;  ///< the cell that it is linked to
        uint32_t previous = kNone;
        uint32_t next = kNone; ///< next object in the same cell
        bool complex = true;
        bool moved = false; ///< its slot is in moved()
    };
    struct Cell {
        Aabb box;
        uint32_t parent = kNone;
        uint32_t first_child = kNone; ///< of two adjacent ones
        uint32_t depth = 0;
        uint32_t first_object = kNone;
        uint32_t subtree_objects = 0;
        uint32_t changes = 0; ///< links changed in the subtree since it was built
        uint32_t key = 0;
        uint64_t restless_at = 0; ///< the last update in which something in it moved
    };

    explicit SceneBsp(const TwoLevelOptions& options);

    Slot add(const TwoLevelObject& object);
    void move(Slot slot, const glm::mat4& world_from_object);
    void remove(Slot slot);

    /// Starts an update: links objects that were added or moved to the cells that now hold them,
    /// and rebuilds a subtree if one is due. Returns true if anything has changed.
    bool update(std::span<const ItemBounds> bounds_by_item);
    /// True if the hierarchy needs a new layout: the nodes have changed, or more than one object in
    /// kObjectsPerStaleLink is drawn with a cell to which it is no longer linked.
    bool needs_layout() const;
    void finish_layout();
    void finish_update() { moved_.clear(); }

    std::span<const Object> objects() const { return objects_; }
    std::span<const Slot> moved() const { return moved_; }
    const Cell& cell(uint32_t index) const { return cells_[index]; }
    uint32_t key_end() const { return keys_.end(); }
    /// How many times update() was called.
    uint64_t updates() const { return updates_; }
    uint64_t relinks() const { return relinks_; }
    uint64_t rebuilds() const { return rebuilds_; }

    /// The first broken rule of the links as a sentence, or an empty string. O(objects * depth).
    std::string check() const;

private:
    struct Plane {
        int axis = 0;
        float at = 0.0f;
    };

    bool in_use(Slot slot) const { return slot < objects_.size() && objects_[slot].item_count > 0; }
    void mark_moved(Slot slot);
    void place(Object& object, std::span<const ItemBounds> bounds);
    void relink(Slot slot);
    uint32_t home_of(const Aabb& box, uint32_t start) const;
    void link(Slot slot, uint32_t cell);
    void unlink(Slot slot);
    void count_change(uint32_t from, uint32_t to);
    void mark_restless(uint32_t cell);

    void reconstruct();
    bool needs_rebuild(const Cell& cell) const;
    void rebuild(uint32_t cell);
    void build_cells(uint32_t cell, std::vector<Slot> slots);
    bool choose_plane(std::span<const Slot> slots, Plane& best) const;
    uint32_t take_pair(uint32_t parent);
    void clear_subtree(uint32_t cell, std::vector<Slot>& slots);

    TwoLevelOptions options_;
    std::vector<Object> objects_;
    std::vector<Slot> free_slots_;
    std::vector<Slot> moved_;
    std::vector<Cell> cells_; ///< the root, a gap, and pairs of siblings
    std::vector<uint32_t> free_pairs_;
    std::vector<uint32_t> walk_; ///< scratch
    KeyPool keys_;
    uint64_t updates_ = 0;
    uint64_t reconstruct_at_ = 1; ///< the first update that looks for a subtree to rebuild
    uint64_t relinks_ = 0;
    uint64_t rebuilds_ = 0;
    bool layout_stale_ = true;
    size_t stale_links_ = 0; ///< relinks since the last layout
};

} // namespace occlude::detail
