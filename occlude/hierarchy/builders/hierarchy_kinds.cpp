#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include <occlude/hierarchy/builders/bsp_builder.h>
#include <occlude/hierarchy/builders/bvh_builder.h>
#include <occlude/hierarchy/builders/grid_builder.h>
#include <occlude/hierarchy/builders/octree_builder.h>
#include <occlude/hierarchy/builders/two_level.h>

#include <array>
#include <string>
#include <utility>

namespace occlude {

namespace {

template <class Options>
Result<Options> options_of(uint32_t leaf_triangles, std::span<const OptionValue> values)
{
    Options options;
    options.leaf_triangles = leaf_triangles;
    if (std::string problem = apply_options(options, values); !problem.empty()) {
        return Error{ErrorCode::invalid_argument, std::move(problem)};
    }
    return options;
}

template <class Options, Hierarchy (*kBuild)(std::span<const ItemBounds>, const Options&)>
constexpr HierarchyKind describe(std::string_view name, std::string_view summary,
                                 bool items_in_inner_nodes)
{
    return {name,
            summary,
            items_in_inner_nodes,
            [](std::span<const ItemBounds> items, uint32_t leaf_triangles) {
                return kBuild(items, *options_of<Options>(leaf_triangles, {}));
            },
            &describe_options<Options>,
            [](std::span<const ItemBounds> items, uint32_t leaf_triangles,
               std::span<const OptionValue> values) -> Result<Hierarchy> {
                const auto options = options_of<Options>(leaf_triangles, values);
                if (!options) {
                    return options.error();
                }
                return kBuild(items, *options);
            }};
}

constexpr std::array kKinds{
    describe<BvhOptions, build_bvh>(
        "bvh", "bounding volume hierarchy, binned surface area heuristic", false),
    describe<BspOptions, build_bsp>(
        "bsp", "axis-aligned BSP tree; items that straddle a plane stay in the inner node", true),
    describe<OctreeOptions, build_octree>(
        "octree", "cubes halved along all axes; an item is in the cube of its centre", false),
    describe<GridOptions, build_grid>(
        "grid", "a grid of cells; a cell with more than one item holds a nested grid", false),
    describe<TwoLevelOptions, build_two_level>(
        "two_level", "a BSP of objects, and below each a BSP of its parts; objects may move", true),
};

} // namespace

Result<TwoLevelOptions> two_level_options(uint32_t leaf_triangles,
                                          std::span<const OptionValue> options)
{
    return options_of<TwoLevelOptions>(leaf_triangles, options);
}

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
