// The options of `adaptive` (cull/adaptive.h), which its planner reads.
#pragma once

#include <cstdint>

namespace occlude {

struct AdaptiveOptions {
    /// How tests are made. `automatic` chooses the cheapest way; the others are for comparisons.
    enum class Method : uint8_t { automatic, draw_all, queries, raster, pyramid };
    Method method = Method::automatic;
    /// The share of the time that probes may take while everything is drawn.
    float probe_share = 0.005f;
    /// Tests must hide at least this many times their own cost, or the view is drawn whole.
    float keep_margin = 1.2f;
    /// A probe must promise at least this many times its cost, or the view stays drawn whole.
    float start_margin = 1.5f;
    /// Measure costs by the clock. Otherwise they stay what the device's hints say, and runs
    /// repeat.
    bool measure = true;
    uint64_t seed = 1; ///< of the choice of nodes that may become one entry of the cut again
    /// Test the shapes of items (item_shapes.h) where their boxes are not hidden and that may pay.
    bool shapes = true;
};

} // namespace occlude
