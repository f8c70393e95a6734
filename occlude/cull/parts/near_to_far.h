// Children of a node, nearest first: the order of all depth-first traversals.
#pragma once

#include <occlude/core/view.h>
#include <occlude/hierarchy/hierarchy.h>

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

namespace occlude {

/// Calls push(child) for the children of `node` from the farthest to the nearest, so that a stack
/// pops them near to far. The caller keeps `scratch`, to avoid allocations.
template <class Push>
void push_far_to_near(const Hierarchy& hierarchy, const View& view, NodeId node,
                      std::vector<std::pair<float, NodeId>>& scratch, Push&& push)
{
    const Node& n = hierarchy.node(node);
    scratch.clear();
    for (uint32_t i = 0; i < n.child_count; ++i) {
        const NodeId child{n.first_child.value + i};
        scratch.emplace_back(view.distance_key(hierarchy.node(child).box), child);
    }
    std::sort(scratch.begin(), scratch.end(), std::greater<>{});
    for (const auto& [distance, child] : scratch) {
        push(child);
    }
}

} // namespace occlude
