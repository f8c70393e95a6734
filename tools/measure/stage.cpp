#include "measure/stage.h"

#include <occlude/cull/oracle_cullers.h>
#include <occlude/cull/parts/back_to_front.h>
#include <occlude/cull/registry.h>

#include <algorithm>

namespace occlude::tools {

Result<std::vector<std::unique_ptr<Culler>>> make_cullers(const Stage& stage,
                                                          std::span<const Contender> contenders)
{
    std::vector<std::unique_ptr<Culler>> cullers;
    for (const Contender& contender : contenders) {
        auto culler = contender.make(contender.tree != nullptr ? *contender.tree : stage.hierarchy);
        if (!culler) {
            return culler.error();
        }
        cullers.push_back(std::move(*culler));
    }
    return cullers;
}

std::vector<ItemId> items_in_frustum(const View& view, std::span<const ItemBounds> item_bounds)
{
    std::vector<ItemId> items;
    for (size_t i = 0; i < item_bounds.size(); ++i) {
        const bool always =
            has_flag(item_bounds[i].flags, ItemFlags::never_cull) && !item_bounds[i].box.is_empty();
        if (always || view.frustum().classify(item_bounds[i].box) != Containment::outside) {
            items.emplace_back(i);
        }
    }
    return items;
}

std::vector<ItemId> in_draw_order(const View& view, std::span<const ItemBounds> item_bounds,
                                  std::span<const ItemId> items)
{
    std::vector<ItemId> ordered;
    std::vector<TranslucentItem> translucent;
    for (const ItemId item : items) {
        const ItemBounds& bounds = item_bounds[item.value];
        if (has_flag(bounds.flags, ItemFlags::translucent)) {
            translucent.push_back({view.distance_key(bounds.box), item, bounds.triangles});
        } else {
            ordered.push_back(item);
        }
    }
    std::sort(translucent.begin(), translucent.end(), blended_before);
    for (const TranslucentItem& blended : translucent) {
        ordered.push_back(blended.item);
    }
    return ordered;
}

std::vector<ItemId> owners_of_pixels(std::span<const uint32_t> ids)
{
    std::vector<uint32_t> sorted{ids.begin(), ids.end()};
    // Neighbours mostly have the same owner, so that little remains to be sorted.
    sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
    std::sort(sorted.begin(), sorted.end());
    sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
    if (!sorted.empty() && !ItemId{sorted.back()}.valid()) {
        sorted.pop_back(); // no item owns these pixels
    }
    std::vector<ItemId> owners;
    owners.reserve(sorted.size());
    for (const uint32_t id : sorted) {
        owners.emplace_back(id);
    }
    return owners;
}

bool needs_answer(const Culler& culler)
{
    return dynamic_cast<const OracleCuller*>(&culler) != nullptr;
}

void record_answer(Culler& culler, const View& view, QueryDevice& device,
                   std::span<const ItemId> owners)
{
    if (auto* oracle = dynamic_cast<OracleCuller*>(&culler)) {
        oracle->record(view, device, owners);
    }
}

} // namespace occlude::tools
