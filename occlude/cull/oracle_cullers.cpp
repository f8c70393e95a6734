#include <occlude/cull/oracle_cullers.h>

#include <occlude/core/assert.h>
#include <occlude/cull/parts/cull_frame.h>

#include <algorithm>
#include <utility>

namespace occlude {

void Opt::record(const View& view, QueryDevice& device, std::span<const ItemId>)
{
    pass_.cull(view, device);
    recorded_structure_ = hierarchy().structure_version();
}

void Opt::cull_frame(CullFrame& frame)
{
    if (recorded_structure_ != hierarchy().structure_version()) {
        walk_.draw_all(frame); // the recorded node ids belong to an older tree
        return;
    }
    for (const DecisionLog::Entry& entry : pass_.decisions().entries()) {
        PlaneMask mask = Frustum::kAllPlanes;
        if (!is_drawn(entry.decision)) {
            frame.decide(entry.node, entry.decision);
        } else if (entry.scope == DecisionLog::Scope::own_items) {
            frame.draw_own(entry.node, mask, Decision::drawn);
        } else {
            frame.visit(entry.node, mask);
            frame.draw_leaf(entry.node, mask, Decision::drawn);
        }
    }
}

void Ideal::index_items()
{
    if (indexed_structure_ == hierarchy().structure_version()) {
        return;
    }
    indexed_structure_ = hierarchy().structure_version();
    position_of_item_.clear();
    const auto items = hierarchy().items();
    for (uint32_t i = 0; i < items.size(); ++i) {
        if (items[i].value >= position_of_item_.size()) {
            position_of_item_.resize(items[i].value + 1);
        }
        position_of_item_[items[i].value] = ItemPosition{i};
    }
}

void Ideal::record(const View& view, QueryDevice&, std::span<const ItemId> owners)
{
    index_items();
    recorded_structure_ = hierarchy().structure_version();
    std::vector<std::pair<float, ItemId>> order;
    visible_triangles_ = 0;
    const auto add = [&](ItemId item) {
        const ItemBounds& bounds = hierarchy().item_bounds(position_of_item_[item.value]);
        order.emplace_back(view.distance_key(bounds.box), item);
        visible_triangles_ += bounds.triangles;
    };
    for (const ItemId item : owners) {
        const bool known =
            item.value < position_of_item_.size() && position_of_item_[item.value].valid();
        OCCLUDE_ASSERT(known, "an owner must be an item of the hierarchy");
        if (known) {
            add(item);
        }
    }
    for (const Hierarchy::FlaggedItem& flagged : hierarchy().flagged_items()) {
        const ItemBounds& bounds = hierarchy().item_bounds(flagged.position);
        if (has_flag(bounds.flags, ItemFlags::translucent) &&
            view.frustum().classify(bounds.box) != Containment::outside) {
            add(flagged.item);
        }
    }
    std::sort(order.begin(), order.end());
    visible_.clear();
    for (const auto& [distance, item] : order) {
        visible_.push_back(item);
    }
}

void Ideal::cull_frame(CullFrame& frame)
{
    if (recorded_structure_ != hierarchy().structure_version()) {
        walk_.draw_all(frame); // the recorded item ids may belong to an older tree
        return;
    }
    frame.draw_items(visible_, visible_triangles_);
}

} // namespace occlude
