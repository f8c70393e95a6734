// From --hierarchy and --set to trees that can be built.
#pragma once

#include "options/options.h"

#include <occlude/core/result.h>

#include <span>

namespace occlude::tools {

/// One entry of --hierarchy: a kind of tree, and everything that is set for it.
struct HierarchyChoice {
    std::string kind;
    std::string label;                ///< as it was typed: "bvh:leaf_triangles=400"
    std::vector<OptionValue> options; ///< of --set for the kind, then of the entry
};

/// What `text` names: kinds between commas, each entry once, in that order, or "all";
/// "bvh:leaf_triangles=400" has an option of its own, so that trees can be compared in one run.
/// Errors name the unknown kind or option and what there is, or the setting of a kind that does not
/// take part. Settings for others (algorithms) are left alone.
Result<std::vector<HierarchyChoice>> choose_hierarchies(std::string_view text,
                                                        std::span<const std::string> sets);

/// "bvh, bsp": the names that --hierarchy takes.
std::string hierarchy_names();

/// How --set names a kind of hierarchy: by its name, or as NAME_tree where an algorithm has that
/// name.
std::string tree_set_name(std::string_view kind);

} // namespace occlude::tools
