#include <occlude/hierarchy/hierarchy_kinds.h>

#include <occlude/hierarchy/bsp_builder.h>
#include <occlude/hierarchy/bvh_builder.h>
#include <occlude/hierarchy/grid_builder.h>
#include <occlude/hierarchy/octree_builder.h>
#include <occlude/hierarchy/two_level.h>

#include <array>

namespace occlude {

static constexpr std::array kKinds{
    HierarchyKind{"bvh", "bounding volume hierarchy, binned surface area heuristic", false,
                  [](std::span<const ItemBounds> items, uint32_t leaf_triangles) {
                      return build_bvh(items, {.leaf_triangles = leaf_triangles});
                  }},
    HierarchyKind{"bsp", "axis-aligned planes; what straddles a plane stays in the inner node",
                  true,
                  [](std::span<const ItemBounds> items, uint32_t leaf_triangles) {
                      return build_bsp(items, {.leaf_triangles = leaf_triangles});
                  }},
    HierarchyKind{"octree", "cubes halved along all axes; an item is where its centre is", false,
                  [](std::span<const ItemBounds> items, uint32_t leaf_triangles) {
                      return build_octree(items, {.leaf_triangles = leaf_triangles});
                  }},
    HierarchyKind{"grid", "a grid of cells, each a grid again where it holds more than one item",
                  false,
                  [](std::span<const ItemBounds> items, uint32_t leaf_triangles) {
                      return build_grid(items, {.leaf_triangles = leaf_triangles});
                  }},
    HierarchyKind{"two_level",
                  "a bsp of objects, with a bsp of its parts below each; they may move", true,
                  [](std::span<const ItemBounds> items, uint32_t leaf_triangles) {
                      return build_two_level(items, {.leaf_triangles = leaf_triangles});
                  }},
};

std::span<const HierarchyKind> hierarchy_kinds()
{
    return kKinds;
}

const HierarchyKind* find_hierarchy_kind(std::string_view name)
{
    for (const HierarchyKind& kind : kKinds) {
        if (kind.name == name) {
            return &kind;
        }
    }
    return nullptr;
}

} // namespace occlude
