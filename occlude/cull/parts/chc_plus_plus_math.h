// The cost model of CHC++'s multiqueries, as pure functions and a table that tests can reach.
//
// Implements  ShaderX7 8.4, "Estimating Visibility Coherence" and "Cost-Benefit Heuristics for
//             Multiqueries".
// Deviations  The paper prints p_keep(i) = 0.99 - 0.7 e^-1; the exponent lost its i. Independent
//             implementations of the method agree on e^-i. A group that fails may be halved until
//             it has `most_singly` nodes; the paper tests its nodes one by one at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace occlude {

/// No group is so large that it is halved when it fails: its nodes are tested one by one.
constexpr size_t kNeverHalved = ~size_t{0};
/// Smaller groups are not worth halving even where one more round of tests costs nothing.
constexpr size_t kLeastHalved = 4;

/// The probability that a node hidden for `frames_hidden` frames stays hidden: the paper's fit.
/// 0 -> 0.29, 1 -> 0.732, 2 -> 0.895, many -> 0.99.
double analytic_keep_probability(uint32_t frames_hidden);

/// The value V = B / C of a multiquery over `count` nodes that all stay hidden with probability
/// `all_keep`: nodes answered per expected query. C = 1 + (1 - all_keep) * count. One node alone
/// has value 1: its query cannot be wasted. Where groups of more than `most_singly` are halved, C
/// has the tests of the halves instead: two for each halving, then the nodes; and the value is 0 if
/// the group is not likely to stay hidden, as more than one of its nodes would show.
double multiquery_value(size_t count, double all_keep, size_t most_singly = kNeverHalved);

/// How many nodes from the front of `keep` (descending keep probabilities) the best multiquery
/// takes: greedy, as long as the value grows. At least 1. Precondition: keep is not empty.
size_t best_multiquery_size(std::span<const double> keep, size_t most_singly = kNeverHalved);

/// How many nodes each test takes that follows a failed multiquery over `count`, the last maybe
/// fewer: half of them, or 1 if they are at most `most_singly`.
size_t failed_multiquery_part(size_t count, size_t most_singly);

/// The measured p_keep(i) = n_keep(i) / n_all(i), constantly updated.
class KeepTable {
public:
    /// Counts one test of a node that had been hidden for `frames_hidden` frames.
    void record(uint32_t frames_hidden, bool kept);

    /// The measured probability. Values that were measured little lean on the next lower one (the
    /// paper's piecewise constant propagation to higher i); without any measurement it is the
    /// analytic fit. Never above kMostCertain: no history makes a node certain. O(log
    /// frames_hidden).
    double keep_probability(uint32_t frames_hidden) const;

    void clear() { *this = KeepTable{}; }

    static constexpr double kMostCertain = 0.9999; ///< groups of at most 101 nodes

private:
    // Persistences share bins: one each below 8, then four to the octave. All hidden nodes of a
    // quiet view grow old together; a bin for each age would never have been measured when it is
    // needed.
    static constexpr uint32_t kBins = 8 + 4 * 29;
    static uint32_t bin_of(uint32_t frames_hidden);

    static constexpr double kPriorTests = 16.0;  ///< what the next lower value weighs, in tests
    static constexpr uint32_t kMostTests = 4096; ///< then both counts are halved: old tests fade

    struct Bin {
        uint32_t all = 0;
        uint32_t kept = 0;
    };
    std::array<Bin, kBins> bins_{};
};

} // namespace occlude
