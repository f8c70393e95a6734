// Vectors of every kind that this processor has, any number of threads and any order of occluders
// give the depth that the scalar loops give, to the bit.
#include "cpu_fast/occluder_worlds.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <new>

namespace {
std::atomic<uint64_t> allocation_count{0};
}

// Not inlined: compilers would see malloc() meet delete, and warn.
__attribute__((noinline)) void* operator new(size_t size)
{
    ++allocation_count;
    if (void* memory = std::malloc(size > 0 ? size : 1)) {
        return memory;
    }
    throw std::bad_alloc{};
}
// Otherwise AddressSanitizer answers with memory of its own, which delete below would hand to free.
__attribute__((noinline)) void* operator new(size_t size, const std::nothrow_t&) noexcept
{
    ++allocation_count;
    void* memory = std::malloc(size > 0 ? size : 1);
    return memory;
}
// GCC 12 sees malloc and operator delete, and not that this one is its counterpart.
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"
void operator delete(void* memory) noexcept
{
    std::free(memory);
}
void operator delete(void* memory, size_t) noexcept
{
    std::free(memory);
}

namespace occlude {
namespace {

std::vector<float> depth_of(const test::OccluderWorld& world, const test::PreparedWorld& prepared,
                            const OccluderBufferOptions& options)
{
    OccluderBuffer buffer(options);
    rasterize(buffer, world, prepared);
    return {buffer.depth().begin(), buffer.depth().end()};
}

constexpr uint64_t kWorlds = 10000;

TEST(TileKernels, VectorsGiveTheBitsOfTheScalarLoopsOverTenThousandWorlds)
{
    const std::vector<int64_t> targets = hwy::SupportedAndGeneratedTargets();
    ASSERT_FALSE(targets.empty());
    size_t hiding = 0;
    for (uint64_t seed = 1; seed <= kWorlds; ++seed) {
        const test::OccluderWorld world = test::random_occluder_world(
            seed, {66 + static_cast<int>(seed % 9), 35}, 1 + static_cast<uint32_t>(seed % 2));
        const test::PreparedWorld prepared(world);
        const std::vector<float> scalar =
            depth_of(world, prepared, {.cell_px = 1, .kernel = Kernel::scalar});
        hiding += std::ranges::count_if(scalar, [](float z) { return z < 1.0f; }) > 20 ? 1 : 0;
        for (const int64_t target : targets) {
            hwy::SetSupportedTargetsForTest(target);
            hwy::GetChosenTarget().Update(hwy::SupportedTargets());
            ASSERT_EQ(scalar, depth_of(world, prepared, {.cell_px = 1}))
                << hwy::TargetName(target) << ", seed " << seed;
        }
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    EXPECT_GT(hiding, kWorlds / 3) << "worlds that hide anything";
}

TEST(OccluderBufferThreads, NeitherThreadsNorTheOrderOfOccludersChangeABit)
{
    for (uint64_t seed = 1; seed <= 40; ++seed) {
        test::OccluderWorld world = test::random_occluder_world(seed, {641, 359}, 20);
        const std::vector<float> one =
            depth_of(world, test::PreparedWorld(world), {.cell_px = 2, .threads = 1});
        std::ranges::reverse(world.sources);
        const test::PreparedWorld prepared(world);
        ASSERT_EQ(one, depth_of(world, prepared, {.cell_px = 2, .threads = 2})) << seed;
        ASSERT_EQ(one, depth_of(world, prepared, {.cell_px = 2, .threads = 0})) << seed;
    }
}

TEST(OccluderBufferMemory, FramesAfterTheLargestAllocateNothing)
{
    const test::OccluderWorld world = test::random_occluder_world(7, {641, 359}, 30);
    const test::PreparedWorld prepared(world);
    OccluderBuffer buffer;
    rasterize(buffer, world, prepared);
    std::vector<Visibility> results(100);
    const std::vector<Aabb> boxes(100, Aabb{glm::vec3{-1.0f}, glm::vec3{1.0f}});
    buffer.test(boxes, results);
    const uint64_t before = allocation_count;
    for (int frame = 0; frame < 3; ++frame) {
        rasterize(buffer, world, prepared);
        buffer.test(boxes, results);
    }
    EXPECT_EQ(allocation_count, before);
}

} // namespace
} // namespace occlude
