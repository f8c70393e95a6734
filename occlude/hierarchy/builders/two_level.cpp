#include <occlude/hierarchy/builders/two_level.h>

#include <occlude/core/assert.h>
#include <occlude/hierarchy/detail/huge_pages.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

namespace occlude {

namespace {

constexpr uint32_t kMaxDepth = 48;
/// So many objects to one that is drawn where it was and no longer is linked.
constexpr size_t kObjectsPerStaleLink = 64;
/// Only the nodes above moved items are refitted where these are at most one in so many.
constexpr size_t kItemsPerMoved = 8;
/// Planes are tried at this many places per axis.
constexpr size_t kCandidates = 15;

double area(const Aabb& box)
{
    if (!box.is_bounded()) {
        return 0.0;
    }
    const glm::dvec3 size = glm::dvec3{box.max} - glm::dvec3{box.min};
    return 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
}

Aabb intersection(const Aabb& a, const Aabb& b)
{
    return {glm::max(a.min, b.min), glm::min(a.max, b.max)};
}

// True if the map keeps axes along axes, so that a transformed box is as tight as the box.
bool keeps_axes(const glm::mat4& m)
{
    for (int column = 0; column < 3; ++column) {
        int used = 0;
        for (int row = 0; row < 3; ++row) {
            used += m[column][row] != 0.0f ? 1 : 0;
        }
        if (used > 1) {
            return false;
        }
    }
    return true;
}

// --- the local tree
// ----------------------------------------------------------------------------------

struct LocalBuilder {
    std::span<const Aabb> boxes;
    LocalTree tree;
    std::vector<Aabb> from_right;

    static float middle(const Aabb& box, int axis)
    {
        return box.is_bounded() ? box.center()[axis] : 0.0f;
    }

    void sort_along(std::span<uint32_t> parts, int axis) const
    {
        std::sort(parts.begin(), parts.end(), [&](uint32_t a, uint32_t b) {
            const float at_a = middle(boxes[a], axis);
            const float at_b = middle(boxes[b], axis);
            return at_a != at_b ? at_a < at_b : a < b;
        });
    }

    // The cheapest way to cut parts sorted by their middles in two: area times parts of both sides,
    // and where sides overlap along the axis, the tree is no BSP: that comes last.
    std::pair<double, size_t> best_cut(std::span<const uint32_t> parts, int axis)
    {
        from_right.assign(parts.size() + 1, Aabb{});
        for (size_t i = parts.size(); i-- > 0;) {
            from_right[i] = merge(from_right[i + 1], boxes[parts[i]]);
        }
        std::pair<double, size_t> best{Aabb::kInfinity, parts.size() / 2};
        const double whole = area(from_right[0]) * static_cast<double>(parts.size());
        Aabb left;
        for (size_t cut = 1; cut < parts.size(); ++cut) {
            left = merge(left, boxes[parts[cut - 1]]);
            const Aabb& right = from_right[cut];
            const auto count = static_cast<double>(cut);
            const auto rest = static_cast<double>(parts.size() - cut);
            const bool overlap = left.max[axis] > right.min[axis];
            const double cost = area(left) * count + area(right) * rest + (overlap ? whole : 0.0);
            if (cost < best.first) {
                best = {cost, cut};
            }
        }
        return best;
    }

