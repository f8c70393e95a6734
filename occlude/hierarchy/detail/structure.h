// What validate() checks of the shape of a tree, for from_arrays(), which derives the rest from it.
#pragma once

#include <occlude/hierarchy/hierarchy.h>

#include <string>

namespace occlude::detail {

/// The first broken rule of the shape as a sentence, or an empty string. Without one every range
/// lies within its array. O(nodes).
std::string check_structure(const Hierarchy& hierarchy);

} // namespace occlude::detail
