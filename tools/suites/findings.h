// What the results of a suite say about a published figure: ours, whether it is reached, and if
// not, what the counters say about why.
#pragma once

#include "suites/suite_results.h"

#include <limits>
#include <string>
#include <string_view>

namespace occlude::tools {

/// From where to where a figure counts as reached. NaN: no such limit.
struct Target {
    double at_least = std::numeric_limits<double>::quiet_NaN();
    double at_most = std::numeric_limits<double>::quiet_NaN();

    /// True if there is anything to reach.
    bool judges() const;
    bool reached_by(double value) const;
};

/// Our side of a row of the report.
struct Finding {
    double value = std::numeric_limits<double>::quiet_NaN(); ///< NaN: not measured
    std::string ours;     ///< the value as it is shown, with what it is made of
    std::string counters; ///< the same ratio in counters, which do not depend on the machine
    std::string why;      ///< plain sentences; empty where there is nothing to explain
};

/// frame_ms of `slow` over frame_ms of `fast`, means over the walk.
Finding time_ratio(const EntryResult& entry, std::string_view slow, std::string_view fast,
                   const Target& target);

/// A counter per frame of `more` over that of `less`: "queries", "triangles_drawn", ...
Finding counter_ratio(const EntryResult& entry, std::string_view counter, std::string_view more,
                      std::string_view less, const Target& target);

/// The share of a run's time that goes into one of its parts: "wait_ms", "read_ms", "cull_cpu_ms".
Finding time_share(const EntryResult& entry, std::string_view part, std::string_view run);

/// What one test of `run` costs, as the number of triangles that `frustum` draws in the same time.
Finding test_cost_in_triangles(const EntryResult& entry, std::string_view run);

/// "12,345", "3.21", "0.0042": as many digits as tell something.
std::string readable(double value);

} // namespace occlude::tools
