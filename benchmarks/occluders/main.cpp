// The cost of OccluderBuffer: triangles by their size, rectangle tests, and recorded frames.
//
//   occluder_benchmarks [--benchmark_...] [RECORDING.mocrec]...
#include "recording.h"

#include <occlude/core/rng.h>

#include <benchmark/benchmark.h>

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

namespace occlude::benchmarks {
namespace {

constexpr glm::ivec2 kFillSize{1920, 1080};
constexpr glm::ivec2 kTestSize{1280, 720};

// A view in which world units are pixels, and z is the window depth.
View pixel_view(glm::ivec2 size)
{
    const glm::mat4 clip =
        glm::ortho(0.0f, static_cast<float>(size.x), 0.0f, static_cast<float>(size.y), 0.0f, -1.0f);
    return View::from_clip(clip, size);
}

// Right triangles with legs of `size` pixels at random places. Together they cover the area of
// about 40 screens.
OccluderMesh random_triangles(int size)
{
    Rng rng(1);
    const int count = std::max(64, 40 * kFillSize.x * kFillSize.y / (size * size) / 4);
    std::vector<glm::vec3> positions;
    std::vector<uint32_t> indices;
    const auto leg = static_cast<float>(size);
    for (int i = 0; i < count; ++i) {
        const glm::vec3 at{uniform01(rng.next()) * (static_cast<float>(kFillSize.x) - leg),
                           uniform01(rng.next()) * (static_cast<float>(kFillSize.y) - leg),
                           0.1f + 0.8f * uniform01(rng.next())};
        for (const glm::vec3& corner :
             {at, at + glm::vec3{leg, 0.0f, 0.0f}, at + glm::vec3{0.0f, leg, 0.0f}}) {
            indices.push_back(static_cast<uint32_t>(positions.size()));
            positions.push_back(corner);
        }
    }
    return OccluderMesh::prepare(PositionStream(positions), indices);
}

void fill(benchmark::State& state)
{
    const OccluderMesh mesh = random_triangles(static_cast<int>(state.range(0)));
    OccluderBuffer buffer(
        {.cell_px = static_cast<int>(state.range(1)), .threads = static_cast<int>(state.range(2))});
    const View view = pixel_view(kFillSize);
    for (auto _ : state) {
        buffer.begin(view);
        buffer.add(mesh, glm::mat4{1.0f});
        buffer.rasterize();
    }
    state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(mesh.triangles().size()));
}
BENCHMARK(fill)
    ->ArgNames({"size_px", "cell_px", "threads"})
    ->ArgsProduct({{10, 50, 100, 500}, {1, 2}, {1}})
    ->Args({10, 1, 2})
    ->Args({100, 1, 2})
    ->Unit(benchmark::kMillisecond);

void test_rectangle(benchmark::State& state)
{
    const auto size = static_cast<int>(state.range(0));
    const bool hidden = state.range(1) != 0;
    const std::vector<glm::vec3> corners{{-8.0f, -8.0f, 0.5f},
                                         {1300.0f, -8.0f, 0.5f},
                                         {1300.0f, 730.0f, 0.5f},
                                         {-8.0f, 730.0f, 0.5f}};
    const OccluderMesh wall =
        OccluderMesh::prepare(PositionStream(corners), std::vector<uint16_t>{0, 1, 2, 0, 2, 3});
    OccluderBuffer buffer({.cell_px = static_cast<int>(state.range(2))});
    buffer.begin(pixel_view(kTestSize));
    buffer.add(wall, glm::mat4{1.0f});
    buffer.rasterize();
    Rng rng(1);
    std::vector<PixelRect> rects(1024);
    for (PixelRect& rect : rects) {
        rect.width = std::min(size, kTestSize.x);
        rect.height = std::min(size, kTestSize.y);
        rect.x = static_cast<int>(rng.below(static_cast<uint32_t>(kTestSize.x - rect.width + 1)));
        rect.y = static_cast<int>(rng.below(static_cast<uint32_t>(kTestSize.y - rect.height + 1)));
    }
    const float nearest = hidden ? 0.75f : 0.25f;
    size_t i = 0;
    for (auto _ : state) {
        benchmark::DoNotOptimize(buffer.test(rects[i], nearest));
        i = (i + 1) % rects.size();
    }
    if ((buffer.test(rects[0], nearest) == Visibility::hidden) != hidden) {
        state.SkipWithError("the answer is wrong");
    }
}
BENCHMARK(test_rectangle)
    ->ArgNames({"size_px", "hidden", "cell_px"})
    ->ArgsProduct({{16, 64, 256, 1280}, {0, 1}, {1}});

void replay(benchmark::State& state, const Recording& recording, int cell_px, int threads)
{
    OccluderBuffer buffer({.cell_px = cell_px, .threads = threads});
    const View view = View::from_clip(recording.clip_from_world, recording.size_px,
                                      {DepthRange::zero_to_one, DepthOrder::near_is_large});
    for (auto _ : state) {
        buffer.begin(view);
        for (const Recording::Instance& instance : recording.instances) {
            buffer.add(instance.mesh, instance.world_from_mesh);
        }
        buffer.rasterize();
    }
    const std::span<const float> depth = buffer.depth();
    const auto covered =
        std::count_if(depth.begin(), depth.end(), [](float z) { return z < 1.0f; });
    state.counters["covered_percent"] =
        100.0 * static_cast<double>(covered) / static_cast<double>(depth.size());
    state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(recording.triangles));
}

} // namespace
} // namespace occlude::benchmarks

int main(int argc, char** argv)
{
    using namespace occlude::benchmarks;
    benchmark::Initialize(&argc, argv);
    std::vector<Recording> recordings;
    for (int i = 1; i < argc; ++i) {
        auto recording = read_recording(argv[i]);
        if (!recording) {
            std::fprintf(stderr, "%s: not a recording of occluders with matrices\n", argv[i]);
            return 2;
        }
        recordings.push_back(std::move(*recording));
    }
    for (size_t i = 0; i < recordings.size(); ++i) {
        for (const int cell_px : {1, 2}) {
            for (const int threads : {1, 2}) {
                const std::string name = "replay/" + std::to_string(i) +
                                         "/cell_px:" + std::to_string(cell_px) +
                                         "/threads:" + std::to_string(threads);
                benchmark::RegisterBenchmark(name.c_str(), [&recordings, i, cell_px,
                                                            threads](auto& state) {
                    replay(state, recordings[i], cell_px, threads);
                })->Unit(benchmark::kMillisecond);
            }
        }
    }
    benchmark::RunSpecifiedBenchmarks();
}
