// Cost models for tests of the planner of `adaptive`, made from a few prices.
#pragma once

#include <occlude/cull/adaptive/planner.h>

namespace occlude::test::planner {

struct Prices {
    float us_per_triangle = 1.0f;
    float query_us = 1.0f;
    float flag_us = 0.0f; ///< 0: the device has no flags
    bool reads_depth = false;
    bool same_frame_results = true;
};

// A round of either method of the device costs 10 us.
inline CostModel costs_of(const Prices& prices)
{
    DeviceCaps caps;
    caps.us_per_triangle = prices.us_per_triangle;
    caps.us_per_item = 0.0f;
    caps.read_depth = prices.reads_depth;
    caps.same_frame_results = prices.same_frame_results;
    caps.methods = {{TestMethod::queries, 10.0f, prices.query_us, 0.0f}};
    if (prices.flag_us > 0.0f) {
        caps.methods.push_back({TestMethod::raster, 10.0f, prices.flag_us, 0.0f});
    }
    CostModel costs;
    costs.take_hints(caps);
    return costs;
}

constexpr AdaptivePlanner::Start kKnown{.cut_is_empty = false};
constexpr AdaptivePlanner::Start kNothingKnown{.cut_is_empty = true};

} // namespace occlude::test::planner
