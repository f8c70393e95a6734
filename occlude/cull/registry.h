// Every algorithm by name, with its options by name: the source of `occlude list`, `--algorithms`
// and `--set`.
#pragma once

#include <occlude/core/clock.h>
#include <occlude/core/option_text.h>
#include <occlude/core/result.h>
#include <occlude/cull/culler.h>

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace occlude {

/// An algorithm as the registry knows it: its AlgorithmTraits, its options, and how to make one.
struct AlgorithmInfo {
    std::string name;
    std::string paper;
    std::string summary;
    bool exact = true;
    bool remembers = true;
    Needs needs;
    /// The kinds of hierarchies that suit it, in the order of hierarchy_kinds.h. On other kinds it
    /// is correct, but tests or draws more than it could. Empty: it does not use nodes, and the
    /// kind makes no difference.
    std::vector<std::string> hierarchies;
    std::vector<OptionInfo> options;
    Result<std::unique_ptr<Culler>> (*make)(const Hierarchy&, std::span<const OptionValue>,
                                            SecondsClock) = nullptr;
};

/// All algorithms, in the order in which tables show them.
std::span<const AlgorithmInfo> algorithms();

/// The algorithm of that name, or null.
const AlgorithmInfo* find_algorithm(std::string_view name);

/// A culler by name. `clock` is read only by options that count in time (`prioritized.budget_time`,
/// `statistical.time`) and by `adaptive`, which measures with it. So runs of all others repeat.
/// Without a clock these options have no effect. An error names the unknown algorithm or option and
/// lists the known ones.
Result<std::unique_ptr<Culler>> make_culler(std::string_view name, HierarchyRef hierarchy,
                                            std::span<const OptionValue> options = {},
                                            SecondsClock clock = {});

} // namespace occlude
