// From --algorithms and --set to algorithms that can be made.
#pragma once

#include "commands/options.h"
#include "measure/stage.h"
#include "measure/timing_device.h"

namespace occlude::tools {

/// Whether the algorithms that all others are compared with run even if nobody asked for them.
enum class References { always, if_asked };

/// The algorithms of `list`: "all", "exact" and names between commas, each once, in the order of the
/// registry. A name may carry a label, as in "lazy_grid@busy": one more run of the same algorithm
/// with settings of its own. Settings (`sets`) reach the run of exactly that name, label included.
/// Algorithms that need more than `caps` offers are left out of "all" and "exact", and are an error
/// when named. Other errors name the unknown algorithm, label, option or setting and what there is.
/// Options that count in time ask `clock`.
Result<std::vector<Contender>> choose_contenders(const std::string& list,
                                                 std::span<const std::string> sets,
                                                 const DeviceCaps& caps, References references,
                                                 const Clock& clock = steady_clock());

/// Which algorithms meet which hierarchies: what --algorithms and --hierarchy say.
struct Pairing {
    std::vector<Contender> contenders; ///< with the kind of hierarchy, yet without its tree
    std::vector<std::string> notes;    ///< sentences about what was left out
};
/// Each contender on each kind of `hierarchies`, by algorithm and then by kind. What makes no use
/// of nodes runs once, on the first kind. A pair that does not suit (AlgorithmInfo::hierarchies)
/// takes part only if both were named, `algorithms` and `hierarchies` being what the user typed.
Result<Pairing> pair_with_hierarchies(std::span<const Contender> contenders,
                                      const std::string& algorithms,
                                      const std::string& hierarchies);

} // namespace occlude::tools
