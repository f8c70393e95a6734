// The interface for work that builders of trees can do in parallel.
#pragma once

namespace occlude {

/// Runs the parts of one call in parallel. A host with its own job system derives from it and sets
/// it in an options struct (BvhOptions::tasks). Results do not depend on which thread runs a part.
class TaskRunner {
public:
    /// `run(data)` does the work. `data` lives until run_both() returns.
    struct Task {
        void (*run)(void* data);
        void* data;
    };

    virtual ~TaskRunner() = default;

    /// Runs both tasks, in any order or at the same time, in any threads, and returns when both are
    /// done. Tasks call run_both() themselves. So a thread that waits here must run other tasks
    /// meanwhile, or each task needs a thread, as with any fork and join.
    virtual void run_both(Task first, Task second) = 0;
};

/// The runner for builders whose options name none: oneTBB, or the calling thread alone in a
/// library built without oneTBB (OCCLUDE_THREADS=OFF).
TaskRunner& default_task_runner();

/// Runs one task after the other, in the calling thread.
TaskRunner& serial_task_runner();

} // namespace occlude
