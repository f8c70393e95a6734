// Whether the arrays of a recorded tree are a tree. Hierarchy::from_finished_arrays trusts its
// builder; nobody can trust a file.
#pragma once

#include "replay/run_recording.h"

#include <string>

namespace occlude::tools {

/// The first broken rule as a sentence, or nothing. Arrays of any content are safe to check. If it
/// is nothing, validate() finds nothing in the tree of these arrays either.
std::string check_tree(const RecordedTree& tree);

} // namespace occlude::tools
