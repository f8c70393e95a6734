// Builds the scene BSP, and chooses the part of it to rebuild.
#include <occlude/hierarchy/builders/detail/scene_bsp.h>

#include <occlude/hierarchy/detail/box_area.h>

#include <algorithm>
#include <utility>

namespace occlude::detail {

constexpr uint32_t kMaxDepth = 48;
/// Planes are tried at this many places per axis.
constexpr size_t kCandidates = 15;

uint32_t SceneBsp::take_pair(uint32_t parent)
{
    uint32_t first = static_cast<uint32_t>(cells_.size());
    if (free_pairs_.empty()) {
        cells_.resize(cells_.size() + 2);
    } else {
        first = free_pairs_.back();
        free_pairs_.pop_back();
    }
    for (uint32_t child = first; child < first + 2; ++child) {
        cells_[child] = Cell{};
        cells_[child].box = cells_[parent].box;
        cells_[child].parent = parent;
        cells_[child].depth = cells_[parent].depth + 1;
        cells_[child].key = keys_.take(1);
        cells_[child].restless_at = updates_;
    }
    cells_[parent].first_child = first;
    return first;
}

// The plane with the least area * items, summed over both sides and the straddling objects; false
// if every plane costs more than leaving the cell undivided.
bool SceneBsp::choose_plane(std::span<const Slot> slots, Plane& best) const
{
    struct Side {
        Aabb box;
        double items = 0.0;
        size_t objects = 0;
        void add(const Object& object)
        {
            box = merge(box, object.box);
            items += object.item_count;
            ++objects;
        }
        double cost() const { return box_area(box) * items; }
    };
    Side all;
    Aabb middles;
    for (const Slot slot : slots) {
        all.add(objects_[slot]);
        const glm::vec3 middle = objects_[slot].box.center();
        middles = merge(middles, {middle, middle});
    }
    double least = all.cost();
    bool found = false;
    for (int axis = 0; axis < 3; ++axis) {
        for (size_t k = 1; k <= kCandidates; ++k) {
            const float share = static_cast<float>(k) / static_cast<float>(kCandidates + 1);
            const Plane plane{axis, middles.min[axis] + share * middles.extent()[axis]};
            Side low;
            Side high;
            Side straddling;
            for (const Slot slot : slots) {
                const Aabb& box = objects_[slot].box;
                Side& side = box.max[axis] <= plane.at   ? low
                             : box.min[axis] >= plane.at ? high
                                                         : straddling;
                side.add(objects_[slot]);
            }
            const double cost = low.cost() + high.cost() + box_area(all.box) * straddling.items;
            if (low.objects + high.objects > 0 && cost < least) {
                least = cost;
                best = plane;
                found = true;
            }
        }
    }
    return found;
}

// Links `slots`, which are not linked, below `cell`, which has no children.
void SceneBsp::build_cells(uint32_t cell, std::vector<Slot> slots)
{
    std::vector<Slot> low;
    std::vector<Slot> high;
    Plane plane;
    std::erase_if(slots, [&](Slot slot) {
        const bool here = !objects_[slot].box.is_bounded(); // above all planes
        if (here) {
            link(slot, cell);
        }
        return here;
    });
    const bool split = slots.size() > options_.leaf_objects && cells_[cell].depth < kMaxDepth &&
                       choose_plane(slots, plane);
    for (const Slot slot : slots) {
        const Aabb& box = objects_[slot].box;
        if (split && box.max[plane.axis] <= plane.at) {
            low.push_back(slot);
        } else if (split && box.min[plane.axis] >= plane.at) {
            high.push_back(slot);
        } else {
            link(slot, cell);
        }
    }
    if (split) {
        slots = {};
        const uint32_t child = take_pair(cell);
        cells_[child].box.max[plane.axis] = plane.at;
        cells_[child + 1].box.min[plane.axis] = plane.at;
        build_cells(child, std::move(low));
        build_cells(child + 1, std::move(high));
    }
}

// Unlinks everything below `cell`, in the order of slots, and frees the nodes below it.
void SceneBsp::clear_subtree(uint32_t cell, std::vector<Slot>& slots)
{
    while (cells_[cell].first_object != kNone) {
        slots.push_back(cells_[cell].first_object);
        unlink(cells_[cell].first_object);
    }
    const uint32_t child = std::exchange(cells_[cell].first_child, kNone);
    if (child != kNone) {
        clear_subtree(child, slots);
        clear_subtree(child + 1, slots);
        keys_.give_back(cells_[child].key, 1);
        keys_.give_back(cells_[child + 1].key, 1);
        free_pairs_.push_back(child);
    }
}

void SceneBsp::rebuild(uint32_t cell)
{
    std::vector<Slot> slots;
    clear_subtree(cell, slots);
    std::sort(slots.begin(), slots.end());
    cells_[cell].changes = 0;
    build_cells(cell, std::move(slots));
    ++rebuilds_;
    layout_stale_ = true;
}

bool SceneBsp::needs_rebuild(const Cell& cell) const
{
    const float allowed = options_.rebuild_share * static_cast<float>(cell.subtree_objects);
    return static_cast<float>(cell.changes) >
           std::max(allowed, static_cast<float>(options_.leaf_objects));
}

// Rebuilds at most one subtree: of those that need it, the one with the most changes, and of equals
// the upper one, which contains the lower ones.
void SceneBsp::reconstruct()
{
    if (updates_ < reconstruct_at_) {
        return;
    }
    reconstruct_at_ = updates_ + options_.rebuild_period;
    uint32_t worst = kNone;
    uint32_t most_changes = 0;
    walk_.assign(1, kRoot);
    while (!walk_.empty()) {
        const uint32_t cell = walk_.back();
        walk_.pop_back();
        const Cell& n = cells_[cell];
        if (needs_rebuild(n) && n.changes > most_changes) {
            worst = cell;
            most_changes = n.changes;
        }
        if (n.first_child != kNone) {
            walk_.push_back(n.first_child + 1);
            walk_.push_back(n.first_child);
        }
    }
    if (worst != kNone) {
        rebuild(worst);
    }
}

} // namespace occlude::detail
