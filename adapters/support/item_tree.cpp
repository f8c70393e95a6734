#include "item_tree.h"

#include <occlude/hierarchy/builders/bvh_builder.h>

namespace occlude {

namespace {

// A hierarchy is built when one in this many items is new, or new ones have waited this long.
constexpr uint32_t kNewShare = 8;
constexpr uint32_t kMaxPendingFrames = 30;
constexpr uint32_t kFewItems = 64;

constexpr uint32_t kEmptyAfterFrames = 30; // an item that is missing no longer has a box
constexpr uint64_t kCostCheckFrames = 64;
constexpr double kWorstCost = 1.5;        // times that of the last build
constexpr uint32_t kMovedShareOfAll = 16; // if more have moved, all boxes are visited

} // namespace

void ItemTree::begin_frame()
{
    ++frame_;
    moved_.clear();
}

ItemId ItemTree::add(const Aabb& box, uint32_t triangles)
{
    bounds_.push_back({box, triangles, ItemFlags::none});
    last_seen_.push_back(0);
    return ItemId{static_cast<uint32_t>(bounds_.size() - 1)};
}

void ItemTree::set_box(ItemId item, const Aabb& box)
{
    bounds_[item.value].box = box;
    if (in_hierarchy(item)) {
        moved_.push_back(item);
    }
}

void ItemTree::renumber(std::span<const uint32_t> new_ids)
{
    size_t kept = 0;
    for (size_t id = 0; id < bounds_.size(); ++id) {
        if (new_ids[id] != kGone) {
            bounds_[kept] = bounds_[id];
            last_seen_[kept++] = last_seen_[id];
        }
    }
    bounds_.resize(kept);
    last_seen_.resize(kept);
    moved_.clear();
    built_items_ = 0;
}

void ItemTree::update()
{
    empty_missing();
    if (needs_rebuild()) {
        hierarchy_ = build_bvh(bounds_);
        built_items_ = static_cast<uint32_t>(bounds_.size());
        built_cost_ = sah_cost(hierarchy_);
        frames_pending_ = 0;
        ++rebuilds_;
    } else if (moved_.size() * kMovedShareOfAll > built_items_) {
        hierarchy_.refit(bounds_);
    } else if (!moved_.empty()) {
        hierarchy_.refit(moved_, bounds_);
    }
}

// Looks at some items in each frame.
void ItemTree::empty_missing()
{
    const auto count = static_cast<uint32_t>(bounds_.size());
    for (uint32_t i = 0; i < count / kEmptyAfterFrames + 1 && count > 0; ++i) {
        next_missing_ = next_missing_ + 1 < count ? next_missing_ + 1 : 0;
        const uint64_t seen = last_seen_[next_missing_];
        const bool missing = seen != 0 && seen + kEmptyAfterFrames < frame_;
        if (missing && !bounds_[next_missing_].box.is_empty()) {
            set_box(ItemId{next_missing_}, Aabb::empty());
        }
    }
}

bool ItemTree::needs_rebuild()
{
    const auto pending = static_cast<uint32_t>(bounds_.size()) - built_items_;
    frames_pending_ = pending > 0 ? frames_pending_ + 1 : 0;
    if (pending > built_items_ / kNewShare + kFewItems || frames_pending_ > kMaxPendingFrames ||
        (built_items_ == 0 && pending > 0)) {
        return true;
    }
    return !moved_.empty() && frame_ % kCostCheckFrames == 0 &&
           sah_cost(hierarchy_) > kWorstCost * built_cost_;
}

} // namespace occlude
