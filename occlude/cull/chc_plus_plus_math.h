// The cost model of CHC++'s multiqueries, as pure functions and a table that tests can reach.
//
// Implements  ShaderX7 8.4, "Estimating Visibility Coherence" and "Cost-Benefit Heuristics for
//             Multiqueries".
// Deviations  The paper prints p_keep(i) = 0.99 - 0.7 e^-1; the exponent lost its i. Independent
//             implementations of the method agree on e^-i.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace occlude {

/// The probability that a node hidden for `frames_hidden` frames stays hidden: the paper's fit.
/// 0 -> 0.29, 1 -> 0.732, 2 -> 0.895, many -> 0.99.
double analytic_keep_probability(uint32_t frames_hidden);

/// The value V = B / C of a multiquery over `count` nodes that all stay hidden with probability
/// `all_keep`: nodes answered per expected query. C = 1 + (1 - all_keep) * count. One node alone
/// has value 1: its query cannot be wasted.
double multiquery_value(size_t count, double all_keep);

/// How many nodes from the front of `keep` (descending keep probabilities) the best multiquery
/// takes: greedy, as long as the value grows. At least 1. Precondition: keep is not empty.
size_t best_multiquery_size(std::span<const double> keep);

/// The measured p_keep(i) = n_keep(i) / n_all(i), constantly updated.
class KeepTable {
public:
    /// Counts one test of a node that had been hidden for `frames_hidden` frames.
    void record(uint32_t frames_hidden, bool kept);

    /// The measured probability. Persistences without enough tests take the nearest lower measured
    /// one (the paper's piecewise constant propagation), and the analytic fit where there is none.
    double keep_probability(uint32_t frames_hidden) const;

    void clear() { *this = KeepTable{}; }

private:
    static constexpr size_t kBins = 256; ///< longer persistences share the last bin
    static constexpr uint32_t kEnoughTests = 32;
    static constexpr uint32_t kMostTests = 1u << 16; ///< then both counts are halved: old news fade

    struct Bin {
        uint32_t all = 0;
        uint32_t kept = 0;
    };
    std::array<Bin, kBins> bins_{};
};

} // namespace occlude
