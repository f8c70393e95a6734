// What OccluderBuffer costs, as a page of tables in Markdown: rates of triangles by their size,
// times of rectangle tests, threads, and frames that other engines recorded.
//
//   occluder_benchmarks [--commit NAME] [--rounds N] [RECORDING.mocrec]...
//
// All cases take turns, round by round, and the least time of each counts: what disturbs the
// machine disturbs all of them alike. Cases of one thread are timed by the processor time of the
// program, those of several threads by the clock on the wall.
#include "recording.h"

#include <occlude/core/rng.h>

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <deque>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace occlude::benchmarks {
namespace {

constexpr glm::ivec2 kFillSize{1920, 1080};
constexpr glm::ivec2 kTestSize{1280, 720};
constexpr std::array kSizes{10, 50, 100, 500};
/// Triangles of these sizes per microsecond, by the MaskedOcclusionCulling library with AVX2 on one
/// thread of a machine of the kind that the committed page comes from.
constexpr std::array kReferenceRates{9.5, 3.5, 1.9, 0.24};
constexpr size_t kTrianglesPerMesh = 1024;
constexpr int kTestsPerRound = 20000;

enum class Order { random, near_first, far_first };
constexpr std::array kOrders{Order::random, Order::near_first, Order::far_first};

double wall_us()
{
    return std::chrono::duration<double, std::micro>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

double processor_us()
{
    return 1e6 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

struct Case {
    std::function<void()> run;
    bool one_thread = true;
    double least_us = std::numeric_limits<double>::max();
};

/// Cases in the order in which they were added; references to them stay valid.
class Cases {
public:
    const Case& add(std::function<void()> run, bool one_thread = true)
    {
        cases_.push_back({std::move(run), one_thread});
        return cases_.back();
    }
    void measure(int rounds)
    {
        for (int round = 0; round < rounds; ++round) {
            for (Case& c : cases_) {
                const auto now = c.one_thread ? &processor_us : &wall_us;
                const double begin = now();
                c.run();
                c.least_us = std::min(c.least_us, now() - begin);
            }
        }
    }

private:
    std::deque<Case> cases_;
};

// A view in which world units are pixels, and z is the window depth.
View pixel_view(glm::ivec2 size)
{
    const glm::mat4 clip =
        glm::ortho(0.0f, static_cast<float>(size.x), 0.0f, static_cast<float>(size.y), 0.0f, -1.0f);
    return View::from_clip(clip, size);
}

struct Triangles {
    std::vector<OccluderMesh> meshes;
    size_t count = 0;
};

// Of the last minute: how busy the machine is; 0 where nobody knows.
double load_average()
{
    double load = 0.0;
#if defined(__unix__) || defined(__APPLE__)
    getloadavg(&load, 1);
#endif
    return load;
}

// Right triangles with legs of `size` pixels at random places, that fill some ten screens.
Triangles make_triangles(int size, Order order)
{
    Rng rng(1);
    Triangles out;
    out.count = static_cast<size_t>(std::max(128, 10 * kFillSize.x * kFillSize.y / (size * size)));
    std::vector<float> depths(out.count);
    for (float& depth : depths) {
        depth = 0.1f + 0.8f * uniform01(rng.next());
    }
    if (order != Order::random) {
        std::ranges::sort(depths);
    }
    if (order == Order::far_first) {
        std::ranges::reverse(depths);
    }
    const auto leg = static_cast<float>(size);
    std::vector<glm::vec3> positions;
    std::vector<uint32_t> indices;
    for (size_t i = 0; i < out.count; ++i) {
        const glm::vec3 at{uniform01(rng.next()) * (static_cast<float>(kFillSize.x) - leg),
                           uniform01(rng.next()) * (static_cast<float>(kFillSize.y) - leg),
                           depths[i]};
        for (const glm::vec3& corner :
             {at, at + glm::vec3{leg, 0.0f, 0.0f}, at + glm::vec3{0.0f, leg, 0.0f}}) {
            indices.push_back(static_cast<uint32_t>(positions.size()));
            positions.push_back(corner);
        }
        if (indices.size() == 3 * kTrianglesPerMesh || i + 1 == out.count) {
            out.meshes.push_back(OccluderMesh::prepare(PositionStream(positions), indices));
            positions.clear();
            indices.clear();
        }
    }
    return out;
}

const Case& add_fill(Cases& cases, const Triangles& triangles, const OccluderBufferOptions& options,
                     bool one_thread = true)
{
    auto buffer = std::make_shared<OccluderBuffer>(options);
    const View view = pixel_view(kFillSize);
    return cases.add(
        [buffer, view, &triangles] {
            buffer->begin(view);
            for (const OccluderMesh& mesh : triangles.meshes) {
                buffer->add(mesh, glm::mat4{1.0f});
            }
            buffer->rasterize();
        },
        one_thread);
}

// Random rectangles of a size before or behind a wall that fills the view.
const Case& add_tests(Cases& cases, int size, bool hidden)
{
    auto buffer = std::make_shared<OccluderBuffer>(OccluderBufferOptions{.cell_px = 1});
    const std::vector<glm::vec3> corners{{-8.0f, -8.0f, 0.5f},
                                         {1300.0f, -8.0f, 0.5f},
                                         {1300.0f, 730.0f, 0.5f},
                                         {-8.0f, 730.0f, 0.5f}};
    const OccluderMesh wall =
        OccluderMesh::prepare(PositionStream(corners), std::vector<uint16_t>{0, 1, 2, 0, 2, 3});
    buffer->begin(pixel_view(kTestSize));
    buffer->add(wall, glm::mat4{1.0f});
    buffer->rasterize();
    Rng rng(1);
    std::vector<PixelRect> rects(1024);
    for (PixelRect& rect : rects) {
        rect.width = std::min(size, kTestSize.x);
        rect.height = std::min(size, kTestSize.y);
        rect.x = static_cast<int>(rng.below(static_cast<uint32_t>(kTestSize.x - rect.width + 1)));
        rect.y = static_cast<int>(rng.below(static_cast<uint32_t>(kTestSize.y - rect.height + 1)));
    }
    const float nearest = hidden ? 0.75f : 0.25f;
    return cases.add([buffer, rects, nearest, hidden] {
        int found_hidden = 0;
        for (int i = 0; i < kTestsPerRound; ++i) {
            const auto& rect = rects[static_cast<size_t>(i) % rects.size()];
            found_hidden += buffer->test(rect, nearest) == Visibility::hidden ? 1 : 0;
        }
        if (found_hidden != (hidden ? kTestsPerRound : 0)) {
            std::fprintf(stderr, "a rectangle test gave a wrong answer\n");
            std::exit(1);
        }
    });
}

struct Replay {
    const Case* timing = nullptr;
    std::shared_ptr<OccluderBuffer> buffer;
};

Replay add_replay(Cases& cases, const Recording& recording, int cell_px, int threads)
{
    Replay replay;
    replay.buffer = std::make_shared<OccluderBuffer>(
        OccluderBufferOptions{.cell_px = cell_px, .threads = threads});
    const View view = View::from_clip(recording.clip_from_world, recording.size_px,
                                      {DepthRange::zero_to_one, DepthOrder::near_is_large});
    replay.timing = &cases.add(
        [buffer = replay.buffer, view, &recording] {
            buffer->begin(view);
            for (const Recording::Instance& instance : recording.instances) {
                buffer->add(instance.mesh, instance.world_from_mesh);
            }
            buffer->rasterize();
        },
        threads == 1);
    return replay;
}

double covered_percent(const OccluderBuffer& buffer)
{
    const std::span<const float> depth = buffer.depth();
    const auto covered = std::ranges::count_if(depth, [](float z) { return z < 1.0f; });
    return 100.0 * static_cast<double>(covered) / static_cast<double>(depth.size());
}

void print_rates(const std::vector<std::vector<const Case*>>& rows,
                 const std::vector<std::vector<Triangles>>& triangles)
{
    std::printf("## Triangles\n\nMillions a second on one thread at 1920x1080; right triangles at "
                "random places, about ten layers, every one of constant depth. The last column is "
                "the rate that the MaskedOcclusionCulling library reaches with AVX2 on a quiet "
                "machine of this kind, with coverage of pixel centres.\n\n");
    std::printf("| legs | random depths | near first | far first | random, `cell_px` 2 | random, "
                "scalar | Gpixel/s, random | other library |\n|--:|--:|--:|--:|--:|--:|--:|--:|\n");
    for (size_t i = 0; i < rows.size(); ++i) {
        std::printf("| %d px |", kSizes[i]);
        const auto rate = [&](size_t k) {
            return static_cast<double>(triangles[i][0].count) / rows[i][k]->least_us;
        };
        for (size_t k = 0; k < rows[i].size(); ++k) {
            std::printf(" %.2f |", rate(k));
        }
        std::printf(" %.1f | %.2f |\n", rate(0) * kSizes[i] * kSizes[i] / 2.0 / 1000.0,
                    kReferenceRates[i]);
    }
}

int run(const std::vector<Recording>& recordings, const std::vector<std::string>& names, int rounds)
{
    Cases cases;
    std::vector<std::vector<Triangles>> triangles(kSizes.size());
    std::vector<std::vector<const Case*>> rates(kSizes.size());
    std::vector<std::array<const Case*, 2>> threads(kSizes.size());
    for (size_t i = 0; i < kSizes.size(); ++i) {
        for (const Order order : kOrders) {
            triangles[i].push_back(make_triangles(kSizes[i], order));
        }
        for (const Triangles& ordered : triangles[i]) {
            rates[i].push_back(&add_fill(cases, ordered, {.cell_px = 1}));
        }
        rates[i].push_back(&add_fill(cases, triangles[i][0], {.cell_px = 2}));
        rates[i].push_back(
            &add_fill(cases, triangles[i][0], {.cell_px = 1, .kernel = Kernel::scalar}));
        threads[i] = {&add_fill(cases, triangles[i][0], {.cell_px = 1, .threads = 1}, false),
                      &add_fill(cases, triangles[i][0], {.cell_px = 1, .threads = 2}, false)};
    }
    constexpr std::array kTests{16, 64, 256, 1280};
    std::vector<std::array<const Case*, 2>> tests;
    for (const int size : kTests) {
        tests.push_back({&add_tests(cases, size, false), &add_tests(cases, size, true)});
    }
    std::vector<std::array<Replay, 4>> replays;
    for (const Recording& r : recordings) {
        replays.push_back({add_replay(cases, r, 1, 1), add_replay(cases, r, 1, 2),
                           add_replay(cases, r, 2, 1), add_replay(cases, r, 2, 2)});
    }
    cases.measure(rounds);

    print_rates(rates, triangles);
    std::printf("\n## Two threads\n\nHow many times as fast as one, random depths; %u hardware "
                "threads were there, and what else they did counts against the second.\n\n",
                std::thread::hardware_concurrency());
    std::printf("| legs | times |\n|--:|--:|\n");
    for (size_t i = 0; i < kSizes.size(); ++i) {
        std::printf("| %d px | %.2f |\n", kSizes[i],
                    threads[i][0]->least_us / threads[i][1]->least_us);
    }
    std::printf("\n## Tests\n\nNanoseconds for a rectangle at 1280x720, `cell_px` 1.\n\n"
                "| side | visible | hidden |\n|--:|--:|--:|\n");
    for (size_t i = 0; i < tests.size(); ++i) {
        std::printf("| %d px | %.0f | %.0f |\n", kTests[i],
                    1000.0 * tests[i][0]->least_us / kTestsPerRound,
                    1000.0 * tests[i][1]->least_us / kTestsPerRound);
    }
    if (!recordings.empty()) {
        std::printf("\n## Recorded frames\n\nMilliseconds for all occluders of a frame, from "
                    "matrices to depth; covered: cells that hide something.\n\n"
                    "| recording | triangles | `cell_px` | 1 thread | 2 threads | covered |\n"
                    "|---|--:|--:|--:|--:|--:|\n");
    }
    for (size_t i = 0; i < replays.size(); ++i) {
        for (const size_t k : {size_t{0}, size_t{2}}) {
            std::printf("| %s | %zu | %zu | %.2f | %.2f | %.1f %% |\n", names[i].c_str(),
                        recordings[i].triangles, k / 2 + 1, replays[i][k].timing->least_us / 1000.0,
                        replays[i][k + 1].timing->least_us / 1000.0,
                        covered_percent(*replays[i][k].buffer));
        }
    }
    return 0;
}

} // namespace
} // namespace occlude::benchmarks

int main(int argc, char** argv)
{
    using namespace occlude::benchmarks;
    std::vector<Recording> recordings;
    std::vector<std::string> names;
    std::string commit;
    int rounds = 40;
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        if (argument == "--commit" && i + 1 < argc) {
            commit = argv[++i];
        } else if (argument == "--rounds" && i + 1 < argc) {
            rounds = std::max(std::atoi(argv[++i]), 1);
        } else if (auto recording = read_recording(argument)) {
            recordings.push_back(std::move(*recording));
            names.push_back(argument.substr(argument.find_last_of('/') + 1));
        } else {
            std::fprintf(stderr,
                         "%s: neither an option nor a recording of occluders with matrices\n",
                         argv[i]);
            return 2;
        }
    }
    std::printf("# Occluders\n\n");
    if (!commit.empty()) {
        std::printf("Written at commit %s by `occluder_benchmarks` ([benchmarks]"
                    "(../../benchmarks/README.md)). The least of %d rounds counts, in which all "
                    "cases take turns; cases of one thread by processor time. Load average %.0f "
                    "on %u hardware threads: with less of it, figures are better.\n\n",
                    commit.c_str(), rounds, load_average(), std::thread::hardware_concurrency());
    }
    return run(recordings, names, rounds);
}
