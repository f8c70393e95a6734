#include <occlude/hierarchy/builders/detail/two_level_layout.h>

#include <occlude/hierarchy/detail/huge_pages.h>

#include <algorithm>
#include <array>
#include <utility>

namespace occlude::detail {

namespace {

constexpr uint32_t kNone = SceneBsp::kNone;
/// A partial refit pays if at most one item in this many has moved.
constexpr size_t kItemsPerMoved = 8;

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

} // namespace

struct TwoLevelLayout::Arrays {
    std::span<const ItemBounds> bounds;
    std::vector<Node> nodes;
    std::vector<ItemId> items;
    std::vector<ItemBounds> item_bounds;
    std::vector<uint32_t> cell_of;
    std::vector<uint32_t> local_of;
    std::vector<uint32_t> object_of;

    uint32_t add_nodes(uint32_t count)
    {
        const auto first = static_cast<uint32_t>(nodes.size());
        nodes.resize(nodes.size() + count);
        cell_of.resize(nodes.size(), kNone);
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

void TwoLevelLayout::emit_local(Arrays& arrays, const SceneBsp::Object& object, SceneBsp::Slot slot,
                                uint32_t local, uint32_t at)
{
    const LocalTree::Node& node = object.tree.nodes[local];
    arrays.local_of[at] = local;
    arrays.object_of[at] = slot;
    arrays.nodes[at].first_item = static_cast<uint32_t>(arrays.items.size());
    if (node.first_child == LocalTree::kNone) {
        arrays.add_item(at, ItemId{object.first_item.value + node.part});
        return;
    }
    const uint32_t first = arrays.add_nodes(2);
    arrays.set_children(at, first, 2);
    emit_local(arrays, object, slot, node.first_child, first);
    emit_local(arrays, object, slot, node.first_child + 1, first + 1);
}

// Simple objects are own items of the node. Its children are the two halves, unless they are empty,
// and complex objects.
void TwoLevelLayout::emit_cell(Arrays& arrays, const SceneBsp& bsp, uint32_t cell, uint32_t at)
{
    const SceneBsp::Cell& c = bsp.cell(cell);
    arrays.cell_of[at] = cell;
    arrays.nodes[at].first_item = static_cast<uint32_t>(arrays.items.size());
    std::vector<SceneBsp::Slot> complex;
    for (uint32_t slot = c.first_object; slot != kNone; slot = bsp.objects()[slot].next) {
        if (bsp.objects()[slot].complex) {
            complex.push_back(slot);
        } else {
            arrays.add_item(at, bsp.objects()[slot].first_item);
        }
    }
    std::array<uint32_t, 2> halves{};
    uint32_t half_count = 0;
    for (uint32_t side = 0; side < 2 && c.first_child != kNone; ++side) {
        if (bsp.cell(c.first_child + side).subtree_objects > 0) {
            halves[half_count++] = c.first_child + side;
        }
    }
    const uint32_t count = half_count + static_cast<uint32_t>(complex.size());
    uint32_t child = arrays.add_nodes(count);
    arrays.set_children(at, child, count);
    for (uint32_t side = 0; side < half_count; ++side) {
        emit_cell(arrays, bsp, halves[side], child++);
    }
    for (const SceneBsp::Slot slot : complex) {
        emit_local(arrays, bsp.objects()[slot], slot, 0, child++);
    }
}

void TwoLevelLayout::lay_out(const SceneBsp& bsp, std::span<const ItemBounds> bounds_by_item)
{
    Arrays arrays;
    arrays.bounds = bounds_by_item;
    const auto with_reserve = [](size_t size) { return size + size / 16; };
    reserve_huge(arrays.nodes, with_reserve(hierarchy_.nodes().size()));
    reserve_huge(arrays.items, with_reserve(hierarchy_.items().size()));
    reserve_huge(arrays.item_bounds, with_reserve(hierarchy_.items().size()));
    arrays.cell_of = std::move(cell_of_);
    arrays.local_of = std::move(local_of_);
    arrays.object_of = std::move(object_of_);
    arrays.cell_of.clear();
    arrays.local_of.clear();
    arrays.object_of.clear();
    ObjectNodes object_nodes = hierarchy_.take_object_nodes();
    const ItemShapes* const shapes = hierarchy_.shapes();
    if (bsp.cell(SceneBsp::kRoot).subtree_objects > 0) {
        emit_cell(arrays, bsp, SceneBsp::kRoot, arrays.add_nodes(1));
    }
    hierarchy_ = Hierarchy::from_arrays(std::move(arrays.nodes), std::move(arrays.items),
                                        std::move(arrays.item_bounds));
    hierarchy_.set_virtual_leaves(options_.leaf_triangles);
    hierarchy_.set_shapes(shapes); // they are indexed by item, and items stay
    cell_of_ = std::move(arrays.cell_of);
    local_of_ = std::move(arrays.local_of);
    object_of_ = std::move(arrays.object_of);
    if (lineage_ == 0) {
        lineage_ = hierarchy_.structure_version();
    }
    set_object_nodes(bsp, std::move(object_nodes));
}

// The box to test for a node of the scene BSP: its cell while its contents move, else the box
// around them.
Aabb TwoLevelLayout::cell_test_box(const SceneBsp& bsp, const SceneBsp::Cell& cell,
                                   const Aabb& tight) const
{
    const Aabb& scene = hierarchy_.node(hierarchy_.root()).box;
    const bool quiet = cell.restless_at + options_.quiet_frames <= bsp.updates();
    if (quiet || !scene.is_bounded()) {
        return tight;
    }
    return merge(tight, intersection(cell.box, scene));
}

Aabb TwoLevelLayout::test_box(const SceneBsp& bsp, const ObjectNodes& object_nodes,
                              size_t node) const
{
    const Aabb& tight = hierarchy_.nodes()[node].box;
    if (cell_of_[node] != kNone) {
        return cell_test_box(bsp, bsp.cell(cell_of_[node]), tight);
    }
    const uint32_t slot = object_of_[node];
    return object_nodes.frames[slot].oriented ? bsp.objects()[slot].tree.nodes[local_of_[node]].box
                                              : tight;
}

void TwoLevelLayout::set_object_nodes(const SceneBsp& bsp, ObjectNodes object_nodes)
{
    const size_t node_count = hierarchy_.nodes().size();
    const std::span<const SceneBsp::Object> objects = bsp.objects();
    object_nodes.object.assign(node_count, ObjectNodes::kScene);
    object_nodes.box.resize(node_count);
    object_nodes.key.resize(node_count);
    object_nodes.frames.resize(objects.size());
    for (size_t slot = 0; slot < objects.size(); ++slot) {
        const glm::mat4& world_from_object = objects[slot].world_from_object;
        object_nodes.frames[slot] = {world_from_object, !keeps_axes(world_from_object)};
    }
    for (size_t i = 0; i < node_count; ++i) {
        if (cell_of_[i] != kNone) {
            object_nodes.key[i] = bsp.cell(cell_of_[i]).key;
        } else {
            object_nodes.object[i] = object_of_[i];
            object_nodes.key[i] = objects[object_of_[i]].first_key + local_of_[i];
        }
        object_nodes.box[i] = test_box(bsp, object_nodes, i);
    }
    object_nodes.key_count = bsp.key_end();
    object_nodes.lineage = lineage_;
    hierarchy_.set_object_nodes(std::move(object_nodes));
}

// True if no moved object has become rotated or ceased to be rotated: boxes stay in their spaces.
bool TwoLevelLayout::oriented_as_before(const SceneBsp& bsp) const
{
    const std::vector<ObjectNodes::ObjectFrame>& frames = hierarchy_.object_nodes().frames;
    return std::ranges::all_of(bsp.moved(), [&](SceneBsp::Slot slot) {
        return frames[slot].oriented == !keeps_axes(bsp.objects()[slot].world_from_object);
    });
}

void TwoLevelLayout::refit(const SceneBsp& bsp, std::span<const ItemBounds> bounds_by_item)
{
    moved_items_.clear();
    for (const SceneBsp::Slot slot : bsp.moved()) {
        const SceneBsp::Object& object = bsp.objects()[slot];
        for (uint32_t i = 0; i < object.item_count; ++i) {
            moved_items_.push_back(ItemId{object.first_item.value + i});
        }
    }
    const bool few = moved_items_.size() * kItemsPerMoved <= hierarchy_.items().size();
    // With quiet_frames, cells turn quiet where nothing has moved, so that all boxes must be
    // checked.
    if (few && options_.quiet_frames == 0 && oriented_as_before(bsp)) {
        refit_moved(bsp, bounds_by_item);
        return;
    }
    ObjectNodes object_nodes = hierarchy_.take_object_nodes();
    hierarchy_.refit(bounds_by_item);
    set_object_nodes(bsp, std::move(object_nodes));
}

void TwoLevelLayout::refit_moved(const SceneBsp& bsp, std::span<const ItemBounds> bounds_by_item)
{
    ObjectNodes object_nodes = hierarchy_.take_object_nodes();
    changed_.clear();
    hierarchy_.refit(moved_items_, bounds_by_item, &changed_);
    for (const SceneBsp::Slot slot : bsp.moved()) {
        object_nodes.frames[slot].world_from_object = bsp.objects()[slot].world_from_object;
    }
    for (const NodeId node : changed_) {
        object_nodes.box[node.value] = test_box(bsp, object_nodes, node.value);
    }
    hierarchy_.set_object_nodes(std::move(object_nodes));
}

} // namespace occlude::detail
