#include <occlude/hierarchy/builders/task_runner.h>

#ifdef OCCLUDE_HAS_TBB
#include <tbb/parallel_invoke.h>
#endif

namespace occlude {

namespace {

class SerialTaskRunner final : public TaskRunner {
public:
    void run_both(Task first, Task second) override
    {
        first.run(first.data);
        second.run(second.data);
    }
};

#ifdef OCCLUDE_HAS_TBB
class TbbTaskRunner final : public TaskRunner {
public:
    void run_both(Task first, Task second) override
    {
        tbb::parallel_invoke([first] { first.run(first.data); },
                             [second] { second.run(second.data); });
    }
};
#endif

} // namespace

// Neither runner has state.

TaskRunner& serial_task_runner()
{
    static SerialTaskRunner runner;
    return runner;
}

TaskRunner& default_task_runner()
{
#ifdef OCCLUDE_HAS_TBB
    static TbbTaskRunner runner;
    return runner;
#else
    return serial_task_runner();
#endif
}

} // namespace occlude