    void build(uint32_t node, std::span<uint32_t> parts)
    {
        for (const uint32_t part : parts) {
            tree.nodes[node].box = merge(tree.nodes[node].box, boxes[part]);
        }
        if (parts.size() == 1) {
            tree.nodes[node].part = parts[0];
            return;
        }
        double least = Aabb::kInfinity;
        int best_axis = 0;
        size_t cut = parts.size() / 2;
        for (int axis = 0; axis < 3; ++axis) {
            sort_along(parts, axis);
            const auto [cost, at] = best_cut(parts, axis);
            if (cost < least) {
                least = cost;
                best_axis = axis;
                cut = at;
            }
        }
        sort_along(parts, best_axis);
        const auto child = static_cast<uint32_t>(tree.nodes.size());
        tree.nodes[node].first_child = child;
        tree.nodes.resize(child + 2);
        build(child, parts.first(cut));
        build(child + 1, parts.subspan(cut));
    }
};

} // namespace

LocalTree build_local_tree(std::span<const Aabb> part_boxes)
{
    LocalBuilder builder{part_boxes, {}, {}};
    if (!part_boxes.empty()) {
        std::vector<uint32_t> parts(part_boxes.size());
        std::iota(parts.begin(), parts.end(), 0u);
        builder.tree.nodes.resize(1);
        builder.build(0, parts);
    }
    return std::move(builder.tree);
}

// --- keys
// --------------------------------------------------------------------------------------------

uint32_t TwoLevelTree::KeyPool::take(uint32_t count)
{
    const auto found = free_.find(count);
    if (found != free_.end() && !found->second.empty()) {
        const uint32_t first = found->second.back();
        found->second.pop_back();
        return first;
    }
    return std::exchange(end_, end_ + count);
}

void TwoLevelTree::KeyPool::give_back(uint32_t first, uint32_t count)
{
    free_[count].push_back(first);
}

// --- objects
// -----------------------------------------------------------------------------------------

TwoLevelTree::TwoLevelTree(const TwoLevelOptions& options)
    : options_(options)
{
    options_.leaf_objects = std::max(options_.leaf_objects, 1u);
    options_.rebuild_period = std::max(options_.rebuild_period, 1u);
    SceneNode root;
    root.cell = Aabb::everything();
    root.key = keys_.take(1);
    scene_.assign(2, root); // the second is a gap, so that pairs start at even places
}

TwoLevelTree::Slot TwoLevelTree::add(const TwoLevelObject& added)
{
    OCCLUDE_ASSERT(!added.local_boxes.empty(), "an object has at least one item");
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

void TwoLevelTree::mark_moved(Slot slot)
{
    if (!objects_[slot].moved) {
        objects_[slot].moved = true;
        moved_.push_back(slot);
    }
}

void TwoLevelTree::move(Slot slot, const glm::mat4& world_from_object)
{
    OCCLUDE_ASSERT(slot < objects_.size() && objects_[slot].item_count > 0, "a slot in use");
    objects_[slot].world_from_object = world_from_object;
    mark_moved(slot);
}

void TwoLevelTree::remove(Slot slot)
{
    OCCLUDE_ASSERT(slot < objects_.size() && objects_[slot].item_count > 0, "a slot in use");
    Object& object = objects_[slot];
    if (object.node != kNone) {
        count_change(object.node, kNone);
        unlink(slot);
    }
    keys_.give_back(object.first_key, static_cast<uint32_t>(object.tree.nodes.size()));
    std::erase(moved_, slot);
    object = Object{};
    free_slots_.push_back(slot);
    layout_stale_ = true;
}

// The world box of an object, and whether it is complex, from the bounds of its items.
void TwoLevelTree::place(Object& object, std::span<const ItemBounds> bounds)
{
    object.box = Aabb{};
    uint64_t triangles = 0;
    for (uint32_t i = 0; i < object.item_count; ++i) {
        const uint32_t item = object.first_item.value + i;
        const bool known = item < bounds.size();
        OCCLUDE_ASSERT(known, "update() needs the bounds of every item");
        object.box = merge(object.box, known ? bounds[item].box : Aabb::everything());
        triangles += known ? bounds[item].triangles : 0;
    }
    const bool complex = object.item_count > 1 || triangles >= options_.complex_triangles;
    layout_stale_ = layout_stale_ || complex != object.complex;
    object.complex = complex;
}

// --- links
// -------------------------------------------------------------------------------------------

// The smallest node whose cell contains the box. Up from `start`, then down.
uint32_t TwoLevelTree::home_of(const Aabb& box, uint32_t start) const
{
    if (!box.is_bounded()) {
        return kRoot;
    }
    uint32_t node = start;
    while (node != kRoot && !contains(scene_[node].cell, box)) {
        node = scene_[node].parent;
    }
    for (;;) {
        const uint32_t child = scene_[node].first_child;
        if (child == kNone) {
            return node;
        }
        if (contains(scene_[child].cell, box)) {
            node = child;
        } else if (contains(scene_[child + 1].cell, box)) {
            node = child + 1;
        } else {
            return node;
        }
    }
}

void TwoLevelTree::link(Slot slot, uint32_t node)
{
    Object& object = objects_[slot];
    SceneNode& home = scene_[node];
    object.node = node;
    object.previous = kNone;
    object.next = home.first_object;
    if (home.first_object != kNone) {
        objects_[home.first_object].previous = slot;
    }
    home.first_object = slot;
    ++home.own_objects;
    for (uint32_t at = node; at != kNone; at = scene_[at].parent) {
        ++scene_[at].subtree_objects;
    }
}

void TwoLevelTree::unlink(Slot slot)
{
    Object& object = objects_[slot];
    SceneNode& home = scene_[object.node];
    if (object.previous != kNone) {
        objects_[object.previous].next = object.next;
    } else {
        home.first_object = object.next;
    }
    if (object.next != kNone) {
        objects_[object.next].previous = object.previous;
    }
    --home.own_objects;
    for (uint32_t at = object.node; at != kNone; at = scene_[at].parent) {
        --scene_[at].subtree_objects;
    }
    object.node = kNone;
}

// Counts a change of link in the subtrees of `from` and `to`, up to where the paths meet: above
// that, nothing went in or out. With one of them kNone, all the way up.
void TwoLevelTree::count_change(uint32_t from, uint32_t to)
{
    while (from != to) {
        const bool from_is_deeper =
            to == kNone || (from != kNone && scene_[from].depth >= scene_[to].depth);
        uint32_t& deeper = from_is_deeper ? from : to;
        ++scene_[deeper].changes;
        deeper = scene_[deeper].parent;
    }
    if (from != kNone) {
        ++scene_[from].changes;
    }
}

void TwoLevelTree::mark_restless(uint32_t node)
{
    for (uint32_t at = node; at != kNone; at = scene_[at].parent) {
        scene_[at].restless_at = updates_;
    }
}

void TwoLevelTree::relink(Slot slot)
{
    Object& object = objects_[slot];
    const uint32_t from = object.node;
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

// --- the scene tree
// ----------------------------------------------------------------------------------

uint32_t TwoLevelTree::take_pair(uint32_t parent)
{
    uint32_t first = static_cast<uint32_t>(scene_.size());
    if (free_pairs_.empty()) {
        scene_.resize(scene_.size() + 2);
    } else {
        first = free_pairs_.back();
        free_pairs_.pop_back();
    }
    for (uint32_t child = first; child < first + 2; ++child) {
        scene_[child] = SceneNode{};
        scene_[child].cell = scene_[parent].cell;
        scene_[child].parent = parent;
        scene_[child].depth = scene_[parent].depth + 1;
        scene_[child].key = keys_.take(1);
        scene_[child].restless_at = updates_;
    }
    scene_[parent].first_child = first;
    return first;
}

// The plane of least area * items of both sides and of what straddles it; false if no plane beats
// leaving the node as it is.
bool TwoLevelTree::choose_plane(std::span<const Slot> slots, Plane& best) const
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
        double cost() const { return area(box) * items; }
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
            const double cost = low.cost() + high.cost() + area(all.box) * straddling.items;
            if (low.objects + high.objects > 0 && cost < least) {
                least = cost;
                best = plane;
                found = true;
            }
        }
    }
    return found;
}

