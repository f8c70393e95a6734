#include "measure/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace occlude::tools {

static constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();

static bool any_nan(std::span<const double> values)
{
    return std::any_of(values.begin(), values.end(), [](double v) { return std::isnan(v); });
}

double percentile(std::span<const double> values, double quantile)
{
    if (values.empty() || any_nan(values)) {
        return kNotKnown;
    }
    std::vector<double> sorted{values.begin(), values.end()};
    std::sort(sorted.begin(), sorted.end());
    const double rank = std::clamp(quantile, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
    const auto below = static_cast<size_t>(rank);
    const size_t above = std::min(below + 1, sorted.size() - 1);
    const double share = rank - static_cast<double>(below);
    return sorted[below] + share * (sorted[above] - sorted[below]);
}

double median(std::span<const double> values)
{
    return percentile(values, 0.5);
}

double mean(std::span<const double> values)
{
    if (values.empty()) {
        return kNotKnown;
    }
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

Distribution distribution(std::span<const double> values)
{
    return {.median = median(values),
            .mean = mean(values),
            .p95 = percentile(values, 0.95),
            .p99 = percentile(values, 0.99),
            .max = percentile(values, 1.0),
            .total =
                values.empty() ? kNotKnown : std::accumulate(values.begin(), values.end(), 0.0)};
}

} // namespace occlude::tools
