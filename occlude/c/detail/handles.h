// The objects behind the opaque handles of the C interface.
#pragma once

#include <occlude/c/occlude.h>
#include <occlude/cull/culler.h>
#include <occlude/hierarchy/hierarchy.h>
#include <occlude/hierarchy/item_shapes.h>

#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

struct occlude_hierarchy {
    occlude_hierarchy(occlude::Hierarchy built, size_t count)
        : tree(std::move(built))
        , item_count(count)
    {
        tree.set_shapes(&shapes);
    }
    occlude_hierarchy(const occlude_hierarchy&) = delete; // the tree points at the shapes
    occlude_hierarchy& operator=(const occlude_hierarchy&) = delete;

    occlude::Hierarchy tree;
    occlude::ItemShapes shapes;
    size_t item_count; ///< number of items that were handed over; ids are smaller
};

struct occlude_shape {
    std::shared_ptr<const occlude::Shape> boxes; ///< not null
    std::vector<occlude_box> boxes_in_c;         ///< the same ones
};

struct occlude_culler {
    std::unique_ptr<occlude::Culler> culler;
    std::string plan; ///< of the last frame, in words
};
