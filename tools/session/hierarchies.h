// From --hierarchy and --set to trees that can be built.
#pragma once

#include "options/options.h"

#include <occlude/core/result.h>

#include <span>

namespace occlude::tools {

/// One entry of --hierarchy: a kind of tree and its settings.
struct HierarchyChoice {
    std::string kind;
    std::string label;                ///< as it was typed: "bvh:leaf_triangles=400"
    std::vector<OptionValue> options; ///< settings of --set for the kind, then the entry's own
};

/// The kinds that `text` names between commas, each entry once and in that order, or "all".
/// "bvh:leaf_triangles=400" has its own option, so that trees can be compared in one run. Errors
/// name the unknown kind or option and the known ones, or the setting of a kind that does not take
/// part. Settings for algorithms are ignored.
Result<std::vector<HierarchyChoice>> choose_hierarchies(std::string_view text,
                                                        std::span<const std::string> sets);

/// "bvh, bsp": the names that --hierarchy accepts.
std::string hierarchy_names();

/// The name of a kind of hierarchy in --set: its own name, or NAME_tree if an algorithm has that
/// name.
std::string tree_set_name(std::string_view kind);

} // namespace occlude::tools
