#include "leaf_items.h"

#include <occlude/core/rng.h>

#include <osg/Geometry>

#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace occlude {

namespace {

constexpr uint32_t kNone = ItemTree::kGone;

// Each frame computes matrices from the inverse of its own view, so that rounding differs where the
// place is the same. This tolerance is far below the steps of the float boxes.
constexpr double kPlaceTolerance = 0x1p-36;

constexpr uint32_t kFewItems = 64;
constexpr uint32_t kForgetAfterFrames = 1000; // an item that is missing no longer has an id

double largest_entry(const glm::dmat4& m)
{
    double largest = 0.0;
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 3; ++row) {
            largest = std::max(largest, std::abs(m[column][row]));
        }
    }
    return largest;
}

bool same_place(const glm::dmat4& a, const glm::dmat4& b)
{
    double difference = 0.0;
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 4; ++row) {
            difference = std::max(difference, std::abs(a[column][row] - b[column][row]));
        }
    }
    return difference <= kPlaceTolerance * largest_entry(a);
}

// Two places that round apart only cost the place: the leaf is then taken for one that has moved.
uint64_t place_hash(const PlacedDrawable& placed)
{
    uint64_t hash = reinterpret_cast<uintptr_t>(placed.drawable);
    const glm::dmat4& m = placed.world_from_model;
    const double step = std::max(largest_entry(m) * 0x1p-20, 0x1p-60);
    const double grid = std::exp2(std::ceil(std::log2(step)));
    for (int axis = 0; axis < 3; ++axis) {
        // An offset that coordinates with few bits do not have: they would lie on the seams.
        const double cells = std::floor(m[3][axis] / grid + 0.381966011250105);
        hash = hash64(hash, static_cast<uint64_t>(static_cast<int64_t>(cells)));
    }
    return hash;
}

uint32_t triangles_of(const osg::Drawable& drawable)
{
    const osg::Geometry* geometry = drawable.asGeometry();
    uint64_t triangles = 0;
    for (unsigned int i = 0; geometry != nullptr && i < geometry->getNumPrimitiveSets(); ++i) {
        const osg::PrimitiveSet& set = *geometry->getPrimitiveSet(i);
        const uint64_t indices = set.getNumIndices();
        const bool strip = set.getMode() == GL_TRIANGLE_STRIP || set.getMode() == GL_TRIANGLE_FAN;
        const uint64_t instances = std::max(set.getNumInstances(), 1);
        triangles += instances * (strip                       ? indices
                                  : set.getMode() == GL_QUADS ? indices / 2
                                                              : indices / 3);
    }
    return static_cast<uint32_t>(std::clamp<uint64_t>(triangles, 1, 1u << 30));
}

float rounded_down(double value)
{
    return std::nextafter(static_cast<float>(value), -std::numeric_limits<float>::infinity());
}

float rounded_up(double value)
{
    return std::nextafter(static_cast<float>(value), std::numeric_limits<float>::infinity());
}

bool affine(const glm::dmat4& m)
{
    return m[0][3] == 0.0 && m[1][3] == 0.0 && m[2][3] == 0.0 && m[3][3] == 1.0;
}

} // namespace

Aabb world_box(const osg::BoundingBox& local, const glm::dmat4& world_from_model)
{
    if (!local.valid() || !affine(world_from_model)) {
        return Aabb::everything();
    }
    const glm::dvec3 low{local.xMin(), local.yMin(), local.zMin()};
    const glm::dvec3 high{local.xMax(), local.yMax(), local.zMax()};
    const glm::dvec3 center = 0.5 * (low + high);
    const glm::dvec3 half = high - center;
    const double reach = std::max({std::abs(low.x), std::abs(low.y), std::abs(low.z),
                                   std::abs(high.x), std::abs(high.y), std::abs(high.z), 1.0});
    const double slack = 4.0 * kPlaceTolerance * largest_entry(world_from_model) * reach;
    Aabb box;
    for (int axis = 0; axis < 3; ++axis) {
        const glm::dvec3 row{world_from_model[0][axis], world_from_model[1][axis],
                             world_from_model[2][axis]};
        const double middle =
            row.x * center.x + row.y * center.y + row.z * center.z + world_from_model[3][axis];
        const double extent =
            std::abs(row.x) * half.x + std::abs(row.y) * half.y + std::abs(row.z) * half.z + slack;
        box.min[axis] = rounded_down(middle - extent);
        box.max[axis] = rounded_up(middle + extent);
    }
    return box;
}

void LeafItems::expect(std::span<const PlacedDrawable> placed)
{
    for (const PlacedDrawable& one : placed) {
        if (look_up(one) == kNone) {
            add(one);
        }
    }
}

