#include <occlude/cull/parts/depth_tests.h>

#include <occlude/cull/parts/cull_frame.h>

#include <algorithm>
#include <array>
#include <bit>

namespace occlude {

// A tile is a texel of the pyramid's first level.
bool DepthTests::read_pixels_or_tiles(CullFrame& frame)
{
    const glm::ivec2 size = frame.view().size_px();
    if (tile_px_ > 1 && frame.caps().find_depth_read(tile_px_) != nullptr) {
        const int level = std::countr_zero(static_cast<uint32_t>(tile_px_));
        const std::span<float> tiles = pyramid_.resize(size, level);
        // A tile may be larger than the target, which then has no level of such texels.
        if (tiles.size() == pixel_count(tiles_in(size, tile_px_)) &&
            frame.read_depth_tiles(tile_px_, tiles)) {
            return true;
        }
    }
    return frame.read_depth({0, 0, size.x, size.y}, pyramid_.resize(size));
}

bool DepthTests::read(CullFrame& frame)
{
    frame.flush_draws();
    const glm::ivec2 size = frame.view().size_px();
    if (!frame.caps().read_depth || size.x <= 0 || size.y <= 0 ||
        frame.counters().items_drawn == 0) {
        return false;
    }
    known_ = read_pixels_or_tiles(frame);
    if (known_) {
        pyramid_.build();
        screen_ = ScreenSpace{frame.view(), samples_};
    }
    return known_;
}

void DepthTests::rectangles_hide(std::span<const ScreenBounds> bounds,
                                 std::span<uint8_t> hidden) const
{
    if (known_) {
        pyramid_.hides(bounds, DepthPyramid::Refinement::none, hidden);
    } else {
        std::ranges::fill(hidden, uint8_t{0});
    }
}

bool DepthTests::refined_hides(const Aabb& box, const ScreenBounds& bounds,
                               uint32_t max_texels) const
{
    if (!known_ || !bounds.valid || !refine_) {
        return false;
    }
    return max_texels > 0 ? pyramid_.hides(ScreenBox{screen_, box}, bounds.rect, max_texels)
                          : pyramid_.hides(bounds.rect, bounds.near_depth);
}

// If a map's condition number (an upper bound by Frobenius norms) is larger, rounding would
// dominate the planes of an object's boxes.
static constexpr float kWorstCondition = 1000.0f;

bool DepthTests::hides(const View& view, const ItemShapes::Placed& placed,
                       uint32_t max_texels) const
{
    const glm::mat4& map = placed.world_from_shape;
    const float shrink = inverse_stretch(map);
    const float condition = stretch(map) * shrink;
    // also false for NaN
    if (!known_ || !(condition > 0.0f && condition < kWorstCondition)) {
        return false;
    }
    const Inflation inflation = view.inflation().in(map, shrink);
    const ScreenSpace screen = screen_.in(map, inflation);
    std::array<ScreenBounds, 32> block;
    std::array<uint8_t, 32> hidden;
    uint32_t texels_left = max_texels;
    const std::span<const Aabb> boxes{*placed.shape};
    for (size_t first = 0; first < boxes.size(); first += block.size()) {
        const std::span<const Aabb> some =
            boxes.subspan(first, std::min(block.size(), boxes.size() - first));
        const std::span bounds = std::span{block}.first(some.size());
        project_boxes(view, map, inflation, some, bounds, Kernel::simd, samples_);
        rectangles_hide(bounds, std::span{hidden}.first(some.size()));
        for (size_t i = 0; i < some.size(); ++i) {
            const bool is_hidden =
                hidden[i] != 0 ||
                (refine_ && bounds[i].valid &&
                 pyramid_.hides_within(ScreenBox{screen, some[i]}, bounds[i].rect, texels_left));
            if (!is_hidden) {
                return false;
            }
        }
    }
    return true;
}

bool DepthTests::hides(const View& view, const Aabb& box, uint32_t max_texels) const
{
    if (!known_) {
        return false;
    }
    const ScreenBounds bounds = occlude::project(view, box, samples_);
    return (bounds.valid &&
            pyramid_.hides(bounds.rect, bounds.near_depth, DepthPyramid::Refinement::none)) ||
           refined_hides(box, bounds, max_texels);
}

} // namespace occlude
