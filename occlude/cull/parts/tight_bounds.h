// Several small boxes in place of a large one: the descendants of a node as its tight bounds.
//
// Implements  ShaderX7 8.4, "Tighter bounding volumes"; the same idea as the pyramid's two boxes of
//             GPU Gems 29.5.1, with the hierarchy's own boxes.
#pragma once

#include <occlude/core/ids.h>
#include <occlude/hierarchy/hierarchy.h>

#include <cstdint>
#include <span>
#include <vector>

namespace occlude {

class TightBounds {
public:
    /// Nodes whose boxes together bound everything in the subtree of `node`: the node itself, or
    /// descendants at most `depth` levels below it whose boxes have at most `area` times its
    /// surface area. Valid until the next call. O(nodes returned).
    std::span<const NodeId> collect(const Hierarchy& hierarchy, NodeId node, uint32_t depth,
                                    float area);

private:
    std::vector<NodeId> tight_;
    std::vector<NodeId> next_;
};

} // namespace occlude
