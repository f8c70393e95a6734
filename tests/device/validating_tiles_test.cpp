#include "device_test_helpers.h"
#include "validating_bench.h"

#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace occlude {
namespace {

using test::Bench;

TEST(ValidatingDevice, TilesOfDepthAreHeldAgainstTheirPixels)
{
    ScriptedDevice scripted(
        {.caps = {.name = "depth", .read_depth = true, .depth_reads = {{.tile_px = 16}}}});
    Bench bench(scripted, ValidatingDevice::DepthChecks::around_batches);
    bench.device.begin_frame(test::camera());
    std::array<float, 16> tiles{};
    EXPECT_TRUE(bench.device.read_depth_tiles(16, tiles));
    EXPECT_EQ(bench.broken(), "");
    EXPECT_FALSE(bench.device.read_depth_tiles(12, tiles));
    EXPECT_EQ(bench.broken(), "precondition ");
    EXPECT_FALSE(bench.device.read_depth_tiles(32, tiles));
    EXPECT_EQ(bench.broken(), "precondition ");
    scripted.script().depth_tiles = [](int, std::span<float> out) {
        std::fill(out.begin(), out.end(), 1.0f);
        out[5] = 0.5f;
        return true;
    };
    EXPECT_TRUE(bench.device.read_depth_tiles(16, tiles));
    EXPECT_EQ(bench.broken(), "C3 ") << "all pixels are at 1";
    bench.device.end_frame();
}

} // namespace
} // namespace occlude
