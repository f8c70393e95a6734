// Every kind of tree by name: what `occlude list hierarchies` and `--hierarchy` are made of.
#pragma once

#include <occlude/hierarchy/hierarchy.h>

#include <span>
#include <string_view>

namespace occlude {

struct HierarchyKind {
    std::string_view name;
    std::string_view summary;
    /// Items that no child holds whole stay in inner nodes; else only unbounded and empty boxes do.
    bool items_in_inner_nodes = false;
    /// Builds it with its default options. Nodes of at most `leaf_triangles` triangles become
    /// virtual leaves; 0: none.
    Hierarchy (*build)(std::span<const ItemBounds> items, uint32_t leaf_triangles) = nullptr;
};

/// All kinds, the default first.
std::span<const HierarchyKind> hierarchy_kinds();

/// The kind of that name, or null.
const HierarchyKind* find_hierarchy_kind(std::string_view name);

} // namespace occlude
