#include "prop_items.h"

#include <occlude/core/rng.h>

#include <cmath>
#include <limits>

namespace occlude {

namespace {

constexpr uint64_t kForgetAfterFrames = 1000; // an item that is missing no longer has an id
constexpr size_t kFewItems = 64;

} // namespace

Aabb box_of(const Bounds& bounds, double slack)
{
    Aabb box;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = bounds[static_cast<size_t>(2 * axis)] - slack;
        const double high = bounds[static_cast<size_t>(2 * axis + 1)] + slack;
        if (!(low <= high)) { // empty, or not a number
            return Aabb::everything();
        }
        const float infinity = std::numeric_limits<float>::infinity();
        box.min[axis] = std::nextafter(static_cast<float>(low), -infinity);
        box.max[axis] = std::nextafter(static_cast<float>(high), infinity);
    }
    return box;
}

size_t PropItems::Hash::operator()(const Key& key) const
{
    return hash64(reinterpret_cast<uintptr_t>(key.prop), key.block);
}

void PropItems::begin_frame()
{
    ++frame_;
    tree_.begin_frame();
    if (items_.size() > 2 * sequence_.size() + kFewItems && frame_ % kForgetAfterFrames == 0) {
        forget_missing();
    }
    present_.clear();
    next_ = 0;
}

ItemId PropItems::find(const vtkProp* prop, uint32_t block, const Bounds& bounds, double slack,
                       uint32_t triangles)
{
    const uint32_t id = look_up({prop, block});
    Item& item = items_[id];
    const ItemId item_id{id};
    if (item.last_seen == 0 || item.bounds != bounds || tree_.box(item_id).is_empty()) {
        item.bounds = bounds;
        tree_.set_box(item_id, box_of(bounds, slack));
    }
    item.last_seen = frame_;
    tree_.set_triangles(item_id, triangles);
    tree_.see(item_id);
    present_.push_back(id);
    return item_id;
}

uint32_t PropItems::look_up(const Key& key)
{
    // In the order of the last frame, over a few that are missing now.
    constexpr size_t kAhead = 4;
    for (size_t i = next_; i < sequence_.size() && i < next_ + kAhead; ++i) {
        if (items_[sequence_[i]].key == key) {
            next_ = i + 1;
            return sequence_[i];
        }
    }
    const auto [at, is_new] = ids_.try_emplace(key, static_cast<uint32_t>(items_.size()));
    if (is_new) {
        items_.push_back({key, {}, 0});
        tree_.add(Aabb::empty(), 0);
    }
    return at->second;
}

void PropItems::end_frame()
{
    sequence_.swap(present_);
    tree_.update();
}

// Takes ids away from items that were missing for long, and gives the others new ones.
void PropItems::forget_missing()
{
    std::vector<uint32_t> new_ids(items_.size(), ItemTree::kGone);
    uint32_t kept = 0;
    for (uint32_t id = 0; id < items_.size(); ++id) {
        if (items_[id].last_seen + kForgetAfterFrames >= frame_) {
            items_[kept] = items_[id];
            new_ids[id] = kept++;
        } else {
            ids_.erase(items_[id].key);
        }
    }
    items_.resize(kept);
    for (uint32_t id = 0; id < kept; ++id) {
        ids_[items_[id].key] = id;
    }
    for (uint32_t& id : sequence_) { // of the last frame: all of them are kept
        id = new_ids[id];
    }
    tree_.renumber(new_ids);
}

} // namespace occlude
