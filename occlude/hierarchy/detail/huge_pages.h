// Large pages for large arrays: fewer page faults while they are filled, and fewer misses of the
// TLB afterwards. Internal.
#pragma once

#include <cstddef>

namespace occlude::detail {

/// Asks the system to put memory that nobody has written yet on large pages. A hint: it changes
/// nothing but times, takes no memory beyond the range, and where it is not understood (systems
/// other than Linux, ranges below some megabytes) nothing happens.
void prefer_huge_pages(void* data, size_t bytes);

/// Reserves room in an empty vector, on large pages.
template <class Vector>
void reserve_huge(Vector& empty, size_t size)
{
    empty.reserve(size);
    prefer_huge_pages(empty.data(), size * sizeof(*empty.data()));
}

} // namespace occlude::detail
