// The boxes of an engine's things by ItemId, and a hierarchy over them that follows as they move,
// come and go.
//
// A thing that is missing may be outside of the frustum, where its box costs nothing, or gone:
// after a while its box becomes empty. A hierarchy is built when enough items are new, or new ones
// have waited for a while, or what has moved has made it bad; else it is refitted. Until then new
// items are not in it, and are drawn before all tests.
#pragma once

#include <occlude/core/ids.h>
#include <occlude/hierarchy/hierarchy.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace occlude {

class ItemTree {
public:
    /// Forgets which items moved in the last frame.
    void begin_frame();

    ItemId add(const Aabb& box, uint32_t triangles);
    /// Another box. The item counts as moved.
    void set_box(ItemId item, const Aabb& box);
    void set_triangles(ItemId item, uint32_t triangles)
    {
        bounds_[item.value].triangles = triangles;
    }
    /// The engine has the item in this frame.
    void see(ItemId item) { last_seen_[item.value] = frame_; }
    /// The box; empty also if the item was missing for a while.
    const Aabb& box(ItemId item) const { return bounds_[item.value].box; }

    /// Gives item `i` the id `new_ids[i]`, which are ascending, or takes its id away where that is
    /// kGone. The next update() builds.
    void renumber(std::span<const uint32_t> new_ids);
    static constexpr uint32_t kGone = 0xffffffffu;

    /// Once per frame, after all changes: refits, or builds.
    void update();

    /// False for items that the hierarchy does not know yet: they cannot be culled.
    bool in_hierarchy(ItemId item) const { return item.value < built_items_; }

    const Hierarchy& hierarchy() const { return hierarchy_; }
    size_t size() const { return bounds_.size(); }
    size_t moved() const { return moved_.size(); }
    uint64_t rebuilds() const { return rebuilds_; }

private:
    void empty_missing();
    bool needs_rebuild();

    Hierarchy hierarchy_;
    std::vector<ItemBounds> bounds_;  ///< by ItemId
    std::vector<uint64_t> last_seen_; ///< by ItemId; 0: never
    std::vector<ItemId> moved_;
    uint64_t frame_ = 0;
    uint64_t rebuilds_ = 0;
    uint32_t built_items_ = 0;    ///< ids below are in the hierarchy
    uint32_t frames_pending_ = 0; ///< since the first item that waits for the next hierarchy
    uint32_t next_missing_ = 0;
    double built_cost_ = 0.0;
};

} // namespace occlude
