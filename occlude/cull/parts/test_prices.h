// What drawing and testing may cost, as plain numbers: the difference between algorithms over one
// traversal (cut_traversal.h, depth_traversal.h).
#pragma once

#include <cstdint>

namespace occlude {

/// What drawing costs, and how deep nodes are opened.
struct CutPrices {
    /// Of one unit of drawing. Work is counted in triangles; an item counts as `units_per_item`.
    double us_per_unit = 1.0;
    double units_per_item = 0.0;
    /// A node that costs less to draw is drawn whole instead of opened.
    double min_open_us = 0.0;
    /// Opens nothing below the hierarchy's virtual leaves.
    bool stop_at_virtual_leaves = false;
};

/// How much a test by depth may cost, given what its subject costs to draw.
struct DepthTestBudget {
    /// Below any cost: everything is tested.
    static constexpr double kAlways = -1.0;

    /// The test of a box by its faces may look at this many texels per microsecond of drawing, but
    /// at most at `max_texels`. Where that comes to less than `min_texels`, it may look at
    /// `texels_below_min`.
    double texels_per_us = 0.5;
    double max_texels = 4096.0;
    double min_texels = 32.0;
    uint32_t texels_below_min = 32;
    /// What the test of a box costs. A new entry is tested if the share of tests that find
    /// something hidden, times the cost of drawing the entry, is more.
    double test_us = kAlways;
};

} // namespace occlude
