#include <occlude/hierarchy/detail/huge_pages.h>

#ifdef __linux__
#include <sys/mman.h>

#include <cstdint>
#endif

namespace occlude {

void detail::prefer_huge_pages([[maybe_unused]] void* data, [[maybe_unused]] size_t bytes)
{
#ifdef __linux__
    // Only whole large pages, because the memory beside the array is not ours. A large page has 2
    // MB on x86-64, and on ARM with pages of 4 KB. Where large pages are larger, the advice has no
    // effect.
    constexpr uintptr_t kPage = uintptr_t{2} << 20;
    const auto begin = reinterpret_cast<uintptr_t>(data);
    const uintptr_t first = (begin + kPage - 1) / kPage * kPage;
    const uintptr_t last = (begin + bytes) / kPage * kPage;
    if (first < last) {
        (void)madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);
    }
#endif
}

} // namespace occlude
