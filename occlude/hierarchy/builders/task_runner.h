// Where builders of trees do work that can be done side by side.
#pragma once

namespace occlude {

/// Runs the parts of one call side by side. A host with a job system of its own derives from it and
/// names it in an options struct (BvhOptions::tasks); results do not depend on who runs what.
class TaskRunner {
public:
    /// `run(data)` does the work. `data` lives until run_both() returns.
    struct Task {
        void (*run)(void* data);
        void* data;
    };

    virtual ~TaskRunner() = default;

    /// Runs both tasks, in any order or at the same time, in any threads, and returns when both are
    /// done. Tasks call run_both() themselves: a thread that waits here must run other tasks
    /// meanwhile, or there must be a thread for each, as with any fork and join.
    virtual void run_both(Task first, Task second) = 0;
};

/// The runner of builders whose options name none: oneTBB, or the calling thread alone where the
/// library is built without it (OCCLUDE_THREADS=OFF).
TaskRunner& default_task_runner();

/// One task after the other, in the calling thread.
TaskRunner& serial_task_runner();

} // namespace occlude
