// The time to follow moving objects: a full refit of a city of boxes; refits of the moved boxes
// only, scattered all over the city or together in one quarter; and their re-insertion into the
// two-level tree.
#include "city_boxes.h"

#include <occlude/core/rng.h>
#include <occlude/hierarchy/builders/bvh_builder.h>
#include <occlude/hierarchy/builders/two_level.h>

#include <benchmark/benchmark.h>

namespace occlude::bench {
namespace {

void shift(ItemBounds& item, float by)
{
    item.box.min.x += by;
    item.box.max.x += by;
}

void refit_all(benchmark::State& state)
{
    std::vector<ItemBounds> items = city_boxes(static_cast<size_t>(state.range(0)));
    Hierarchy tree = build_bvh(items);
    for (auto _ : state) {
        tree.refit(items);
    }
}

void refit_moved(benchmark::State& state)
{
    const auto count = static_cast<size_t>(state.range(0));
    const auto moving = static_cast<size_t>(state.range(1));
    const bool together = state.range(2) != 0;
    std::vector<ItemBounds> items = city_boxes(count);
    Hierarchy tree = build_bvh(items);
    std::vector<ItemId> moved(moving);
    Rng rng(2);
    for (size_t i = 0; i < moving; ++i) {
        moved[i] = together ? tree.items()[count / 2 + i]
                            : ItemId{rng.below(static_cast<uint32_t>(count))};
    }
    float by = 0.25f;
    tree.refit(std::span<const ItemId>{moved}.first(1), items); // makes the index
    for (auto _ : state) {
        state.PauseTiming();
        by = -by;
        for (const ItemId item : moved) {
            shift(items[item.value], by);
        }
        state.ResumeTiming();
        tree.refit(moved, items);
    }
}

// Each box is an object of one item. One in five of the moved boxes moves far enough to leave its
// node.
void reinsert_moved(benchmark::State& state)
{
    const auto count = static_cast<size_t>(state.range(0));
    const auto moving = static_cast<size_t>(state.range(1));
    std::vector<ItemBounds> items = city_boxes(count);
    TwoLevelTree tree;
    for (size_t i = 0; i < count; ++i) {
        tree.add({.first_item = ItemId{i}, .local_boxes = {&items[i].box, 1}});
    }
    tree.update(items);
    Rng rng(2);
    std::vector<TwoLevelTree::Slot> moved(moving);
    for (TwoLevelTree::Slot& slot : moved) {
        slot = rng.below(static_cast<uint32_t>(count));
    }
    const uint64_t before = tree.relink_count();
    float by = 1.0f;
    for (auto _ : state) {
        state.PauseTiming();
        by = -by;
        for (size_t i = 0; i < moving; ++i) {
            shift(items[moved[i]], i % 5 == 0 ? by * 20.0f : by * 0.05f);
        }
        state.ResumeTiming();
        for (const TwoLevelTree::Slot slot : moved) {
            tree.move(slot, glm::mat4{1.0f}); // the boxes are in world space
        }
        tree.update(items);
    }
    state.counters["relinks"] = benchmark::Counter(
        static_cast<double>(tree.relink_count() - before), benchmark::Counter::kAvgIterations);
}

BENCHMARK(refit_all)->ArgName("boxes")->Arg(100'000)->Arg(1'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK(refit_moved)
    ->ArgNames({"boxes", "moved", "together"})
    ->ArgsProduct({{1'000'000}, {1'000, 10'000, 100'000}, {0, 1}})
    ->Unit(benchmark::kMillisecond);
BENCHMARK(reinsert_moved)
    ->ArgNames({"boxes", "moved"})
    ->ArgsProduct({{100'000, 1'000'000}, {1'000, 100'000}})
    ->Unit(benchmark::kMillisecond);

} // namespace
} // namespace occlude::bench
