// The culler's own time per frame, without any drawing or testing: a walk along a street of a city
// of boxes, on a device that answers from precomputed visible sets at no cost. The time should
// follow the number of visible boxes, not the size of the city.
#include "city_boxes.h"
#include "oracle_device.h"

#include <occlude/cull/registry.h>
#include <occlude/hierarchy/builders/bvh_builder.h>

#include <benchmark/benchmark.h>

#include <ctime>
#include <map>
#include <memory>
#include <string>

namespace occlude::bench {
namespace {

constexpr glm::ivec2 kSizePx{960, 540}; // about 1000 boxes own a pixel
constexpr size_t kFrames = 8;

struct City {
    explicit City(size_t count)
        : tree(build_bvh(city_boxes(count)))
    {
        for (size_t i = 0; i < kFrames; ++i) {
            views.push_back(street_view(count, i, kFrames, kSizePx));
            truths.push_back(look_through_pixels(tree, views.back()));
        }
        device = std::make_unique<OracleDevice>(tree, truths);
    }
    Hierarchy tree;
    std::vector<View> views;
    std::vector<Truth> truths;
    std::unique_ptr<OracleDevice> device;
};

// One city at a time: the largest takes gigabytes.
City& city(size_t count)
{
    static std::map<size_t, std::unique_ptr<City>> cities;
    if (!cities.contains(count)) {
        cities.clear();
        cities[count] = std::make_unique<City>(count);
    }
    return *cities[count];
}

void traverse(benchmark::State& state, const char* algorithm)
{
    City& scene = city(static_cast<size_t>(state.range(0)));
    auto culler = make_culler(algorithm, scene.tree);
    FrameCounters sum;
    size_t visible = 0;
    size_t frames = 0;
    // Forth and back, so that each frame but the first is near the last one.
    const auto step = [&] {
        const size_t phase = frames++ % (2 * kFrames - 2);
        const size_t i = phase < kFrames ? phase : 2 * kFrames - 2 - phase;
        scene.device->look(i);
        visible += scene.truths[i].visible.size();
        return (*culler)->cull(scene.views[i], *scene.device);
    };
    for (size_t i = 0; i < 4 * kFrames; ++i) {
        step();
    }
    frames = visible = 0;
    for (auto _ : state) {
        const std::clock_t from = std::clock() - scene.device->reading();
        sum += step().counters;
        const std::clock_t taken = std::clock() - scene.device->reading() - from;
        state.SetIterationTime(static_cast<double>(taken) / CLOCKS_PER_SEC);
    }
    const auto per_frame = [&](uint64_t n) {
        return static_cast<double>(n) / static_cast<double>(frames);
    };
    state.counters["visible"] = per_frame(visible);
    state.counters["drawn"] = per_frame(sum.items_drawn);
    state.counters["nodes"] = per_frame(sum.nodes_visited);
    state.counters["tests"] = per_frame(sum.queries);
}

// By size first, so that each city is made once.
const bool registered = [] {
    for (const int64_t count : {10'000, 100'000, 1'000'000, 10'000'000}) {
        for (const char* algorithm : {"frustum", "chc", "chc_plus_plus", "two_phase", "adaptive"}) {
            benchmark::RegisterBenchmark(("traverse/" + std::string(algorithm)).c_str(), traverse,
                                         algorithm)
                ->ArgName("boxes")
                ->Arg(count)
                ->UseManualTime()
                ->Unit(benchmark::kMicrosecond);
        }
    }
    return true;
}();

} // namespace
} // namespace occlude::bench