void LeafItems::update(std::span<const PlacedDrawable> leaves, std::vector<ItemId>& ids)
{
    ++frame_;
    tree_.begin_frame();
    unmatched_.clear();
    if (items_.size() > 2 * sequence_.size() + kFewItems && frame_ % kForgetAfterFrames == 0) {
        forget_missing();
    }
    ids.assign(leaves.size(), ItemId{});
    size_t next = 0;
    for (size_t i = 0; i < leaves.size(); ++i) {
        uint32_t id = next < sequence_.size() ? sequence_[next] : kNone;
        if (id == kNone || items_[id].last_seen == frame_ || !matches(items_[id], leaves[i])) {
            id = look_up(leaves[i]);
        }
        if (id == kNone) {
            unmatched_.push_back(static_cast<uint32_t>(i));
            continue;
        }
        // Go on after it, if it was there last time.
        next = items_[id].last_seen + 1 == frame_ ? items_[id].place + 1 : next;
        items_[id].last_seen = frame_;
        ids[i] = ItemId{id};
    }
    match_moved(leaves, ids);
    sequence_.resize(ids.size());
    for (size_t i = 0; i < ids.size(); ++i) {
        sequence_[i] = ids[i].value;
        items_[ids[i].value].place = static_cast<uint32_t>(i);
        tree_.see(ids[i]);
        follow_box(ids[i].value);
    }
    tree_.update();
}

bool LeafItems::matches(const Item& item, const PlacedDrawable& leaf) const
{
    return item.placed.drawable == leaf.drawable &&
           same_place(item.placed.world_from_model, leaf.world_from_model);
}

// An item of this drawable at this place that no leaf of this frame has yet.
uint32_t LeafItems::look_up(const PlacedDrawable& leaf) const
{
    const auto [begin, end] = by_place_.equal_range(place_hash(leaf));
    for (auto at = begin; at != end; ++at) {
        const Item& item = items_[at->second];
        if ((item.last_seen != frame_ || frame_ == 0) && matches(item, leaf)) {
            return at->second;
        }
    }
    return kNone;
}

uint32_t LeafItems::add(const PlacedDrawable& leaf)
{
    const auto id = static_cast<uint32_t>(items_.size());
    items_.push_back({leaf, leaf.drawable->getBoundingBox(), 0, 0});
    tree_.add(world_box(items_.back().local_box, leaf.world_from_model),
              triangles_of(*leaf.drawable));
    by_place_.emplace(place_hash(leaf), id);
    return id;
}

// The item has moved to where the leaf is.
void LeafItems::place(uint32_t id, const PlacedDrawable& leaf)
{
    const auto [begin, end] = by_place_.equal_range(place_hash(items_[id].placed));
    for (auto at = begin; at != end; ++at) {
        if (at->second == id) {
            by_place_.erase(at);
            break;
        }
    }
    by_place_.emplace(place_hash(leaf), id);
    items_[id].placed = leaf;
    tree_.set_box(ItemId{id}, world_box(items_[id].local_box, leaf.world_from_model));
}

// Replaces the box if the item has moved, its drawable has another box, or it was missing.
void LeafItems::follow_box(uint32_t id)
{
    Item& item = items_[id];
    const osg::BoundingBox& local = item.placed.drawable->getBoundingBox();
    const bool same_box = local._min == item.local_box._min && local._max == item.local_box._max;
    if (same_box && !tree_.box(ItemId{id}).is_empty()) {
        return;
    }
    if (!same_box) {
        item.local_box = local;
        tree_.set_triangles(ItemId{id}, triangles_of(*item.placed.drawable));
    }
    tree_.set_box(ItemId{id}, world_box(local, item.placed.world_from_model));
}

// Gives leaves at new places the items of the last frame that are missing now; the rest is new.
void LeafItems::match_moved(std::span<const PlacedDrawable> leaves, std::vector<ItemId>& ids)
{
    if (unmatched_.empty()) {
        return;
    }
    std::unordered_multimap<const osg::Drawable*, uint32_t> missing;
    for (auto at = sequence_.rbegin(); at != sequence_.rend(); ++at) {
        if (items_[*at].last_seen != frame_) {
            missing.emplace(items_[*at].placed.drawable, *at);
        }
    }
    for (const uint32_t leaf : unmatched_) {
        const auto found = missing.find(leaves[leaf].drawable);
        uint32_t id = kNone;
        if (found != missing.end()) {
            id = found->second;
            missing.erase(found);
            place(id, leaves[leaf]);
        } else {
            id = add(leaves[leaf]);
        }
        items_[id].last_seen = frame_;
        ids[leaf] = ItemId{id};
    }
}

// Takes ids away from items that were missing for long, and gives the others new ones.
void LeafItems::forget_missing()
{
    std::vector<uint32_t> new_ids(items_.size(), kNone);
    uint32_t kept = 0;
    for (uint32_t id = 0; id < items_.size(); ++id) {
        if (items_[id].last_seen + kForgetAfterFrames >= frame_) {
            items_[kept] = items_[id];
            new_ids[id] = kept++;
        }
    }
    items_.resize(kept);
    by_place_.clear();
    for (uint32_t id = 0; id < kept; ++id) {
        by_place_.emplace(place_hash(items_[id].placed), id);
    }
    for (uint32_t& id : sequence_) { // of the last frame: all of them are kept
        id = new_ids[id];
    }
    tree_.renumber(new_ids);
}

} // namespace occlude
