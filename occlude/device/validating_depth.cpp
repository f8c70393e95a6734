// What a ValidatingDevice says of depth that is read.
#include <occlude/device/validating_device.h>

#include <algorithm>
#include <bit>

namespace occlude {

bool ValidatingDevice::read_depth(const PixelRect& rect, std::span<float> out)
{
    require_frame("read_depth");
    const glm::ivec2 size = view_.size_px();
    const bool inside = rect.x >= 0 && rect.y >= 0 && rect.width >= 0 && rect.height >= 0 &&
                        rect.width <= size.x - rect.x && rect.height <= size.y - rect.y;
    if (!inside) {
        report("precondition", "read_depth of a rectangle outside of the target");
        return false;
    }
    if (out.size() != static_cast<size_t>(rect.width) * static_cast<size_t>(rect.height)) {
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
    if (out.size() != static_cast<size_t>(tiles.x) * static_cast<size_t>(tiles.y)) {
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

// A tile that is nearer than one of its pixels hides what that pixel shows.
void ValidatingDevice::check_tiles(int tile_px, std::span<const float> tiles) const
{
    const std::vector<float> pixels = depth();
    const auto width = static_cast<size_t>(view_.size_px().x);
    const auto across = static_cast<size_t>(tiles_in(view_.size_px(), tile_px).x);
    const auto side = static_cast<size_t>(tile_px);
    for (size_t i = 0; i < pixels.size(); ++i) {
        const size_t x = i % width / side;
        const size_t y = i / width / side;
        if (tiles[y * across + x] < pixels[i]) {
            report("C3", "read_depth_tiles: tile (" + std::to_string(x) + ", " + std::to_string(y) +
                             ") is nearer than one of its pixels");
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
    std::vector<float> pixels(static_cast<size_t>(size.x) * static_cast<size_t>(size.y));
    const bool read = inner().read_depth({0, 0, size.x, size.y}, pixels);
    return read ? pixels : std::vector<float>{};
}

} // namespace occlude
