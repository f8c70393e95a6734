// Nodes of a two-level tree that are tested with a larger box than that of their contents.
#pragma once

#include <occlude/hierarchy/hierarchy.h>

#include <cstddef>

namespace occlude::test {

/// Nodes of a two-level tree whose test box is larger than the box of their contents. Where no
/// object is turned, these are the restless nodes.
inline size_t loose_boxes(const Hierarchy& tree)
{
    size_t count = 0;
    for (size_t i = 0; i < tree.nodes().size(); ++i) {
        count += tree.object_nodes().box[i] != tree.nodes()[i].box ? 1 : 0;
    }
    return count;
}

} // namespace occlude::test
