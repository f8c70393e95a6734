#include <occlude/backends/cpu_fast/detail/workers.h>

#ifdef OCCLUDE_HAS_TBB

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>

namespace occlude::cpu_fast {

struct Workers::Arena {
    explicit Arena(int threads)
        : arena(threads)
    {
    }
    tbb::task_arena arena;
};

Workers::Workers(int threads)
{
    const int available = tbb::this_task_arena::max_concurrency();
    const int used = threads == 0 ? available : std::clamp(threads, 1, available);
    count_ = static_cast<size_t>(used);
    if (used > 1) {
        arena_ = std::make_unique<Arena>(used);
    }
}

void Workers::run(size_t count, void (*call)(const void*, size_t), const void* work)
{
    arena_->arena.execute(
        [&] { tbb::parallel_for(size_t{0}, count, [&](size_t i) { call(work, i); }); });
}

} // namespace occlude::cpu_fast

#else

namespace occlude::cpu_fast {

struct Workers::Arena {};

Workers::Workers(int) {}

void Workers::run(size_t count, void (*call)(const void*, size_t), const void* work)
{
    for (size_t i = 0; i < count; ++i) {
        call(work, i);
    }
}

} // namespace occlude::cpu_fast

#endif

namespace occlude::cpu_fast {

Workers::~Workers() = default;

} // namespace occlude::cpu_fast
