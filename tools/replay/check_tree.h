// Checks whether the arrays of a recorded tree form a tree. Hierarchy::from_finished_arrays trusts
// its builder; a file cannot be trusted.
#pragma once

#include "replay/run_recording.h"

#include <string>

namespace occlude::tools {

/// The first broken rule as a sentence, or nothing. Safe for arrays of any content. If it is
/// nothing, validate() also finds nothing wrong with the tree of these arrays.
std::string check_tree(const RecordedTree& tree);

} // namespace occlude::tools
