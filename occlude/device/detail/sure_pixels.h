// The smallest count that a test of a box may have, from depth that was read. Internal.
#pragma once

#include <occlude/core/query_device.h>

#include <span>

namespace occlude::detail {

/// How many pixels must pass a test of this box: the pixels that lie wholly inside its outline and
/// whose depth is farther than all of the box. Errs toward fewer. `depth` holds the pixels of the
/// whole target, or nothing if it could not be read: then the result is 0. O(pixels of the box).
int sure_pixels(const QueryBox& box, const View& view, std::span<const float> depth);

} // namespace occlude::detail
