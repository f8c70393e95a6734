#include <occlude/cull/chc_plus_plus_math.h>

#include <algorithm>
#include <cmath>

namespace occlude {

double analytic_keep_probability(uint32_t frames_hidden)
{
    return 0.99 - 0.7 * std::exp(-static_cast<double>(frames_hidden));
}

double multiquery_value(size_t count, double all_keep)
{
    if (count <= 1) {
        return 1.0;
    }
    const double benefit = static_cast<double>(count);
    const double cost = 1.0 + (1.0 - all_keep) * benefit;
    return benefit / cost;
}

size_t best_multiquery_size(std::span<const double> keep)
{
    size_t count = 1;
    double all_keep = keep[0];
    double value = multiquery_value(1, all_keep);
    while (count < keep.size()) {
        const double next_keep = all_keep * keep[count];
        const double next_value = multiquery_value(count + 1, next_keep);
        if (next_value <= value) {
            break;
        }
        all_keep = next_keep;
        value = next_value;
        ++count;
    }
    return count;
}

void KeepTable::record(uint32_t frames_hidden, bool kept)
{
    Bin& bin = bins_[std::min<size_t>(frames_hidden, kBins - 1)];
    ++bin.all;
    bin.kept += kept ? 1 : 0;
    if (bin.all >= kMostTests) {
        bin.all /= 2;
        bin.kept /= 2;
    }
}

double KeepTable::keep_probability(uint32_t frames_hidden) const
{
    for (size_t i = std::min<size_t>(frames_hidden, kBins - 1) + 1; i-- > 0;) {
        const Bin& bin = bins_[i];
        if (bin.all >= kEnoughTests) {
            // Half a failure is always assumed: no history makes a node certain.
            return static_cast<double>(bin.kept) / (static_cast<double>(bin.all) + 0.5);
        }
    }
    return analytic_keep_probability(frames_hidden);
}

} // namespace occlude
