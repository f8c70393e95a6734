// What the parts of `adaptive` share: numbers, decisions, and the cut.
#pragma once

#include <occlude/cull/adaptive/cost_meter.h>
#include <occlude/cull/adaptive/planner.h>
#include <occlude/cull/parts/cut_traversal.h>
#include <occlude/cull/parts/depth_traversal.h>

#include <utility>

namespace occlude {

struct AdaptiveShared {
    AdaptiveShared(const Hierarchy& hierarchy, const AdaptiveOptions& options, SecondsClock clock)
        : meter(std::move(clock))
        , planner(options)
        , cut(hierarchy)
        , depth(cut, DepthTests{}, options.shapes, kPlannerConstants.shape_test_us)
    {
    }
    AdaptiveShared(const AdaptiveShared&) = delete; // `depth` refers to `cut`
    AdaptiveShared& operator=(const AdaptiveShared&) = delete;

    CostMeter meter;
    AdaptivePlanner planner;
    CutTraversal cut;
    DepthTraversal depth;

    const CostModel& costs() const { return meter.costs(); }

    /// Hands the measured costs to the traversals.
    void update_prices()
    {
        cut.set_prices(planner.cut_prices(costs()));
        depth.set_budget(planner.depth_budget(costs()));
    }

    /// The work that the frame has drawn so far, in units.
    double drawn_units(const CullFrame& frame) const
    {
        return costs().units(frame.counters().triangles_drawn, frame.counters().items_drawn);
    }
    /// The box of an entry as a test on the device must see it: inflated (rule R2).
    Aabb test_box(const CullFrame& frame, const HierarchyCut::Entry& entry) const
    {
        return frame.view().inflated_for_test(cut.box_of(entry));
    }
    /// Rule R1: if the near plane may touch that box, it must not be tested (C5).
    bool touches_near(const CullFrame& frame, const HierarchyCut::Entry& entry) const
    {
        return frame.view().touches_near(test_box(frame, entry));
    }
};

} // namespace occlude
