// Objects that a file holds twice.
#pragma once

#include "load/loaded_scene.h"
#include "model/scene_model.h"

#include <span>
#include <vector>

namespace occlude::tools {

struct Duplicates {
    /// By instance: an earlier one has an equal mesh, place and colour, and both are opaque. One
    /// never sees the later one: where depths are equal, what is drawn first stays.
    std::vector<bool> unseen;
    uint64_t unseen_count = 0;
    uint64_t other_color_count = 0; ///< equal mesh and place, but another colour or not opaque
};

/// `placed[i]` is what `model.instances[i]` was made of: its place in double. O(n + vertices).
Duplicates find_duplicates(const SceneModel& model, std::span<const LoadedInstance* const> placed);

} // namespace occlude::tools
