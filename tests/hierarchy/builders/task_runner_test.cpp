#include <occlude/hierarchy/builders/bvh_builder.h>

#include "hierarchy/scenes.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace occlude {
namespace {

using test::random_items;

/// A host's own job system: every second task runs in a thread of its own.
class ThreadPerTask final : public TaskRunner {
public:
    void run_both(Task first, Task second) override
    {
        ++forks;
        std::thread other([second] { second.run(second.data); });
        first.run(first.data);
        other.join();
    }

    std::atomic<int> forks = 0;
};

TEST(BvhBuilder, TreeDoesNotDependOnWhoRunsItsTasks)
{
    const std::vector<ItemBounds> items = random_items(90000, 5);
    const Hierarchy expected = build_bvh(items);
    ThreadPerTask threads;
    for (TaskRunner* tasks : {&serial_task_runner(), static_cast<TaskRunner*>(&threads)}) {
        const Hierarchy tree = build_bvh(items, {.tasks = tasks});
        EXPECT_TRUE(test::same_tree(tree, expected));
    }
    EXPECT_GT(threads.forks, 20) << "the host's threads were hardly used";
}

} // namespace
} // namespace occlude
