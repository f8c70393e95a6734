#include <occlude/hierarchy/builders/detail/scene_bsp.h>

#include <occlude/core/assert.h>

#include <algorithm>
#include <utility>

namespace occlude::detail {

/// One object in this many may be drawn with a cell to which it is no longer linked.
constexpr size_t kObjectsPerStaleLink = 64;

uint32_t KeyPool::take(uint32_t count)
{
    const auto found = free_.find(count);
    if (found != free_.end() && !found->second.empty()) {
        const uint32_t first = found->second.back();
        found->second.pop_back();
        return first;
    }
    return std::exchange(end_, end_ + count);
}

void KeyPool::give_back(uint32_t first, uint32_t count)
{
    free_[count].push_back(first);
}

SceneBsp::SceneBsp(const TwoLevelOptions& options)
    : options_(options)
{
    options_.leaf_objects = std::max(options_.leaf_objects, 1u);
    options_.rebuild_period = std::max(options_.rebuild_period, 1u);
    Cell root;
    root.box = Aabb::everything();
    root.key = keys_.take(1);
    cells_.assign(2, root); // the second is a gap, so that pairs start at even places
}

SceneBsp::Slot SceneBsp::add(const TwoLevelObject& added)
{
    OCCLUDE_ASSERT(!added.local_boxes.empty(), "an object needs the box of at least one item");
    OCCLUDE_ASSERT(added.first_item.valid(), "an object needs the id of its first item");
    if (added.local_boxes.empty() || !added.first_item.valid()) {
        return kNone; // no slot is in use by that number
    }
    Slot slot = static_cast<Slot>(objects_.size());
    if (free_slots_.empty()) {
        objects_.emplace_back();
    } else {
        slot = free_slots_.back();
        free_slots_.pop_back();
    }
    Object& object = objects_[slot];
    object.first_item = added.first_item;
    object.item_count = static_cast<uint32_t>(added.local_boxes.size());
    object.world_from_object = added.world_from_object;
    object.tree = added.tree != nullptr ? *added.tree : build_local_tree(added.local_boxes);
    object.first_key = keys_.take(static_cast<uint32_t>(object.tree.nodes.size()));
    mark_moved(slot);
    layout_stale_ = true;
    return slot;
}

void SceneBsp::mark_moved(Slot slot)
{
    if (!objects_[slot].moved) {
        objects_[slot].moved = true;
        moved_.push_back(slot);
    }
}

void SceneBsp::move(Slot slot, const glm::mat4& world_from_object)
{
    OCCLUDE_ASSERT(in_use(slot), "only an object that is in the tree can move");
    if (!in_use(slot)) {
        return;
    }
    objects_[slot].world_from_object = world_from_object;
    mark_moved(slot);
}

void SceneBsp::remove(Slot slot)
{
    OCCLUDE_ASSERT(in_use(slot), "only an object that is in the tree can be removed");
    if (!in_use(slot)) {
        return;
    }
    Object& object = objects_[slot];
    if (object.cell != kNone) {
        count_change(object.cell, kNone);
        unlink(slot);
    }
    keys_.give_back(object.first_key, static_cast<uint32_t>(object.tree.nodes.size()));
    std::erase(moved_, slot);
    object = Object{};
    free_slots_.push_back(slot);
    layout_stale_ = true;
}

// The world box of an object, and whether it is complex, from the bounds of its items.
void SceneBsp::place(Object& object, std::span<const ItemBounds> bounds)
{
    object.box = Aabb{};
    uint64_t triangles = 0;
    for (uint32_t i = 0; i < object.item_count; ++i) {
        const uint32_t item = object.first_item.value + i;
        const bool known = item < bounds.size();
        OCCLUDE_ASSERT(known, "update() needs the bounds of every item of a moved object");
        object.box = merge(object.box, known ? bounds[item].box : Aabb::everything());
        triangles += known ? bounds[item].triangles : 0;
    }
    const bool complex = object.item_count > 1 || triangles >= options_.complex_triangles;
    layout_stale_ = layout_stale_ || complex != object.complex;
    object.complex = complex;
}

// The smallest cell that contains the box: up from `start`, then down.
uint32_t SceneBsp::home_of(const Aabb& box, uint32_t start) const
{
    if (!box.is_bounded()) {
        return kRoot;
    }
    uint32_t cell = start;
    while (cell != kRoot && !contains(cells_[cell].box, box)) {
        cell = cells_[cell].parent;
    }
    for (;;) {
        const uint32_t child = cells_[cell].first_child;
        if (child == kNone) {
            return cell;
        }
        if (contains(cells_[child].box, box)) {
            cell = child;
        } else if (contains(cells_[child + 1].box, box)) {
            cell = child + 1;
        } else {
            return cell;
        }
    }
}

void SceneBsp::link(Slot slot, uint32_t cell)
{
    Object& object = objects_[slot];
    Cell& home = cells_[cell];
    object.cell = cell;
    object.previous = kNone;
    object.next = home.first_object;
    if (home.first_object != kNone) {
        objects_[home.first_object].previous = slot;
    }
    home.first_object = slot;
    for (uint32_t at = cell; at != kNone; at = cells_[at].parent) {
        ++cells_[at].subtree_objects;
    }
}

void SceneBsp::unlink(Slot slot)
{
    Object& object = objects_[slot];
    if (object.previous != kNone) {
        objects_[object.previous].next = object.next;
    } else {
        cells_[object.cell].first_object = object.next;
    }
    if (object.next != kNone) {
        objects_[object.next].previous = object.previous;
    }
    for (uint32_t at = object.cell; at != kNone; at = cells_[at].parent) {
        --cells_[at].subtree_objects;
    }
    object.cell = kNone;
}

// Counts a change of link in the subtrees of `from` and `to`, up to the node where the paths meet.
// Above it, no subtree has gained or lost anything. If one of them is kNone, counts up to the root.
void SceneBsp::count_change(uint32_t from, uint32_t to)
{
    while (from != to) {
        const bool from_is_deeper =
            to == kNone || (from != kNone && cells_[from].depth >= cells_[to].depth);
        uint32_t& deeper = from_is_deeper ? from : to;
        ++cells_[deeper].changes;
        deeper = cells_[deeper].parent;
    }
    if (from != kNone) {
        ++cells_[from].changes;
    }
}

void SceneBsp::mark_restless(uint32_t cell)
{
    for (uint32_t at = cell; at != kNone; at = cells_[at].parent) {
        cells_[at].restless_at = updates_;
    }
}

void SceneBsp::relink(Slot slot)
{
    Object& object = objects_[slot];
    const uint32_t from = object.cell;
    const uint32_t home = home_of(object.box, from == kNone ? kRoot : from);
    if (home != from) {
        count_change(from, home);
        if (from != kNone) {
            mark_restless(from);
            unlink(slot);
            ++relinks_;
            ++stale_links_;
        }
        link(slot, home);
    }
    mark_restless(home);
}

bool SceneBsp::needs_layout() const
{
    return layout_stale_ || stale_links_ > cells_[kRoot].subtree_objects / kObjectsPerStaleLink;
}

void SceneBsp::finish_layout()
{
    layout_stale_ = false;
    stale_links_ = 0;
}

bool SceneBsp::update(std::span<const ItemBounds> bounds_by_item)
{
    ++updates_;
    const bool anything = !moved_.empty() || layout_stale_;
    for (const Slot slot : moved_) {
        objects_[slot].moved = false;
        place(objects_[slot], bounds_by_item);
        relink(slot);
    }
    if (needs_layout() || !anything) {
        reconstruct();
    }
    return anything || layout_stale_;
}

std::string SceneBsp::check() const
{
    for (size_t slot = 0; slot < objects_.size(); ++slot) {
        const Object& object = objects_[slot];
        if (object.item_count == 0) {
            continue;
        }
        if (object.cell == kNone || !contains(cells_[object.cell].box, object.box)) {
            return "object " + std::to_string(slot) + " is outside of its cell";
        }
        if (object.cell != home_of(object.box, kRoot)) {
            return "object " + std::to_string(slot) + " is not in the smallest cell around it";
        }
    }
    return {};
}

} // namespace occlude::detail
