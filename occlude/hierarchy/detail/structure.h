// The part of validate() about the shape of a tree. from_arrays() derives everything else from it.
#pragma once

#include <occlude/hierarchy/hierarchy.h>

#include <string>

namespace occlude::detail {

/// The first broken rule of the shape as a sentence, or an empty string. If it is empty, every
/// range lies within its array. O(nodes).
std::string check_structure(const Hierarchy& hierarchy);

} // namespace occlude::detail
