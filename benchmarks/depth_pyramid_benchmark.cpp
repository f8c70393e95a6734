// Tests of boxes against a depth buffer on the CPU, per second and core, with and without vector
// instructions. A test covers all work from the box in the world to the answer: the projection
// (inflation, near plane, rounding) and the comparison with at most 4x4 texels. `pixels` adds the
// refinement.
#include <occlude/core/rng.h>
#include <occlude/screen/depth_pyramid.h>
#include <occlude/screen/projection.h>

#include <benchmark/benchmark.h>
#include <glm/ext/matrix_clip_space.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

namespace occlude {
namespace {

constexpr glm::ivec2 kSize{1280, 720};
constexpr size_t kBoxes = 16384;

View view()
{
    const float aspect = static_cast<float>(kSize.x) / static_cast<float>(kSize.y);
    return View::from_clip(glm::perspectiveRH_NO(glm::radians(60.0f), aspect, 0.1f, 1000.0f),
                           kSize);
}

// Window depth at a distance before that camera.
float depth_at(float distance)
{
    return (1000.0f / 999.9f) * (1.0f - 0.1f / distance);
}

// A street: the ground to the horizon, the sky, and house fronts at many distances before them.
void fill(std::span<float> depth)
{
    Rng rng(7);
    for (int y = 0; y < kSize.y; ++y) {
        const float below = 0.5f - static_cast<float>(y) / static_cast<float>(kSize.y);
        const float ground = below > 0.001f ? depth_at(std::min(1.0f / below, 999.0f)) : 1.0f;
        std::fill_n(depth.begin() + static_cast<ptrdiff_t>(y) * kSize.x, kSize.x, ground);
    }
    for (int house = 0; house < 150; ++house) {
        const float distance = 10.0f * std::pow(40.0f, rng.range(0.0f, 1.0f));
        const int width = static_cast<int>(3000.0f / distance);
        const int height = static_cast<int>(rng.range(4000.0f, 9000.0f) / distance);
        const int left = static_cast<int>(rng.below(static_cast<uint32_t>(kSize.x))) - width / 2;
        const int base = kSize.y / 2 - static_cast<int>(600.0f / distance);
        for (int y = std::max(base, 0); y < std::min(base + height, kSize.y); ++y) {
            for (int x = std::max(left, 0); x < std::min(left + width, kSize.x); ++x) {
                float& d = depth[static_cast<size_t>(y) * kSize.x + static_cast<size_t>(x)];
                d = std::min(d, depth_at(distance));
            }
        }
    }
}

const DepthPyramid& pyramid()
{
    static const DepthPyramid built = [] {
        DepthPyramid p;
        fill(p.resize(kSize));
        p.build();
        return p;
    }();
    return built;
}

// Boxes 4 to 64 pixels wide, most of them small, all over the lower two thirds of the screen.
const std::vector<Aabb>& boxes()
{
    static const std::vector<Aabb> made = [] {
        Rng rng(8);
        std::vector<Aabb> result(kBoxes);
        for (Aabb& box : result) {
            const float distance = 5.0f * std::pow(100.0f, rng.range(0.0f, 1.0f));
            const float px = 2.0f * distance * std::tan(glm::radians(30.0f)) / kSize.y;
            const glm::vec3 center{rng.range(-620.0f, 620.0f) * px, rng.range(-350.0f, 120.0f) * px,
                                   -distance};
            const float size = px * 4.0f * std::pow(16.0f, rng.range(0.0f, 1.0f));
            const glm::vec3 half =
                0.5f * size * glm::vec3{1.0f, rng.range(0.5f, 1.0f), rng.range(0.5f, 1.0f)};
            box = {center - half, center + half};
        }
        return result;
    }();
    return made;
}

Kernel kernel_of(const benchmark::State& state)
{
    return state.range(0) != 0 ? Kernel::simd : Kernel::scalar;
}

void count_items(benchmark::State& state, size_t each)
{
    state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(each));
}

void test_boxes(benchmark::State& state)
{
    const View from = view();
    const auto refinement =
        state.range(1) != 0 ? DepthPyramid::Refinement::pixels : DepthPyramid::Refinement::none;
    std::vector<uint8_t> hidden(kBoxes);
    for (auto _ : state) {
        pyramid().hides(from, boxes(), refinement, hidden, kernel_of(state));
        benchmark::DoNotOptimize(hidden.data());
    }
    count_items(state, kBoxes);
    state.counters["hidden"] =
        static_cast<double>(std::ranges::count(hidden, uint8_t{1})) / double{kBoxes};
}

void project_only(benchmark::State& state)
{
    const View from = view();
    std::vector<ScreenBounds> bounds(kBoxes);
    for (auto _ : state) {
        project_boxes(from, boxes(), bounds, kernel_of(state));
        benchmark::DoNotOptimize(bounds.data());
    }
    count_items(state, kBoxes);
}

void compare_only(benchmark::State& state)
{
    std::vector<ScreenBounds> bounds(kBoxes);
    std::vector<uint8_t> hidden(kBoxes);
    project_boxes(view(), boxes(), bounds);
    for (auto _ : state) {
        pyramid().hides(bounds, DepthPyramid::Refinement::none, hidden, kernel_of(state));
        benchmark::DoNotOptimize(hidden.data());
    }
    count_items(state, kBoxes);
}

void build_pyramid(benchmark::State& state)
{
    DepthPyramid p = pyramid();
    for (auto _ : state) {
        p.build(kernel_of(state));
        benchmark::DoNotOptimize(p);
    }
    count_items(state, static_cast<size_t>(kSize.x) * static_cast<size_t>(kSize.y));
}

BENCHMARK(test_boxes)->ArgNames({"simd", "pixels"})->ArgsProduct({{0, 1}, {0, 1}});
BENCHMARK(project_only)->ArgName("simd")->Arg(0)->Arg(1);
BENCHMARK(compare_only)->ArgName("simd")->Arg(0)->Arg(1);
BENCHMARK(build_pyramid)->ArgName("simd")->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);

} // namespace
} // namespace occlude
