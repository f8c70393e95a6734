// The objects behind the opaque handles of the C interface.
#pragma once

#include <occlude/c/occlude.h>
#include <occlude/cull/culler.h>
#include <occlude/hierarchy/hierarchy.h>

#include <cstddef>
#include <memory>
#include <string>
#include <utility>

struct occlude_hierarchy {
    occlude_hierarchy(occlude::Hierarchy built, size_t count)
        : tree(std::move(built))
        , item_count(count)
    {
    }

    occlude::Hierarchy tree;
    size_t item_count; ///< number of items that were handed over; ids are smaller
};

struct occlude_culler {
    std::unique_ptr<occlude::Culler> culler;
    std::string plan; ///< of the last frame, in words
};
