// The traversal queue that CHC and its kin call DistanceQueue: nodes, nearest first.
#pragma once

#include <occlude/core/assert.h>
#include <occlude/core/frustum.h>
#include <occlude/core/ids.h>
#include <occlude/core/view.h>
#include <occlude/hierarchy/hierarchy.h>

#include <algorithm>
#include <vector>

namespace occlude {

class DistanceQueue {
public:
    struct Entry {
        float distance; ///< View::distance_key of the node's box
        NodeId node;
        PlaneMask mask; ///< frustum planes that it must still be tested against
    };

    bool empty() const { return heap_.empty(); }
    void clear() { heap_.clear(); }

    void push(NodeId node, float distance, PlaneMask mask)
    {
        heap_.push_back({distance, node, mask});
        std::push_heap(heap_.begin(), heap_.end(), farther);
    }

    void push_children(const Hierarchy& hierarchy, const View& view, NodeId node, PlaneMask mask)
    {
        const Node& n = hierarchy.node(node);
        for (uint32_t i = 0; i < n.child_count; ++i) {
            const NodeId child{n.first_child.value + i};
            push(child, view.distance_key(hierarchy.node(child).box), mask);
        }
    }

    /// The nearest node. Of equally near nodes it is the one with the smallest id, so that runs
    /// repeat.
    /// repeatable.
    Entry pop()
    {
        OCCLUDE_ASSERT(!empty(), "an empty queue has nothing to pop");
        std::pop_heap(heap_.begin(), heap_.end(), farther);
        const Entry entry = heap_.back();
        heap_.pop_back();
        return entry;
    }

private:
    static bool farther(const Entry& a, const Entry& b)
    {
        return a.distance != b.distance ? a.distance > b.distance : a.node > b.node;
    }

    std::vector<Entry> heap_;
};

} // namespace occlude
