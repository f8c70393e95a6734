// The threads of an OccluderBuffer: oneTBB's where the library is built with it, else the caller.
#pragma once

#include <cstddef>
#include <memory>

namespace occlude::cpu_fast {

class Workers {
public:
    /// 0: as many threads as there are. Never more than that.
    explicit Workers(int threads);
    ~Workers();

    size_t count() const { return count_; }

    /// Calls work(i) for every i below `count`, at once where there are several threads, and
    /// returns when all of it is done.
    template <class Work>
    void for_each(size_t count, const Work& work)
    {
        if (count_ == 1 || count == 1) {
            for (size_t i = 0; i < count; ++i) {
                work(i);
            }
            return;
        }
        run(
            count, [](const void* w, size_t i) { (*static_cast<const Work*>(w))(i); }, &work);
    }

private:
    struct Arena;

    void run(size_t count, void (*call)(const void*, size_t), const void* work);

    size_t count_ = 1;
    std::unique_ptr<Arena> arena_; ///< null: the caller works alone
};

} // namespace occlude::cpu_fast
