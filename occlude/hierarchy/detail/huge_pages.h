// Large pages for large arrays: fewer page faults while they are filled, and fewer TLB misses
// later. Internal.
#pragma once

#include <cstddef>

namespace occlude::detail {

/// Asks the system to put memory that was not written yet on large pages. This is a hint: it
/// changes only times and takes no memory beyond the range. It does nothing for ranges below some
/// megabytes, and on systems other than Linux.
void prefer_huge_pages(void* data, size_t bytes);

/// Reserves room in an empty vector, on large pages.
template <class Vector>
void reserve_huge(Vector& empty, size_t size)
{
    empty.reserve(size);
    prefer_huge_pages(empty.data(), size * sizeof(*empty.data()));
}

} // namespace occlude::detail
