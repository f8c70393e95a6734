// The options of `adaptive` (cull/adaptive.h), which its planner reads.
#pragma once

#include <cstdint>

namespace occlude {

struct AdaptiveOptions {
    /// How tests are made. `automatic` chooses the method with the lowest measured cost; the others
    /// are for comparisons.
    enum class Method : uint8_t { automatic, draw_all, queries, raster, pyramid };
    Method method = Method::automatic;
    /// The share of the time that probes may take while everything is drawn, 0 to 1.
    float probe_share = 0.005f;
    /// If tests hide less than this many times their own cost, the culler draws the whole view
    /// instead.
    float keep_margin = 1.2f;
    /// Testing starts again only if a probe promises at least this many times its cost.
    float start_margin = 1.5f;
    /// Measure costs by the clock. If false, costs stay at the device's hints, and runs repeat.
    bool measure = true;
    uint64_t seed = 1; ///< of the random choice of nodes that the cut merges
    /// Test the shape of an item (item_shapes.h) if its box is not hidden and the test may pay.
    bool shapes = true;
};

} // namespace occlude
