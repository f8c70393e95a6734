// The result of a suite for a published figure: our value, whether it is reached, and, if not, the
// reason by the counters.
#pragma once

#include "suites/suite_results.h"

#include <limits>
#include <string>
#include <string_view>

namespace occlude::tools {

/// The limits between which a figure counts as reached. NaN: no such limit.
struct Target {
    double at_least = std::numeric_limits<double>::quiet_NaN();
    double at_most = std::numeric_limits<double>::quiet_NaN();

    /// True if there is a limit.
    bool judges() const;
    bool reached_by(double value) const;
};

/// Our side of a row of the report.
struct Finding {
    double value = std::numeric_limits<double>::quiet_NaN(); ///< NaN: not measured
    std::string ours;     ///< the value as text, with the numbers that it is computed from
    std::string counters; ///< the same ratio in counters, which do not depend on the machine
    std::string why;      ///< plain sentences; empty if there is nothing to explain
};

/// frame_ms of `slow` over frame_ms of `fast`, means over the walk.
Finding time_ratio(const EntryResult& entry, std::string_view slow, std::string_view fast,
                   const Target& target);

/// A counter per frame of `more` over the same counter of `less`: "queries", "triangles_drawn", ...
Finding counter_ratio(const EntryResult& entry, std::string_view counter, std::string_view more,
                      std::string_view less, const Target& target);

/// The share of a run's time in one of its parts: "wait_ms", "read_ms", "cull_cpu_ms".
Finding time_share(const EntryResult& entry, std::string_view part, std::string_view run);

/// The cost of one test of `run`, as the number of triangles that `frustum` draws in the same time.
Finding test_cost_in_triangles(const EntryResult& entry, std::string_view run);

/// "12,345", "3.21", "0.0042": only significant digits.
std::string readable(double value);

} // namespace occlude::tools
