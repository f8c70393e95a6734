// Every kind of tree by name: what `occlude list hierarchies` and `--hierarchy` are made of.
#pragma once

#include <occlude/core/option_text.h>
#include <occlude/core/result.h>
#include <occlude/hierarchy/builders/two_level.h>
#include <occlude/hierarchy/hierarchy.h>

#include <span>
#include <string_view>
#include <vector>

namespace occlude {

struct HierarchyKind {
    std::string_view name;
    std::string_view summary;
    /// Items that no child holds whole stay in inner nodes; else only unbounded and empty boxes do.
    bool items_in_inner_nodes = false;
    /// Builds it with its default options. Nodes of at most `leaf_triangles` triangles become
    /// virtual leaves; 0: none.
    Hierarchy (*build)(std::span<const ItemBounds> items, uint32_t leaf_triangles) = nullptr;
    /// Its options with their defaults.
    std::vector<OptionInfo> (*options)() = nullptr;
    /// build(), and then with these options. Errors name the unknown option and what there is.
    Result<Hierarchy> (*build_with)(std::span<const ItemBounds> items, uint32_t leaf_triangles,
                                    std::span<const OptionValue> options) = nullptr;
};

/// All kinds, the default first.
std::span<const HierarchyKind> hierarchy_kinds();

/// The kind of that name, or null.
const HierarchyKind* find_hierarchy_kind(std::string_view name);

/// The options of a two-level tree that follows a scene (TwoLevelScene), as build_with() would set
/// them.
Result<TwoLevelOptions> two_level_options(uint32_t leaf_triangles,
                                          std::span<const OptionValue> options);

} // namespace occlude
