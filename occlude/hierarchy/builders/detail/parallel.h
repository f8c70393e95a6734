// Loops over ranges that are halved, so that a TaskRunner may run the halves in parallel. Internal:
// builders include it, users do not.
//
// The halving depends only on the length of a range. So results are joined in the same order,
// whichever thread runs a half.
#pragma once

#include <occlude/hierarchy/builders/task_runner.h>

#include <cstddef>
#include <type_traits>

namespace occlude::detail {

template <class First, class Second>
void run_both(TaskRunner& tasks, First&& first, Second&& second)
{
    using F = std::remove_reference_t<First>;
    using S = std::remove_reference_t<Second>;
    tasks.run_both({[](void* data) { (*static_cast<F*>(data))(); }, &first},
                   {[](void* data) { (*static_cast<S*>(data))(); }, &second});
}

/// Returns join(map(begin, middle), map(middle, end)), halved recursively until ranges have at most
/// `grain` elements.
template <class T, class Map, class Join>
T map_and_join(TaskRunner& tasks, size_t begin, size_t end, size_t grain, const Map& map,
               const Join& join)
{
    if (end - begin <= grain) {
        return map(begin, end);
    }
    const size_t middle = begin + (end - begin) / 2;
    T left{};
    T right{};
    run_both(
        tasks, [&] { left = map_and_join<T>(tasks, begin, middle, grain, map, join); },
        [&] { right = map_and_join<T>(tasks, middle, end, grain, map, join); });
    return join(left, right);
}

/// Calls body(begin, end) for ranges of at most `grain` elements that together make up the whole
/// range.
template <class Body>
void for_ranges(TaskRunner& tasks, size_t begin, size_t end, size_t grain, const Body& body)
{
    if (end - begin <= grain) {
        body(begin, end);
        return;
    }
    const size_t middle = begin + (end - begin) / 2;
    run_both(
        tasks, [&] { for_ranges(tasks, begin, middle, grain, body); },
        [&] { for_ranges(tasks, middle, end, grain, body); });
}

} // namespace occlude::detail
