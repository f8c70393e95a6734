// Access for tests to the inside of a culler. Cullers declare it a friend.
#pragma once

#include <occlude/cull/adaptive.h>
#include <occlude/cull/chc.h>
#include <occlude/cull/chc_plus_plus.h>
#include <occlude/cull/lazy_grid.h>
#include <occlude/cull/statistical.h>
#include <occlude/cull/two_level.h>
#include <occlude/cull/two_phase.h>

#include <algorithm>

namespace occlude {

class CullerProbe {
public:
    /// True if the last frame found the node visible.
    static bool visible(const Chc& culler, NodeId node) { return found_visible(culler, node); }
    static bool visible(const ChcPlusPlus& culler, NodeId node)
    {
        return found_visible(culler, node);
    }
    /// True if the last frame found part of the node visible, so that the next frame draws it
    /// first. O(entries of the cut).
    static bool visible(const TwoPhase& culler, NodeId node)
    {
        const Node& n = culler.hierarchy().node(node);
        return std::ranges::any_of(cut(culler).entries(), [&](const HierarchyCut::Entry& entry) {
            const uint32_t first = entry.is_item() ? entry.place.value
                                                   : culler.hierarchy().node(entry.node).first_item;
            return entry.state == HierarchyCut::State::visible && first >= n.first_item &&
                   first < n.first_item + n.subtree_items;
        });
    }

    /// True if no queue holds anything, as after every frame (I2).
    static bool idle(const ChcPlusPlus& culler)
    {
        return culler.distance_queue_.empty() && culler.query_queue_.empty() &&
               culler.i_queue_.empty() && culler.v_queue_.empty();
    }
    static bool idle(const TwoLevel& culler)
    {
        return culler.fresh_.empty() && culler.waiting_.empty() && culler.deferred_.empty() &&
               culler.parts_.empty() && culler.pending_.empty();
    }

    static const HierarchyCut& cut(const Adaptive& culler) { return culler.shared_.cut.cut(); }
    static const HierarchyCut& cut(const TwoPhase& culler) { return culler.cut_.cut(); }
    static const CostModel& costs(const Adaptive& culler) { return culler.shared_.costs(); }

    /// The cells as the last frame left them.
    static const OcclusionGrid& grid(const LazyGrid& culler) { return culler.grid_; }

    static double pause(const Statistical& culler, NodeId node, uint32_t visible_results)
    {
        return culler.pause(node, visible_results);
    }

private:
    template <class CullerType>
    static bool found_visible(const CullerType& culler, NodeId node)
    {
        return node.value < culler.states_.size() && culler.states_[node.value].visible;
    }
};

} // namespace occlude
