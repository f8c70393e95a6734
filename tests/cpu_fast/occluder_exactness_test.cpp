// What hides must hide from every sample of every pixel, whoever draws.
#include "cpu_fast/occluder_worlds.h"

#include <gtest/gtest.h>

namespace occlude {
namespace {

// The worst that snapping to 1/256 pixel and float transforms may do, with some to spare.
constexpr double kMovedPx = 1.0 / 128.0;

TEST(OccluderExactness, ADeviceSeesNothingBehindTheDepthOfACell)
{
    constexpr glm::ivec2 kSize{97, 61};
    size_t covered = 0;
    size_t coverable = 0;
    size_t cells = 0;
    for (uint64_t seed = 1; seed <= 150; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Rng rng(seed);
        const test::OccluderWorld world =
            test::random_occluder_world(seed, kSize, 1 + rng.below(3));
        const test::PreparedWorld prepared(world);
        const test::MovedTriangles truth(world, kMovedPx, seed);
        OccluderBuffer buffer({.cell_px = 1 + static_cast<int>(rng.below(3))});
        rasterize(buffer, world, prepared);
        const double cell = buffer.cell_px();
        for (int y = 0; y < buffer.size_cells().y; ++y) {
            for (int x = 0; x < buffer.size_cells().x; ++x) {
                const float depth =
                    buffer.depth()[static_cast<size_t>(y * buffer.size_cells().x + x)];
                ++cells;
                double farthest = 0.0;
                const auto look = [&](double u, double v) {
                    farthest = std::max(farthest, truth.depth_at(std::min((x + u) * cell, 97.0),
                                                                 std::min((y + v) * cell, 61.0)));
                };
                for (int corner = 0; corner < 4; ++corner) {
                    look(corner % 2, corner / 2);
                }
                coverable += farthest < 1.0 ? 1 : 0;
                if (depth >= 1.0f) {
                    continue;
                }
                ++covered;
                for (int i = 0; i < 5; ++i) {
                    look(double{uniform01(rng.next())}, double{uniform01(rng.next())});
                }
                ASSERT_LE(farthest, double{depth}) << "cell " << x << ", " << y;
            }
        }
    }
    // Representative, and useful.
    EXPECT_GT(coverable, cells / 10);
    EXPECT_GT(covered, coverable / 2);
    EXPECT_LT(covered, cells * 9 / 10);
}

} // namespace
} // namespace occlude
