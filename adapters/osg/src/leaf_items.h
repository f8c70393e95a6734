// Which leaf is which from frame to frame, and the hierarchy over them.
//
// The engine makes new leaves in every frame. A leaf is recognised by its drawable and the
// place where the drawable stands: first by the order in which leaves came in the last frame, then
// by a hash of both. A leaf that is at no known place is taken for one of the last frame with the
// same drawable that is missing now: it has moved. Nothing depends on these guesses but speed: each
// leaf's box is that of the present frame.
#pragma once

#include "item_tree.h"

#include <occlude/core/ids.h>

#include <osg/BoundingBox>
#include <osg/Drawable>

#include <glm/mat4x4.hpp>

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace occlude {

/// A drawable, and where it stands.
struct PlacedDrawable {
    const osg::Drawable* drawable = nullptr;
    glm::dmat4 world_from_model{1.0};
};

/// A box around the image of `local` that is never smaller, also if the entries of the matrix are
/// off by `kPlaceTolerance` of the largest.
Aabb world_box(const osg::BoundingBox& local, const glm::dmat4& world_from_model);

class LeafItems {
public:
    /// Adds items that no frame has shown yet, so that the first hierarchy has them.
    void expect(std::span<const PlacedDrawable> placed);

    /// Finds the items of the leaves of this frame, writes one id per leaf, and brings the
    /// tree up to date: refits what has moved, empties what was missing for a while, and
    /// rebuilds it when enough is new. Ids keep their meaning until the next call.
    void update(std::span<const PlacedDrawable> leaves, std::vector<ItemId>& ids);

    /// False for items that the hierarchy does not know yet: they cannot be culled.
    bool in_hierarchy(ItemId item) const { return tree_.in_hierarchy(item); }

    const Hierarchy& hierarchy() const { return tree_.hierarchy(); }
    size_t size() const { return items_.size(); }
    size_t moved() const { return tree_.moved(); }
    uint64_t rebuilds() const { return tree_.rebuilds(); }

private:
    struct Item {
        PlacedDrawable placed;
        osg::BoundingBox local_box;
        uint64_t last_seen = 0;
        uint32_t place = 0; ///< in sequence_, if it was seen last frame
    };

    bool matches(const Item& item, const PlacedDrawable& leaf) const;
    uint32_t look_up(const PlacedDrawable& leaf) const;
    uint32_t add(const PlacedDrawable& leaf);
    void place(uint32_t id, const PlacedDrawable& leaf);
    void follow_box(uint32_t id);
    void match_moved(std::span<const PlacedDrawable> leaves, std::vector<ItemId>& ids);
    void forget_missing();

    ItemTree tree_;
    std::vector<Item> items_;                              ///< by ItemId
    std::unordered_multimap<uint64_t, uint32_t> by_place_; ///< from place_hash()
    std::vector<uint32_t> sequence_;                       ///< the ids of the last frame, in order
    std::vector<uint32_t> unmatched_;                      ///< leaves of this frame without an id
    uint64_t frame_ = 0;
};

} // namespace occlude
