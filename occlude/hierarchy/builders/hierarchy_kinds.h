// Every kind of tree by name: the source of `occlude list hierarchies` and `--hierarchy`.
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
    /// True: inner nodes keep the items that no child holds whole. False: only unbounded and empty
    /// boxes stay in inner nodes.
    bool items_in_inner_nodes = false;
    /// Builds a tree with the default options. Nodes with at most `leaf_triangles` triangles become
    /// virtual leaves; 0: none do.
    Hierarchy (*build)(std::span<const ItemBounds> items, uint32_t leaf_triangles) = nullptr;
    /// Its options with their defaults.
    std::vector<OptionInfo> (*options)() = nullptr;
    /// Builds a tree with these options. An error names the unknown option and lists the known
    /// ones.
    Result<Hierarchy> (*build_with)(std::span<const ItemBounds> items, uint32_t leaf_triangles,
                                    std::span<const OptionValue> options) = nullptr;
};

/// All kinds, the default first.
std::span<const HierarchyKind> hierarchy_kinds();

/// The kind of that name, or null.
const HierarchyKind* find_hierarchy_kind(std::string_view name);

/// The options of a two-level tree that follows a scene (TwoLevelScene), set by name as by
/// build_with().
Result<TwoLevelOptions> two_level_options(uint32_t leaf_triangles,
                                          std::span<const OptionValue> options);

} // namespace occlude
