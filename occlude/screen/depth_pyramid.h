// A pyramid of farthest depths over a depth buffer that was read back. It answers from a few texels
// whether every pixel of a rectangle is nearer than a given depth.
//
// Implements  the z pyramid of N. Greene, M. Kass, G. Miller, "Hierarchical Z-Buffer Visibility",
//             SIGGRAPH 1993, on the CPU and from a finished depth buffer.
// Deviations  Level sizes are rounded up, so that pixel (x, y) lies in texel (x >> n, y >> n) of
//             level n at every size of the target. The pyramid may start from any level, filled
//             with the farthest depths of tiles: finer levels are then unknown. A pyramid whose
//             sizes are rounded down, as the mip levels of a texture are, must read up to 3x3
//             texels into one at odd sizes, and is wrong (objects vanish) where it reads 2x2;
//             rounding up needs 2x2 and no rule for edges but "what is not there is not read".
// Guarantees  errs toward "not hidden": hides() is never true for a rectangle that has a pixel at
//             `nearest` or farther. With Refinement::pixels it is exact, or as exact as the tiles
//             that it starts from.
// Cost        build() reads each pixel once and writes a third as many values. A query reads up
//             to 16 texels, and with refinement few more unless the rectangle's border decides.
#pragma once

#include <occlude/core/aabb.h>
#include <occlude/core/query_device.h>
#include <occlude/screen/kernel.h>
#include <occlude/screen/projection.h>
#include <occlude/screen/screen_box.h>

#include <glm/vec2.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace occlude {

namespace detail {
struct PyramidLevel {
    glm::ivec2 size;
    size_t first; ///< of its texels, row by row from the bottom; 0 below the base level
};
struct TexelRange;
struct BoundsBlock;
} // namespace detail

class DepthPyramid {
public:
    enum class Refinement : uint8_t {
        none,   ///< only the coarse level where the rectangle spans at most 4x4 texels
        pixels, ///< coarse levels first, then down to the pixels where that decides
    };

    /// Targets of more pixels than this get no pyramid: no graphics API has them, and a host that
    /// asks for one by mistake must not run out of memory.
    static constexpr size_t kMaxPixels = size_t{1} << 28;

    /// Allocates the levels for a target of this size and returns level `base` to be filled, row by
    /// row from the bottom: window depth, 0 near to 1 far, no NaN. Above level 0, the values are
    /// the farthest depths of tiles of 2^base pixels along a side (QueryDevice::read_depth_tiles).
    /// Then call build(). A base beyond the last level, which has one texel, means the last. The
    /// span and the pyramid are empty for a target without pixels or of more than kMaxPixels.
    /// Precondition: base >= 0.
    std::span<float> resize(glm::ivec2 size_px, int base = 0);

    /// Computes the coarse levels from the base level.
    void build(Kernel kernel = Kernel::simd);

    bool empty() const { return levels_.empty(); }
    glm::ivec2 size_px() const { return empty() ? glm::ivec2{0} : levels_[0].size; }
    /// The finest level that has values.
    int base_level() const { return base_; }

    /// True only if every pixel of the target inside `rect` is nearer than `nearest`: then nothing
    /// in the rectangle at that depth or beyond can be seen. True where `rect` misses the target.
    bool hides(const PixelRect& rect, float nearest,
               Refinement refinement = Refinement::pixels) const;

    /// Like hides(), but tests the box instead of its rectangle, and reads at most `most_texels`
    /// texels. True only if every sample of anything in the box is farther than its pixel. `rect`
    /// is the rectangle of the box's ScreenBounds.
    bool hides(const ScreenBox& box, const PixelRect& rect, uint32_t most_texels) const
    {
        return hides_within(box, rect, most_texels);
    }
    /// The same, and subtracts the texels that it read from `texels_left`, which several boxes can
    /// share.
    bool hides_within(const ScreenBox& box, const PixelRect& rect, uint32_t& texels_left) const;

    /// Writes 1 to hidden[i] where the bounds are valid and hides(rect, near_depth, refinement),
    /// else 0, with either kernel. Precondition: hidden.size() == bounds.size().
    void hides(std::span<const ScreenBounds> bounds, Refinement refinement,
               std::span<uint8_t> hidden, Kernel kernel = Kernel::simd) const;

    /// The same for boxes in the world, which need not be inflated: project_boxes, then the
    /// comparison. Preconditions: the depth belongs to `view`; hidden.size() == boxes.size(). Hides
    /// nothing if the view and the pyramid differ in size.
    void hides(const View& view, std::span<const Aabb> boxes, Refinement refinement,
               std::span<uint8_t> hidden, Kernel kernel = Kernel::simd) const;

private:
    float texel(int level, int x, int y) const
    {
        const detail::PyramidLevel& l = levels_[static_cast<size_t>(level)];
        return texels_[l.first + static_cast<size_t>(y) * static_cast<size_t>(l.size.x) +
                       static_cast<size_t>(x)];
    }
    bool by_vectors(Kernel kernel) const;
    bool pixels_hide(const detail::TexelRange& pixels, float nearest) const;
    void block_hides(const detail::BoundsBlock& block, Refinement refinement,
                     std::span<uint8_t> hidden) const;
    bool texel_hides(int level, glm::ivec2 at, const detail::TexelRange& pixels,
                     float nearest) const;
    bool texel_hides(int level, glm::ivec2 at, const detail::TexelRange& pixels,
                     const ScreenBox& box, uint32_t& texels_left) const;

    std::vector<detail::PyramidLevel> levels_;
    int base_ = 0;
    std::vector<float> texels_; ///< from the base level up, and padding that is read but never used
};

} // namespace occlude
