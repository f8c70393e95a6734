#include <occlude/c/detail/guard.h>
#include <occlude/c/detail/handles.h>

#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include <memory>

namespace occlude::c {

namespace {

ItemBounds bounds_from(const occlude_item& item)
{
    return {{{item.min[0], item.min[1], item.min[2]}, {item.max[0], item.max[1], item.max[2]}},
            item.triangles,
            static_cast<ItemFlags>(item.flags & 0x0fu)};
}

Result<std::vector<ItemBounds>> all_bounds_from(const occlude_item* items, size_t count)
{
    if (count > 0 && items == nullptr) {
        return Error{ErrorCode::invalid_argument,
                     "items is null, but item_count is " + std::to_string(count)};
    }
    if (count >= ItemId::kInvalid) {
        return Error{ErrorCode::invalid_argument, std::to_string(count) + " items are too many"};
    }
    std::vector<ItemBounds> bounds;
    bounds.reserve(count);
    for (size_t i = 0; i < count; ++i) {
        bounds.push_back(bounds_from(items[i]));
    }
    return bounds;
}

/// The bounds of a refit; an error if their number differs from the number of items.
Result<std::vector<ItemBounds>> refit_bounds(const occlude_hierarchy* hierarchy,
                                             const occlude_item* items, size_t count)
{
    if (hierarchy == nullptr) {
        return Error{ErrorCode::invalid_argument, "hierarchy is null"};
    }
    if (count != hierarchy->item_count) {
        return Error{ErrorCode::invalid_argument,
                     "item_count is " + std::to_string(count) + ", but the hierarchy was made of " +
                         std::to_string(hierarchy->item_count) + " items"};
    }
    return all_bounds_from(items, count);
}

} // namespace

} // namespace occlude::c

using namespace occlude;

extern "C" {

occlude_status occlude_hierarchy_create(const char* kind, const occlude_item* items,
                                        size_t item_count, uint32_t leaf_triangles,
                                        const occlude_option* options, size_t option_count,
                                        occlude_hierarchy** hierarchy)
{
    return c::guarded([&] {
        if (kind == nullptr || hierarchy == nullptr) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT, "kind or hierarchy is null");
        }
        const HierarchyKind* found = find_hierarchy_kind(kind);
        if (found == nullptr) {
            std::string names;
            for (const HierarchyKind& known : hierarchy_kinds()) {
                names += (names.empty() ? "" : ", ") + std::string{known.name};
            }
            return c::fail(OCCLUDE_NOT_FOUND, "there is no kind of hierarchy '" +
                                                  std::string{kind} + "'; there are " + names);
        }
        const auto bounds = c::all_bounds_from(items, item_count);
        if (!bounds) {
            return c::fail(bounds.error());
        }
        const auto values = c::options_from(options, option_count);
        if (!values) {
            return c::fail(values.error());
        }
        auto built = found->build_with(*bounds, leaf_triangles, *values);
        if (!built) {
            return c::fail(built.error());
        }
        *hierarchy = std::make_unique<occlude_hierarchy>(std::move(*built), item_count).release();
        return OCCLUDE_OK;
    });
}

void occlude_hierarchy_destroy(occlude_hierarchy* hierarchy)
{
    delete hierarchy;
}

occlude_status occlude_hierarchy_refit(occlude_hierarchy* hierarchy, const occlude_item* items,
                                       size_t item_count)
{
    return c::guarded([&] {
        const auto bounds = c::refit_bounds(hierarchy, items, item_count);
        if (!bounds) {
            return c::fail(bounds.error());
        }
        hierarchy->tree.refit(*bounds);
        return OCCLUDE_OK;
    });
}

occlude_status occlude_hierarchy_refit_moved(occlude_hierarchy* hierarchy, const uint32_t* moved,
                                             size_t moved_count, const occlude_item* items,
                                             size_t item_count)
{
    return c::guarded([&] {
        const auto bounds = c::refit_bounds(hierarchy, items, item_count);
        if (!bounds) {
            return c::fail(bounds.error());
        }
        if (moved_count > 0 && moved == nullptr) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT,
                           "moved is null, but moved_count is " + std::to_string(moved_count));
        }
        std::vector<ItemId> ids;
        ids.reserve(moved_count);
        for (size_t i = 0; i < moved_count; ++i) {
            if (moved[i] >= item_count) {
                return c::fail(OCCLUDE_INVALID_ARGUMENT,
                               "moved[" + std::to_string(i) + "] is item " +
                                   std::to_string(moved[i]) + ", but there are " +
                                   std::to_string(item_count) + " items");
            }
            ids.push_back(ItemId{moved[i]});
        }
        hierarchy->tree.refit(ids, *bounds);
        return OCCLUDE_OK;
    });
}

size_t occlude_hierarchy_node_count(const occlude_hierarchy* hierarchy)
{
    return hierarchy != nullptr ? hierarchy->tree.nodes().size() : 0;
}

size_t occlude_hierarchy_item_count(const occlude_hierarchy* hierarchy)
{
    return hierarchy != nullptr ? hierarchy->item_count : 0;
}

size_t occlude_hierarchy_memory_bytes(const occlude_hierarchy* hierarchy)
{
    return hierarchy != nullptr ? hierarchy->tree.memory_bytes() : 0;
}

} // extern "C"
