// lazy_grid over depth that the device reduced to tiles.
#include <occlude/cull/lazy_grid.h>

#include "support/trees.h"

#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

#include <algorithm>

namespace occlude {
namespace {

using test::look_ahead;
using test::row_tree;

// Between item 0 and item 1 of the row, as seen by look_ahead().
constexpr float kBackOfItem0 = 0.9911f;

TEST(LazyGrid, TilesAreReadOfTheWholeTargetWhereTheDeviceHasThem)
{
    const Hierarchy tree = row_tree(2);
    const auto frame_text = [&](uint32_t tile, float depth) {
        ScriptedDevice device;
        device.script().caps.read_depth = true;
        device.script().caps.depth_reads = {{.tile_px = 1}, {.tile_px = 8}};
        device.script().depth = [&](const PixelRect&, std::span<float> out) {
            std::fill(out.begin(), out.end(), depth);
            return true;
        };
        device.script().depth_tiles = [&](int, std::span<float> out) {
            std::fill(out.begin(), out.end(), depth);
            return true;
        };
        LazyGrid culler{tree,
                        {.join = LazyGridOptions::Join::target, .tests_at_once = 1, .tile = tile}};
        culler.cull(look_ahead(), device);
        return device.frame_text(0);
    };
    EXPECT_EQ(frame_text(8, kBackOfItem0), "draw 0\nread_depth_tiles 8\n");
    EXPECT_EQ(frame_text(16, kBackOfItem0), "draw 0\nread_depth 0 0 64x64\n")
        << "it has no such tiles";
    EXPECT_EQ(frame_text(8, 1.0f), "draw 0\nread_depth_tiles 8\ndraw 1\nflush\nread_depth_tiles 8\n"
                                   "draw 2\nflush\nread_depth_tiles 8\ndraw 3\n")
        << "drawing makes tiles outdated";
}

TEST(LazyGrid, TilesThatCannotBeReadHideNothing)
{
    const Hierarchy tree = row_tree(2);
    ScriptedDevice device;
    device.script().caps.read_depth = true;
    device.script().caps.depth_reads = {{.tile_px = 8}};
    device.script().depth_tiles = [](int, std::span<float>) { return false; };
    LazyGrid culler{tree, {.tile = 8}};
    culler.cull(look_ahead(), device);
    EXPECT_EQ(culler.drawn_items().size(), 4u);
}

} // namespace
} // namespace occlude
