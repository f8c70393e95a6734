// What it takes to follow moving objects: a full refit of a city of boxes, and refits of the moved
// ones only, scattered all over the city or together in one quarter.
#include "city_boxes.h"

#include <occlude/core/rng.h>
#include <occlude/hierarchy/bvh_builder.h>

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

BENCHMARK(refit_all)->ArgName("boxes")->Arg(100'000)->Arg(1'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK(refit_moved)
    ->ArgNames({"boxes", "moved", "together"})
    ->ArgsProduct({{1'000'000}, {1'000, 10'000, 100'000}, {0, 1}})
    ->Unit(benchmark::kMillisecond);

} // namespace
} // namespace occlude::bench
