// The cost model of CHC++'s multiqueries, as pure functions and a table that tests can reach.
//
// Implements  ShaderX7 8.4, "Estimating Visibility Coherence" and "Cost-Benefit Heuristics for
//             Multiqueries".
// Deviations  The paper prints p_keep(i) = 0.99 - 0.7 e^-1; the exponent lost its i. Independent
//             implementations of the method agree on e^-i. A failed group may be halved until it
//             has `most_singly` nodes; the paper tests its nodes one by one at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace occlude {

/// `most_singly` for callers that never halve: a failed group is tested node by node.
constexpr size_t kNeverHalved = ~size_t{0};
/// Smaller groups are not worth halving, even if one more round of tests costs nothing.
constexpr size_t kLeastHalved = 4;

/// The probability that a node hidden for `frames_hidden` frames stays hidden: the paper's fit.
/// 0 -> 0.29, 1 -> 0.732, 2 -> 0.895, many -> 0.99.
double analytic_keep_probability(uint32_t frames_hidden);

/// The value V = B / C of a multiquery over `count` nodes that all stay hidden with probability
/// `all_keep`: answered nodes per expected query, with C = 1 + (1 - all_keep) * count. One node
/// alone has value 1: its query cannot be wasted. A failed group of more than `most_singly` nodes
/// is halved; then C counts two tests for each halving, and then one per node. The value is 0 if
/// the group will probably fail, because more than one of its nodes would then be visible.
double multiquery_value(size_t count, double all_keep, size_t most_singly = kNeverHalved);

/// How many nodes from the front of `keep` (probabilities, descending) the best multiquery covers:
/// greedy, as long as the value grows. At least 1. Precondition: `keep` is not empty.
size_t best_multiquery_size(std::span<const double> keep, size_t most_singly = kNeverHalved);

/// The size of the tests that follow a failed multiquery over `count` nodes; the last may be
/// smaller. Half of the nodes, or 1 if there are at most `most_singly`.
size_t failed_multiquery_part(size_t count, size_t most_singly);

/// The measured p_keep(i) = n_keep(i) / n_all(i), updated by every test.
class KeepTable {
public:
    /// Counts one test of a node that was hidden for `frames_hidden` frames.
    void record(uint32_t frames_hidden, bool kept);

    /// The measured probability. A value with few measurements leans on the next lower one (the
    /// paper's piecewise constant propagation to higher i). Without any measurement it is the
    /// analytic fit. Never above kMostCertain: no history makes a node certain. O(log
    /// frames_hidden).
    double keep_probability(uint32_t frames_hidden) const;

    void clear() { *this = KeepTable{}; }

    static constexpr double kMostCertain = 0.9999; ///< groups of at most 101 nodes

private:
    // Persistences share bins: one each below 8, then four per octave. All hidden nodes of a quiet
    // view age together, so that a bin for each age would have no measurements when it is first
    // needed.
    static constexpr uint32_t kBins = 8 + 4 * 29;
    static uint32_t bin_of(uint32_t frames_hidden);

    static constexpr double kPriorTests = 16.0;  ///< weight of the next lower value, in tests
    static constexpr uint32_t kMostTests = 4096; ///< when a bin has this many tests, both counts
                                                 ///< are halved, so that old tests fade

    struct Bin {
        uint32_t all = 0;
        uint32_t kept = 0;
    };
    std::array<Bin, kBins> bins_{};
};

} // namespace occlude
