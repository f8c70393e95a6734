// Random worlds: every algorithm, with random options, on random trees, over devices that fail at
// random, beside a picture of everything. `./dev soak` runs many more of them.
#include "worlds/run_case.h"
#include "worlds/spec.h"

#include <occlude/cull/registry.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

namespace occlude::worlds {
namespace {

constexpr uint64_t kCases = 40; // of each algorithm

class RandomWorlds : public testing::TestWithParam<std::string> {};

// Prints the seed, the failure, and the smallest world that fails.
TEST_P(RandomWorlds, ShowEveryPixelThatDrawingEverythingShows)
{
    Counts counts;
    for (uint64_t i = 0; i < kCases; ++i) {
        Spec spec = random_spec(1000 + i, GetParam());
        spec.ray_pixels = 50;
        const std::string failure = run_case(spec, counts);
        if (!failure.empty()) {
            const Spec smallest = shrink(spec);
            Counts ignored;
            FAIL() << failure << "\n  in " << to_text(spec)
                   << "\nsmallest: " << run_case(smallest, ignored) << "\n  in "
                   << to_text(smallest);
        }
    }
    // The worlds are evidence: images were compared, and much, but not all, was hidden.
    const AlgorithmInfo& info = *find_algorithm(GetParam());
    EXPECT_EQ(counts.cases, kCases);
    if (info.exact || GetParam() == "prioritized") {
        EXPECT_GT(counts.exact_cases, kCases / 2);
        EXPECT_GT(counts.pixels, 100000u);
        EXPECT_GT(counts.representative, counts.exact_cases / 2);
    }
    EXPECT_GT(counts.rays, 100u);
    // In such small worlds the cells of uniform_grid hide little. adaptive does not cull where
    // drawing everything costs less than testing.
    const bool may_draw_most = GetParam() == "uniform_grid" || GetParam() == "adaptive";
    if (may_draw_most) {
        EXPECT_GT(counts.hidden_share(), 0.01);
    } else if (info.exact && GetParam() != "frustum") {
        EXPECT_GT(counts.hidden_share(), 0.1);
        EXPECT_LT(counts.hidden_share(), 0.9);
    }
    if (counts.tests > 100 * kCases) {
        EXPECT_GT(counts.faults, kCases);
    }
}

std::vector<std::string> names()
{
    std::vector<std::string> all;
    for (const AlgorithmInfo& info : algorithms()) {
        all.push_back(info.name);
    }
    return all;
}

INSTANTIATE_TEST_SUITE_P(Every, RandomWorlds, testing::ValuesIn(names()),
                         [](const auto& info) { return info.param; });

// The picture of everything is compared with an independent one: rays that share no code with it.
TEST(RandomWorldsReference, AgreesWithRays)
{
    Counts counts;
    for (uint64_t seed = 1; seed <= 200; ++seed) {
        Spec spec = random_spec(seed, "frustum");
        spec.ray_pixels = ~0u;
        spec.rays_in_every_frame = true;
        spec.frames = 2;
        const std::string failure = run_case(spec, counts);
        ASSERT_EQ(failure, "") << to_text(spec);
    }
    EXPECT_GT(counts.rays, 100000u);
}

TEST(Spec, OfASeedIsTheSameAndRunsTheSame)
{
    for (uint64_t seed = 1; seed < 20; ++seed) {
        EXPECT_EQ(to_text(random_spec(seed)), to_text(random_spec(seed)));
        Counts first;
        Counts second;
        EXPECT_EQ(run_case(random_spec(seed), first), run_case(random_spec(seed), second));
        EXPECT_EQ(first.tests, second.tests);
        EXPECT_EQ(first.drawn, second.drawn);
    }
}

TEST(Spec, SimplerOnesAreSimplerUntilNoneIsLeft)
{
    Spec spec = random_spec(77);
    int steps = 0;
    while (!simpler(spec).empty()) {
        spec = simpler(spec).front();
        ASSERT_LT(++steps, 500) << "does not end at " << to_text(spec);
    }
    EXPECT_EQ(spec.items, 1u);
    EXPECT_EQ(spec.frames, 1u);
    EXPECT_TRUE(spec.options.empty());
}

} // namespace
} // namespace occlude::worlds
