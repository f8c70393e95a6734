// The checks of a ValidatingDevice on depth that is read.
#include <occlude/device/validating_device.h>

#include <occlude/screen/depth_tiles.h>

#include <algorithm>
#include <bit>

namespace occlude {

bool ValidatingDevice::read_depth(const PixelRect& rect, std::span<float> out)
{
    require_frame("read_depth");
    if (!is_inside(rect, view_.size_px())) {
        report("precondition", "read_depth of a rectangle outside of the target");
        return false;
    }
    if (out.size() != pixel_count(rect)) {
        report("precondition", "read_depth was given room for " + std::to_string(out.size()) +
                                   " pixels, not for its rectangle");
        return false;
    }
    if (!inner().read_depth(rect, out)) {
        return false;
    }
    check_depths(out);
    return true;
}

void ValidatingDevice::check_depths(std::span<const float> depths) const
{
    const bool legal =
        std::all_of(depths.begin(), depths.end(), [](float z) { return z >= 0.0f && z <= 1.0f; });
    if (!legal) {
        report("precondition", "the device read depth outside of 0..1");
    }
}

bool ValidatingDevice::read_depth_tiles(int tile_px, std::span<float> out)
{
    require_frame("read_depth_tiles");
    if (tile_px < 2 || !std::has_single_bit(static_cast<uint32_t>(tile_px))) {
        report("precondition", "read_depth_tiles of tiles of " + std::to_string(tile_px) +
                                   " pixels: name a power of two above 1");
        return false;
    }
    const glm::ivec2 tiles = tiles_in(view_.size_px(), tile_px);
    if (out.size() != pixel_count(tiles)) {
        report("precondition", "read_depth_tiles was given room for " + std::to_string(out.size()) +
                                   " values, not for the " + std::to_string(tiles.x) + "x" +
                                   std::to_string(tiles.y) + " tiles of the target");
        return false;
    }
    if (!inner().read_depth_tiles(tile_px, out)) {
        return false;
    }
    check_depths(out);
    if (options_.depth_checks != DepthChecks::off) {
        check_tiles(tile_px, out);
    }
    return true;
}

// A tile that is nearer than one of its pixels hides things that this pixel shows.
void ValidatingDevice::check_tiles(int tile_px, std::span<const float> tiles) const
{
    const std::vector<float> pixels = depth();
    if (pixels.empty()) {
        return;
    }
    std::vector<float> farthest(tiles.size());
    farthest_of_tiles(pixels, view_.size_px(), tile_px, farthest);
    const auto across = static_cast<size_t>(tiles_in(view_.size_px(), tile_px).x);
    for (size_t i = 0; i < tiles.size(); ++i) {
        if (tiles[i] < farthest[i]) {
            report("C3", "read_depth_tiles: tile (" + std::to_string(i % across) + ", " +
                             std::to_string(i / across) + ") is nearer than one of its pixels");
            return;
        }
    }
}

std::vector<float> ValidatingDevice::depth() const
{
    const glm::ivec2 size = view_.size_px();
    if (options_.depth_checks == DepthChecks::off || !inner().caps().read_depth || size.x <= 0 ||
        size.y <= 0) {
        return {};
    }
    std::vector<float> pixels(pixel_count(size));
    const bool read = inner().read_depth({0, 0, size.x, size.y}, pixels);
    return read ? pixels : std::vector<float>{};
}

} // namespace occlude
