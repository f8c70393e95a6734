// From --algorithms and --set to algorithms that can be made.
#pragma once

#include "commands/options.h"
#include "measure/stage.h"

namespace occlude::tools {

/// Whether the algorithms that all others are compared with run even if nobody asked for them.
enum class References { always, if_asked };

/// The algorithms of `list` ("all", "exact" or names between commas) with the settings of `sets`,
/// each once, in the order of the registry. Algorithms that need more than `caps` offers are left
/// out of "all" and "exact", and are an error when named. Other errors name the unknown algorithm,
/// option or setting and what there is.
Result<std::vector<Contender>> choose_contenders(const std::string& list,
                                                 std::span<const std::string> sets,
                                                 const DeviceCaps& caps, References references);

} // namespace occlude::tools
