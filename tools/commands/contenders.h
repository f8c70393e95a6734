// From --algorithms and --set to algorithms that can be made.
#pragma once

#include "commands/options.h"
#include "measure/stage.h"

namespace occlude::tools {

/// Whether the algorithms that all others are compared with run even if nobody asked for them.
enum class References { always, if_asked };

/// The algorithms of `list`: "all", "exact" and names between commas, each once, in the order of the
/// registry. A name may carry a label, as in "lazy_grid@busy": one more run of the same algorithm
/// with settings of its own. Settings (`sets`) reach the run of exactly that name, label included.
/// Algorithms that need more than `caps` offers are left out of "all" and "exact", and are an error
/// when named. Other errors name the unknown algorithm, label, option or setting and what there is.
Result<std::vector<Contender>> choose_contenders(const std::string& list,
                                                 std::span<const std::string> sets,
                                                 const DeviceCaps& caps, References references);

} // namespace occlude::tools
