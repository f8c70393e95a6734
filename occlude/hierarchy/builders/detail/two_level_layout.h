// The hierarchy of a two-level tree: laid out from its scene BSP, and refitted with it. Internal;
// two_level.h says what it implements.
#pragma once

#include <occlude/hierarchy/builders/detail/scene_bsp.h>
#include <occlude/hierarchy/hierarchy.h>

#include <vector>

namespace occlude::detail {

class TwoLevelLayout {
public:
    explicit TwoLevelLayout(const TwoLevelOptions& options)
        : options_(options)
    {
    }

    const Hierarchy& hierarchy() const { return hierarchy_; }
    /// `shapes` must outlive this object; later layouts keep it.
    void set_shapes(const ItemShapes* shapes) { hierarchy_.set_shapes(shapes); }

    /// Lays out a new array of nodes. O(items + nodes).
    void lay_out(const SceneBsp& bsp, std::span<const ItemBounds> bounds_by_item);
    /// Refits the existing nodes to the new bounds of what moved.
    void refit(const SceneBsp& bsp, std::span<const ItemBounds> bounds_by_item);

private:
    struct Arrays;

    static void emit_cell(Arrays& arrays, const SceneBsp& bsp, uint32_t cell, uint32_t at);
    static void emit_local(Arrays& arrays, const SceneBsp::Object& object, SceneBsp::Slot slot,
                           uint32_t local, uint32_t at);
    void set_object_nodes(const SceneBsp& bsp, ObjectNodes nodes);
    void refit_moved(const SceneBsp& bsp, std::span<const ItemBounds> bounds_by_item);
    bool oriented_as_before(const SceneBsp& bsp) const;
    Aabb test_box(const SceneBsp& bsp, const ObjectNodes& nodes, size_t node) const;
    Aabb cell_test_box(const SceneBsp& bsp, const SceneBsp::Cell& cell, const Aabb& tight) const;

    TwoLevelOptions options_;
    Hierarchy hierarchy_;
    std::vector<uint32_t> cell_of_;   ///< per node: its cell of the scene BSP, or kNone ...
    std::vector<uint32_t> local_of_;  ///< ... or its node in the local tree
    std::vector<uint32_t> object_of_; ///< ... of this object
    uint64_t lineage_ = 0;
    std::vector<ItemId> moved_items_; ///< scratch
    std::vector<NodeId> changed_;     ///< scratch
};

} // namespace occlude::detail
