// From --algorithms and --set to algorithms that can be made.
#pragma once

#include "measure/stage.h"
#include "measure/timing_device.h"
#include "options/options.h"
#include "session/hierarchies.h"

#include <occlude/core/result.h>

namespace occlude::tools {

/// Whether the algorithms that all others are compared with run even if nobody asked for them.
enum class References { always, if_asked };

/// The algorithms of `list` ("all", "exact" or names between commas; "chc:threshold=20" is one with
/// options of its own, so that settings can be compared in one run) with the settings of `sets`,
/// each once, in the order of the registry. Algorithms that need more than `caps` offers are left
/// out of "all" and "exact", and are an error when named. Other errors name the unknown algorithm,
/// option or setting and what there is. Options that count in time ask `clock`.
Result<std::vector<Contender>>
choose_contenders(const std::string& list, std::span<const std::string> sets,
                  const DeviceCaps& caps, References references,
                  const SecondsClock& clock = steady_seconds_clock());

/// Which algorithms meet which hierarchies: what --algorithms and --hierarchy say.
struct Pairing {
    std::vector<Contender> contenders; ///< with the label of a hierarchy, yet without its tree
    std::vector<std::string> notes;    ///< sentences about what was left out
};
/// Each contender on each of `trees`, by algorithm and then by tree. What makes no use of nodes
/// runs once, on the first. A pair that does not suit (AlgorithmInfo::hierarchies) takes part only
/// if both were named, `algorithms` and `hierarchies` being what the user typed.
Pairing pair_with_hierarchies(std::span<const Contender> contenders,
                              std::span<const HierarchyChoice> trees, const std::string& algorithms,
                              const std::string& hierarchies);

} // namespace occlude::tools