// Links `slots`, which are linked nowhere, below `node`, which has no children.
void TwoLevelTree::build_scene(uint32_t node, std::vector<Slot> slots)
{
    std::vector<Slot> low;
    std::vector<Slot> high;
    Plane plane;
    std::erase_if(slots, [&](Slot slot) {
        const bool here = !objects_[slot].box.is_bounded(); // above all planes
        if (here) {
            link(slot, node);
        }
        return here;
    });
    const bool split = slots.size() > options_.leaf_objects && scene_[node].depth < kMaxDepth &&
                       choose_plane(slots, plane);
    for (const Slot slot : slots) {
        const Aabb& box = objects_[slot].box;
        if (split && box.max[plane.axis] <= plane.at) {
            low.push_back(slot);
        } else if (split && box.min[plane.axis] >= plane.at) {
            high.push_back(slot);
        } else {
            link(slot, node);
        }
    }
    if (split) {
        slots = {};
        const uint32_t child = take_pair(node);
        scene_[child].cell.max[plane.axis] = plane.at;
        scene_[child + 1].cell.min[plane.axis] = plane.at;
        build_scene(child, std::move(low));
        build_scene(child + 1, std::move(high));
    }
}

// Unlinks everything below `node`, in the order of slots, and frees the nodes below it.
void TwoLevelTree::clear_subtree(uint32_t node, std::vector<Slot>& slots)
{
    while (scene_[node].first_object != kNone) {
        slots.push_back(scene_[node].first_object);
        unlink(scene_[node].first_object);
    }
    const uint32_t child = std::exchange(scene_[node].first_child, kNone);
    if (child != kNone) {
        clear_subtree(child, slots);
        clear_subtree(child + 1, slots);
        keys_.give_back(scene_[child].key, 1);
        keys_.give_back(scene_[child + 1].key, 1);
        free_pairs_.push_back(child);
    }
}

