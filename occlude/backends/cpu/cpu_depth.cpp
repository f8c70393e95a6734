// Reads the depth of a CpuDevice: pixel by pixel, or by the farthest of each tile.
#include <occlude/backends/cpu/cpu_device.h>

#include <occlude/core/assert.h>
#include <occlude/screen/depth_tiles.h>

#include <algorithm>

namespace occlude {

bool CpuDevice::read_depth(const PixelRect& rect, std::span<float> out)
{
    if (!transform_.usable()) {
        return false; // a view without a target; see begin_frame()
    }
    const bool fits = is_inside(rect, target_.size_px);
    OCCLUDE_ASSERT(fits, "read_depth outside of the target");
    if (!fits || out.size() != pixel_count(rect)) {
        return false;
    }
    for (int row = 0; row < rect.height; ++row) {
        const auto from = target_.depth.begin() +
                          (rect.y + row) * static_cast<ptrdiff_t>(target_.size_px.x) + rect.x;
        std::copy(from, from + rect.width, out.begin() + row * static_cast<ptrdiff_t>(rect.width));
    }
    return true;
}

bool CpuDevice::read_depth_tiles(int tile_px, std::span<float> out)
{
    if (!transform_.usable()) {
        return false; // like read_depth()
    }
    const bool legal = caps_.find_depth_read(tile_px) != nullptr && tile_px > 1;
    OCCLUDE_ASSERT(legal, "read_depth_tiles: caps().depth_reads lists the sizes of tiles");
    if (!legal || out.size() != pixel_count(tiles_in(target_.size_px, tile_px))) {
        return false;
    }
    farthest_of_tiles(target_.depth, target_.size_px, tile_px, out);
    return true;
}

} // namespace occlude
