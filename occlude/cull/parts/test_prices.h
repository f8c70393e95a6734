// The prices of drawing and the budget of tests, as plain numbers. Algorithms over one traversal
// (cut_traversal.h, depth_traversal.h) differ by these.
#pragma once

#include <cstdint>

namespace occlude {

/// The cost of drawing, and how deep nodes are opened.
struct CutPrices {
    /// The cost of one unit of drawing. Work is counted in triangles; an item counts as
    /// `units_per_item`.
    double us_per_unit = 1.0;
    double units_per_item = 0.0;
    /// A node that costs less to draw is drawn whole instead of opened.
    double min_open_us = 0.0;
    /// Opens nothing below the hierarchy's virtual leaves.
    bool stop_at_virtual_leaves = false;
};

/// How much a test by depth may cost, relative to the cost of drawing its subject.
struct DepthTestBudget {
    /// For `test_us`: below any cost, so that everything is tested.
    static constexpr double kAlways = -1.0;

    /// How many texels the test of a box by its faces may read per microsecond of drawing, but at
    /// most `max_texels`. If that is less than `min_texels`, the test may read `texels_below_min`.
    double texels_per_us = 0.5;
    double max_texels = 4096.0;
    double min_texels = 32.0;
    uint32_t texels_below_min = 32;
    /// The cost of the test of a box. A new entry is tested if its drawing cost, times the share of
    /// tests that find something hidden, is higher.
    double test_us = kAlways;
};

} // namespace occlude