void TwoLevelTree::rebuild(uint32_t node)
{
    std::vector<Slot> slots;
    clear_subtree(node, slots);
    std::sort(slots.begin(), slots.end());
    scene_[node].changes = 0;
    build_scene(node, std::move(slots));
    ++rebuilds_;
    layout_stale_ = true;
}

bool TwoLevelTree::needs_rebuild(const SceneNode& node) const
{
    const float allowed = options_.rebuild_share * static_cast<float>(node.subtree_objects);
    return static_cast<float>(node.changes) >
           std::max(allowed, static_cast<float>(options_.leaf_objects));
}

bool TwoLevelTree::needs_layout() const
{
    return layout_stale_ || stale_links_ > scene_[kRoot].subtree_objects / kObjectsPerStaleLink;
}

// Rebuilds at most one subtree: of those that need it the one with the most changes, the upper one
// of equals, which takes care of those below it.
void TwoLevelTree::reconstruct()
{
    if (updates_ < reconstruct_at_) {
        return;
    }
    reconstruct_at_ = updates_ + options_.rebuild_period;
    uint32_t worst = kNone;
    uint32_t most_changes = 0;
    walk_.assign(1, kRoot);
    while (!walk_.empty()) {
        const uint32_t node = walk_.back();
        walk_.pop_back();
        const SceneNode& n = scene_[node];
        if (needs_rebuild(n) && n.changes > most_changes) {
            worst = node;
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

// --- the hierarchy
// -----------------------------------------------------------------------------------

struct TwoLevelTree::Layout {
    std::span<const ItemBounds> bounds;
    std::vector<Node> nodes;
    std::vector<ItemId> items;
    std::vector<ItemBounds> item_bounds;
    std::vector<uint32_t> scene_of;
    std::vector<uint32_t> local_of;
    std::vector<uint32_t> object_of;

    uint32_t add_nodes(uint32_t count)
    {
        const auto first = static_cast<uint32_t>(nodes.size());
        nodes.resize(nodes.size() + count);
        scene_of.resize(nodes.size(), kNone);
        local_of.resize(nodes.size(), kNone);
        object_of.resize(nodes.size(), kNone);
        return first;
    }
    void set_children(uint32_t at, uint32_t first, uint32_t count)
    {
        nodes[at].first_child = count > 0 ? NodeId{first} : NodeId{};
        nodes[at].child_count = count;
    }
    void add_item(uint32_t at, ItemId item)
    {
        items.push_back(item);
        item_bounds.push_back(item.value < bounds.size() ? bounds[item.value]
                                                         : ItemBounds{Aabb::everything()});
        ++nodes[at].own_items;
    }
};

void TwoLevelTree::emit_local(Layout& layout, const Object& object, Slot slot, uint32_t local,
                              uint32_t at) const
{
    const LocalTree::Node& node = object.tree.nodes[local];
    layout.local_of[at] = local;
    layout.object_of[at] = slot;
    layout.nodes[at].first_item = static_cast<uint32_t>(layout.items.size());
    if (node.first_child == LocalTree::kNone) {
        layout.add_item(at, ItemId{object.first_item.value + node.part});
        return;
    }
    const uint32_t first = layout.add_nodes(2);
    layout.set_children(at, first, 2);
    emit_local(layout, object, slot, node.first_child, first);
    emit_local(layout, object, slot, node.first_child + 1, first + 1);
}

// Simple objects are items of the node; halves with something in them and complex objects are its
// children.
void TwoLevelTree::emit_scene(Layout& layout, uint32_t node, uint32_t at) const
{
    const SceneNode& n = scene_[node];
    layout.scene_of[at] = node;
    layout.nodes[at].first_item = static_cast<uint32_t>(layout.items.size());
    std::vector<Slot> complex;
    for (uint32_t slot = n.first_object; slot != kNone; slot = objects_[slot].next) {
        if (objects_[slot].complex) {
            complex.push_back(slot);
        } else {
            layout.add_item(at, objects_[slot].first_item);
        }
    }
    std::array<uint32_t, 2> halves{};
    uint32_t half_count = 0;
    for (uint32_t side = 0; side < 2 && n.first_child != kNone; ++side) {
        if (scene_[n.first_child + side].subtree_objects > 0) {
            halves[half_count++] = n.first_child + side;
        }
    }
    const uint32_t count = half_count + static_cast<uint32_t>(complex.size());
    uint32_t child = layout.add_nodes(count);
    layout.set_children(at, child, count);
    for (uint32_t side = 0; side < half_count; ++side) {
        emit_scene(layout, halves[side], child++);
    }
    for (const Slot slot : complex) {
        emit_local(layout, objects_[slot], slot, 0, child++);
    }
}

void TwoLevelTree::lay_out(std::span<const ItemBounds> bounds)
{
    Layout layout;
    layout.bounds = bounds;
    const auto as_before = [](size_t size) { return size + size / 16; }; // or a little more
    detail::reserve_huge(layout.nodes, as_before(hierarchy_.nodes().size()));
    detail::reserve_huge(layout.items, as_before(hierarchy_.items().size()));
    detail::reserve_huge(layout.item_bounds, as_before(hierarchy_.items().size()));
    layout.scene_of = std::move(scene_of_);
    layout.local_of = std::move(local_of_);
    layout.object_of = std::move(object_of_);
    layout.scene_of.clear();
    layout.local_of.clear();
    layout.object_of.clear();
    TwoLevelNodes info = hierarchy_.take_two_level();
    if (scene_[kRoot].subtree_objects > 0) {
        emit_scene(layout, kRoot, layout.add_nodes(1));
    }
    hierarchy_ = Hierarchy::from_arrays(std::move(layout.nodes), std::move(layout.items),
                                        std::move(layout.item_bounds));
    hierarchy_.set_virtual_leaves(options_.leaf_triangles);
    scene_of_ = std::move(layout.scene_of);
    local_of_ = std::move(layout.local_of);
    object_of_ = std::move(layout.object_of);
    layout_stale_ = false;
    stale_links_ = 0;
    if (lineage_ == 0) {
        lineage_ = hierarchy_.structure_version();
    }
    refresh_two_level(std::move(info));
}

// What a scene node is tested as: its cell while its contents move, else the box around them.
Aabb TwoLevelTree::scene_test_box(const SceneNode& node, const Aabb& tight, const Aabb& scene) const
{
    const bool quiet = node.restless_at + options_.quiet_frames <= updates_;
    if (quiet || !scene.is_bounded()) {
        return tight;
    }
    return merge(tight, intersection(node.cell, scene));
}

Aabb TwoLevelTree::test_box(const TwoLevelNodes& info, size_t node) const
{
    const std::span<const Node> nodes = hierarchy_.nodes();
    if (scene_of_[node] != kNone) {
        return scene_test_box(scene_[scene_of_[node]], nodes[node].box, nodes[0].box);
    }
    const uint32_t slot = object_of_[node];
    return info.frames[slot].oriented ? objects_[slot].tree.nodes[local_of_[node]].box
                                      : nodes[node].box;
}

void TwoLevelTree::refresh_two_level(TwoLevelNodes info)
{
    const std::span<const Node> nodes = hierarchy_.nodes();
    info.object.assign(nodes.size(), TwoLevelNodes::kScene);
    info.box.resize(nodes.size());
    info.key.resize(nodes.size());
    info.frames.resize(objects_.size());
    for (size_t slot = 0; slot < objects_.size(); ++slot) {
        const glm::mat4& world_from_object = objects_[slot].world_from_object;
        info.frames[slot] = {world_from_object, !keeps_axes(world_from_object)};
    }
    for (size_t i = 0; i < nodes.size(); ++i) {
        if (scene_of_[i] != kNone) {
            info.key[i] = scene_[scene_of_[i]].key;
        } else {
            info.object[i] = object_of_[i];
            info.key[i] = objects_[object_of_[i]].first_key + local_of_[i];
        }
        info.box[i] = test_box(info, i);
    }
    info.key_count = keys_.end();
    info.lineage = lineage_;
    hierarchy_.set_two_level(std::move(info));
}

// Is what moved turned where it was, so that boxes stay in their space?
bool TwoLevelTree::oriented_as_before() const
{
    const std::vector<TwoLevelNodes::ObjectFrame>& frames = hierarchy_.two_level().frames;
    return std::ranges::all_of(moved_, [&](Slot slot) {
        return frames[slot].oriented == !keeps_axes(objects_[slot].world_from_object);
    });
}

// In between layouts.
void TwoLevelTree::refit(std::span<const ItemBounds> bounds)
{
    moved_items_.clear();
    for (const Slot slot : moved_) {
        for (uint32_t i = 0; i < objects_[slot].item_count; ++i) {
            moved_items_.push_back(ItemId{objects_[slot].first_item.value + i});
        }
    }
    // Cells of restless nodes calm down by themselves.
    const bool few = moved_items_.size() * kItemsPerMoved <= hierarchy_.items().size();
    if (few && options_.quiet_frames == 0 && oriented_as_before()) {
        refit_moved(bounds);
        return;
    }
    TwoLevelNodes info = hierarchy_.take_two_level();
    hierarchy_.refit(bounds);
    refresh_two_level(std::move(info));
}

void TwoLevelTree::refit_moved(std::span<const ItemBounds> bounds)
{
    TwoLevelNodes info = hierarchy_.take_two_level();
    changed_.clear();
    hierarchy_.refit(moved_items_, bounds, &changed_);
    for (const Slot slot : moved_) {
        info.frames[slot].world_from_object = objects_[slot].world_from_object;
    }
    for (const NodeId node : changed_) {
        info.box[node.value] = test_box(info, node.value);
    }
    hierarchy_.set_two_level(std::move(info));
}

void TwoLevelTree::update(std::span<const ItemBounds> bounds_by_item)
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
    if (anything || layout_stale_) { // cells of a rebuilt subtree are restless, too
        restless_until_ = updates_ + options_.quiet_frames;
    }
    if (needs_layout()) {
        lay_out(bounds_by_item);
    } else if (anything || updates_ <= restless_until_) {
        refit(bounds_by_item);
    }
    moved_.clear();
}

Hierarchy build_two_level(std::span<const ItemBounds> items, const TwoLevelOptions& options)
{
    TwoLevelTree tree(options);
    for (uint32_t i = 0; i < items.size(); ++i) {
        const Aabb box = sanitized(items[i].box);
        tree.add({.first_item = ItemId{i}, .local_boxes = {&box, 1}});
    }
    tree.update(items);
    return tree.hierarchy();
}

// --- for tests
// ---------------------------------------------------------------------------------------

std::string TwoLevelTree::check() const
{
    const TwoLevelNodes& info = hierarchy_.two_level();
    if (std::string problem = validate(hierarchy_); !problem.empty()) {
        return problem;
    }
    std::set<uint32_t> keys;
    size_t items = 0;
    for (size_t i = 0; i < hierarchy_.nodes().size(); ++i) {
        const Aabb& box = hierarchy_.nodes()[i].box;
        if (!keys.insert(info.key[i]).second || info.key[i] >= info.key_count) {
            return "node " + std::to_string(i) + " shares its key or has none";
        }
        if (info.object[i] == TwoLevelNodes::kScene && !contains(info.box[i], box)) {
            return "scene node " + std::to_string(i) + " is tested as less than itself";
        }
    }
    for (size_t slot = 0; slot < objects_.size(); ++slot) {
        const Object& object = objects_[slot];
        items += object.item_count;
        if (object.item_count == 0) {
            continue;
        }
        if (object.node == kNone || !contains(scene_[object.node].cell, object.box)) {
            return "object " + std::to_string(slot) + " is outside of its cell";
        }
        if (object.node != home_of(object.box, kRoot)) {
            return "object " + std::to_string(slot) + " is not in the smallest cell around it";
        }
    }
    return items == hierarchy_.items().size() ? "" : "an item is missing";
}

} // namespace occlude
