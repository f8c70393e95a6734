#include <occlude/cull/parts/multiquery_value.h>

#include <occlude/core/assert.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace occlude {

double analytic_keep_probability(uint32_t frames_hidden)
{
    return 0.99 - 0.7 * std::exp(-static_cast<double>(frames_hidden));
}

double multiquery_value(size_t count, double all_keep, size_t most_singly)
{
    constexpr double kLeastKeep = 0.5;
    if (count <= 1) {
        return 1.0;
    }
    const double benefit = static_cast<double>(count);
    double if_failed = benefit;
    if (count > most_singly) {
        if (all_keep < kLeastKeep) {
            return 0.0;
        }
        const double singly = static_cast<double>(most_singly);
        if_failed = 2.0 * std::log2(benefit / singly) + singly;
    }
    const double cost = 1.0 + (1.0 - all_keep) * if_failed;
    return benefit / cost;
}

size_t best_multiquery_size(std::span<const double> keep, size_t most_singly)
{
    OCCLUDE_ASSERT(!keep.empty(), "a multiquery has a node");
    size_t count = 1;
    double all_keep = keep[0];
    double value = multiquery_value(1, all_keep, most_singly);
    while (count < keep.size()) {
        const double next_keep = all_keep * keep[count];
        const double next_value = multiquery_value(count + 1, next_keep, most_singly);
        if (next_value <= value) {
            break;
        }
        all_keep = next_keep;
        value = next_value;
        ++count;
    }
    return count;
}

size_t failed_multiquery_part(size_t count, size_t most_singly)
{
    OCCLUDE_ASSERT(count > 1 && most_singly > 0, "a group of one node cannot be split");
    return count <= most_singly ? 1 : (count + 1) / 2;
}

uint32_t KeepTable::bin_of(uint32_t frames_hidden)
{
    if (frames_hidden < 8) {
        return frames_hidden;
    }
    // from 8 on: 3 and up
    const auto octave = static_cast<uint32_t>(std::bit_width(frames_hidden)) - 1;
    const uint32_t quarter = (frames_hidden >> (octave - 2)) & 3u;
    return 8 + 4 * (octave - 3) + quarter;
}

void KeepTable::record(uint32_t frames_hidden, bool kept)
{
    Bin& bin = bins_[bin_of(frames_hidden)];
    ++bin.all;
    bin.kept += kept ? 1 : 0;
    if (bin.all >= kMostTests) {
        bin.all /= 2;
        bin.kept /= 2;
    }
}

double KeepTable::keep_probability(uint32_t frames_hidden) const
{
    const uint32_t last = bin_of(frames_hidden);
    double keep = analytic_keep_probability(frames_hidden);
    bool measured = false;
    for (uint32_t i = 0; i <= last; ++i) {
        const Bin& bin = bins_[i];
        if (bin.all == 0) {
            continue;
        }
        const double prior = measured ? keep : analytic_keep_probability(i);
        keep = (bin.kept + kPriorTests * prior) / (bin.all + kPriorTests);
        measured = true;
    }
    return std::min(keep, kMostCertain);
}

} // namespace occlude
