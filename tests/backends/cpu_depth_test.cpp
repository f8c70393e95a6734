#include "backends/cpu_test_scene.h"

#include <gtest/gtest.h>

#include <vector>

namespace occlude {
namespace {

using namespace test;

TEST(CpuDevice, ReadsBackRectanglesOfDepth)
{
    TestScene scene;
    const ItemId item = scene.add_rectangle({2, 1}, {5, 3}, 0.5f);
    CpuDevice device(scene);
    device.begin_frame(pixel_view({8, 8}));
    device.draw({&item, 1}, DrawPass::shade);
    std::vector<float> out(4 * 2, -1.0f);
    ASSERT_TRUE(device.read_depth({1, 2, 4, 2}, out));
    EXPECT_EQ(out, (std::vector<float>{1.0f, 0.5f, 0.5f, 0.5f, 1.0f, 1.0f, 1.0f, 1.0f}));
    device.end_frame();
}

TEST(CpuDevice, ReadsBackTheFarthestDepthOfTiles)
{
    TestScene scene;
    const ItemId item = scene.add_rectangle({2, 0}, {8, 6}, 0.5f);
    CpuDevice device(scene);
    device.begin_frame(pixel_view({8, 8}));
    device.draw({&item, 1}, DrawPass::shade);
    std::vector<float> tiles(4 * 4, -1.0f);
    ASSERT_TRUE(device.read_depth_tiles(2, tiles));
    EXPECT_EQ(tiles, (std::vector<float>{1.0f, 0.5f, 0.5f, 0.5f, 1.0f, 0.5f, 0.5f, 0.5f, //
                                         1.0f, 0.5f, 0.5f, 0.5f, 1.0f, 1.0f, 1.0f, 1.0f}));
    std::vector<float> one(1);
    ASSERT_TRUE(device.read_depth_tiles(64, one)) << "a tile larger than the target";
    EXPECT_EQ(one[0], 1.0f);
    EXPECT_FALSE(device.read_depth_tiles(2, one)) << "no room";
    device.end_frame();
}

} // namespace
} // namespace occlude
