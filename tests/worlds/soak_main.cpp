// Many random worlds, on all cores; writes what was compared as a page of the documentation.
//
// usage: soak CASES FIRST_SEED [PAGE.md COMMIT MACHINE]
// Exit status 0 if every world passed, 1 if one failed: its smallest form is printed.
#include "worlds/run_case.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace occlude::worlds {
namespace {

struct Failure {
    Spec spec;
    std::string what;
};

struct Results {
    std::map<std::string, Counts> by_algorithm;
    std::vector<Failure> failures;

    Counts total() const
    {
        Counts all;
        for (const auto& [name, counts] : by_algorithm) {
            all += counts;
        }
        return all;
    }
};

/// Of each world, some pixels of one frame are compared with rays, too. Of every 256th world it is
/// all pixels.
constexpr uint32_t kRayPixels = 100;
constexpr uint64_t kAllRaysEvery = 256;
constexpr size_t kMaxFailures = 20;

Results run(uint64_t cases, uint64_t first_seed)
{
    Results results;
    std::mutex guard;
    std::atomic<uint64_t> next{0};
    const auto work = [&] {
        for (uint64_t i = next++; i < cases; i = next++) {
            Spec spec = random_spec(first_seed + i);
            spec.rays_in_every_frame = i % kAllRaysEvery == 0;
            spec.ray_pixels = spec.rays_in_every_frame ? ~0u : kRayPixels;
            Counts counts;
            const std::string failure = run_case(spec, counts);
            const std::scoped_lock lock{guard};
            results.by_algorithm[spec.algorithm] += counts;
            if (!failure.empty()) {
                results.failures.push_back({spec, failure});
            }
            if (results.failures.size() >= kMaxFailures) {
                next = cases;
            }
            if (i % 5000 == 4999) {
                std::fprintf(stderr, "%llu worlds, %zu failures\n",
                             static_cast<unsigned long long>(i + 1), results.failures.size());
            }
        }
    };
    std::vector<std::thread> threads;
    for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i) {
        threads.emplace_back(work);
    }
    for (std::thread& thread : threads) {
        thread.join();
    }
    return results;
}

std::string row(const std::string& name, const Counts& c)
{
    char text[300];
    std::snprintf(
        text, sizeof text,
        "| %s | %llu | %llu | %llu | %llu | %llu | %llu | %llu | %llu | %.0f%% |\n", name.c_str(),
        static_cast<unsigned long long>(c.cases), static_cast<unsigned long long>(c.exact_cases),
        static_cast<unsigned long long>(c.representative),
        static_cast<unsigned long long>(c.frames), static_cast<unsigned long long>(c.pixels),
        static_cast<unsigned long long>(c.rays), static_cast<unsigned long long>(c.tests),
        static_cast<unsigned long long>(c.faults), 100.0 * c.hidden_share());
    return text;
}

std::string table(const Results& results)
{
    std::string text =
        "| algorithm | worlds | images compared | of these representative | frames | pixels | "
        "pixels compared with rays | tests | faults injected | items not drawn |\n"
        "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
    for (const auto& [name, counts] : results.by_algorithm) {
        text += row(name, counts);
    }
    return text + row("all", results.total());
}

std::string page(const Results& results, uint64_t cases, uint64_t first_seed,
                 const std::string& commit, const std::string& machine, double seconds)
{
    std::string text = "# Trust, in numbers\n\nWritten by `./dev soak " + std::to_string(cases) +
                       ' ' + std::to_string(first_seed) + "`; commit " + commit + ", " + machine +
                       ", " + std::to_string(static_cast<long>(seconds)) + " s.\n\n";
    text +=
        "Each world is a random scene, tree, algorithm with options, camera path and device "
        "with faults, by its seed\n(`tests/worlds/`). In every frame the image is compared "
        "with a picture of everything, drawn without frustum culling\nand without tests: the "
        "owner and the depth of every pixel. A validator checks each line of the device "
        "contract.\n\"Images compared\" counts the worlds whose culler promised exact images "
        "in every frame; a world is representative\nif 10 to 90% of the items in its frustums "
        "own no pixel. Rays share no code with the picture: 100 pixels of one\nframe of each "
        "world, all of every 256th, where five rays around the middle agree. The share of items "
        "that were not\ndrawn is below 0 where items that must never be culled are drawn "
        "outside of the frustum.\n\n";
    text += table(results);
    text += "\nWorlds that failed: " + std::to_string(results.failures.size()) + ".\n";
    for (const Failure& failure : results.failures) {
        text += "\n- " + failure.what + "; " + to_text(failure.spec) + "\n";
    }
    return text;
}

int soak(uint64_t cases, uint64_t first_seed, char** rest, int rest_count)
{
    const auto start = std::chrono::steady_clock::now();
    const Results results = run(cases, first_seed);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    std::fputs(table(results).c_str(), stdout);
    std::printf("%.0f s; %zu worlds failed\n", seconds, results.failures.size());
    for (const Failure& failure : results.failures) {
        const Spec smallest = shrink(failure.spec);
        Counts ignored;
        std::printf("\n%s\n  in %s\nsmallest: %s\n  in %s\n", failure.what.c_str(),
                    to_text(failure.spec).c_str(), run_case(smallest, ignored).c_str(),
                    to_text(smallest).c_str());
    }
    if (rest_count == 3) {
        std::ofstream{rest[0]} << page(results, cases, first_seed, rest[1], rest[2], seconds);
    }
    const Counts all = results.total();
    if (2 * all.representative < all.exact_cases) {
        std::puts("most worlds prove nothing: next to all of their items are seen, or hidden");
        return 1;
    }
    return results.failures.empty() ? 0 : 1;
}

} // namespace
} // namespace occlude::worlds

int main(int argc, char** argv)
{
    if (argc != 3 && argc != 6) {
        std::fputs("usage: soak CASES FIRST_SEED [PAGE.md COMMIT MACHINE]\n", stderr);
        return 2;
    }
    return occlude::worlds::soak(std::strtoull(argv[1], nullptr, 10),
                                 std::strtoull(argv[2], nullptr, 10), argv + 3, argc - 3);
}
