#include <occlude/cull/depth_tests.h>

#include <occlude/cull/cull_frame.h>

#include <algorithm>

namespace occlude {

bool DepthTests::read(CullFrame& frame)
{
    frame.flush_draws();
    const glm::ivec2 size = frame.view().size_px();
    if (!frame.caps().read_depth || size.x <= 0 || size.y <= 0 ||
        frame.counters().items_drawn == 0) {
        return false;
    }
    known_ = frame.read_depth({0, 0, size.x, size.y}, pyramid_.resize(size));
    if (known_) {
        pyramid_.build();
        screen_ = ScreenSpace{frame.view(), frame.caps().samples_at_pixel_centers
                                                ? SamplePositions::center
                                                : SamplePositions::anywhere};
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

bool DepthTests::closer(const Aabb& box, const ScreenBounds& bounds, uint32_t most_texels) const
{
    if (!known_ || !bounds.valid || !refine_) {
        return false;
    }
    return most_texels > 0 ? pyramid_.hides(ScreenBox{screen_, box}, bounds.rect, most_texels)
                           : pyramid_.hides(bounds.rect, bounds.near_depth);
}

bool DepthTests::hides(const View& view, const Aabb& box, uint32_t most_texels) const
{
    if (!known_) {
        return false;
    }
    const ScreenBounds bounds = project(view, box);
    return (bounds.valid &&
            pyramid_.hides(bounds.rect, bounds.near_depth, DepthPyramid::Refinement::none)) ||
           closer(box, bounds, most_texels);
}

} // namespace occlude
