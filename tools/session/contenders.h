// Turns --algorithms and --set into algorithms that can be made.
#pragma once

#include "measure/stage.h"
#include "measure/timing_device.h"
#include "options/options.h"
#include "session/hierarchies.h"

#include <occlude/core/result.h>

namespace occlude::tools {

/// Whether the algorithms that all others are compared with run without being named.
enum class References { always, if_asked };

/// The algorithms of `list` with the settings of `sets`, each once, in the order of the registry.
/// `list` is "all", "exact" or names between commas; "chc:threshold=20" has its own options, so
/// that settings can be compared in one run. Algorithms that need more than `caps` offers are left
/// out of "all" and "exact", and are an error when named. Other errors name the unknown algorithm,
/// option or setting and the known ones. Options that count in time read `clock`.
Result<std::vector<Contender>>
choose_contenders(const std::string& list, std::span<const std::string> sets,
                  const DeviceCaps& caps, References references,
                  const SecondsClock& clock = steady_seconds_clock());

/// The algorithms on each hierarchy, as --algorithms and --hierarchy choose them.
struct Pairing {
    std::vector<Contender> contenders; ///< with the label of a hierarchy, yet without its tree
    std::vector<std::string> notes;    ///< sentences about what was left out
};
/// Each contender on each of `trees`, by algorithm and then by tree. An algorithm that does not use
/// nodes runs once, on the first tree. A pair that does not suit (AlgorithmInfo::hierarchies) takes
/// part only if both were named: `algorithms` and `hierarchies` are the texts of the user.
Pairing pair_with_hierarchies(std::span<const Contender> contenders,
                              std::span<const HierarchyChoice> trees, const std::string& algorithms,
                              const std::string& hierarchies);

} // namespace occlude::tools
