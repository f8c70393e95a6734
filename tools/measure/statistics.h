// The figures that summarise a list of measurements.
#pragma once

#include <span>
#include <vector>

namespace occlude::tools {

/// The value below which the share `quantile` (0 to 1) of the values lies, interpolated linearly
/// between the two nearest ranks. NaN for no values, or if one of them is NaN. O(n log n).
double percentile(std::span<const double> values, double quantile);

/// percentile(values, 0.5): the middle value, or the mean of the two middle ones.
double median(std::span<const double> values);

/// NaN for no values.
double mean(std::span<const double> values);

struct Distribution {
    double median = 0.0;
    double mean = 0.0;
    double p95 = 0.0;
    double p99 = 0.0;
    double max = 0.0;
    double total = 0.0;
};
Distribution distribution(std::span<const double> values);

} // namespace occlude::tools
