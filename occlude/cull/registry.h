// Every algorithm by name, with its options by name: what `occlude list`, `--algorithms` and
// `--set` are made of.
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
    /// The kinds of hierarchies that suit it (hierarchy_kinds.h), in their order; on the others it
    /// is right, but not what it could be. Empty: it makes no use of nodes, and all kinds are
    /// alike.
    std::vector<std::string> hierarchies;
    std::vector<OptionInfo> options;
    Result<std::unique_ptr<Culler>> (*make)(const Hierarchy&, std::span<const OptionValue>,
                                            SecondsClock) = nullptr;
};

/// All algorithms, in the order in which tables show them.
std::span<const AlgorithmInfo> algorithms();

/// The algorithm of that name, or null.
const AlgorithmInfo* find_algorithm(std::string_view name);

/// A culler by name. `clock` is for options that count in time (`prioritized.budget_time`,
/// `statistical.time`) and for `adaptive`, which measures by it; other algorithms and options never
/// ask it, so that runs repeat. Without a clock these options have no effect. Errors name the
/// unknown algorithm or option and list what there is.
Result<std::unique_ptr<Culler>> make_culler(std::string_view name, HierarchyRef hierarchy,
                                            std::span<const OptionValue> options = {},
                                            SecondsClock clock = {});

} // namespace occlude
