#include <occlude/cull/parts/tight_bounds.h>

#include <occlude/core/assert.h>

#include <utility>

namespace occlude {

// Replaces a node by its descendants, up to `depth` levels down, while their boxes together have at
// most `area` times its surface area.
std::span<const NodeId> TightBounds::collect(const Hierarchy& hierarchy, NodeId node,
                                             uint32_t depth, float area)
{
    const auto nodes = hierarchy.nodes();
    OCCLUDE_ASSERT(node.value < nodes.size(), "the node belongs to another tree");
    const float largest_area = area * surface_area(nodes[node.value].box);
    tight_.assign(1, node);
    for (uint32_t level = 0; level < depth; ++level) {
        next_.clear();
        float next_area = 0.0f;
        for (const NodeId id : tight_) {
            const Node& n = nodes[id.value];
            // A node with own items is more than the union of its children.
            const bool opened = n.child_count > 0 && n.own_items == 0;
            const uint32_t first = opened ? n.first_child.value : id.value;
            const uint32_t count = opened ? n.child_count : 1;
            for (uint32_t i = first; i < first + count; ++i) {
                if (!nodes[i].box.is_empty()) {
                    next_.push_back(NodeId{i});
                    next_area += surface_area(nodes[i].box);
                }
            }
        }
        if (next_area > largest_area || next_.size() == tight_.size()) {
            break;
        }
        std::swap(tight_, next_);
    }
    return tight_;
}

} // namespace occlude
