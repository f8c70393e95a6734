#include <occlude/core/depth_pyramid.h>

#include <occlude/core/assert.h>
#include <occlude/core/detail/pyramid_kernels.h>

#include <glm/common.hpp>

#include <algorithm>
#include <array>
#include <bit>

namespace occlude {

// The farther of two depths, in the form that compiles to one instruction.
static float farther(float a, float b)
{
    return a < b ? b : a;
}

std::span<float> DepthPyramid::resize(glm::ivec2 size_px)
{
    if (this->size_px() != size_px) {
        levels_.clear();
        size_t texels = 0;
        glm::ivec2 size = size_px;
        while (size.x > 0 && size.y > 0) {
            levels_.push_back({size, texels});
            texels += static_cast<size_t>(size.x) * static_cast<size_t>(size.y);
            if (size == glm::ivec2{1, 1}) {
                break;
            }
            size = (size + 1) / 2;
        }
        texels_.assign(texels + detail::kSpan - 1, 1.0f);
    }
    return empty() ? std::span<float>{}
                   : std::span{texels_}.first(static_cast<size_t>(levels_[0].size.x) *
                                              static_cast<size_t>(levels_[0].size.y));
}

void detail::reduce_rows(const float* a, const float* b, int width, float* out)
{
    const int pairs = width / 2;
    for (int x = 0; x < pairs; ++x) {
        out[x] = farther(farther(a[2 * x], a[2 * x + 1]), farther(b[2 * x], b[2 * x + 1]));
    }
    if (width % 2 != 0) {
        out[pairs] = farther(a[width - 1], b[width - 1]);
    }
}

void detail::build_levels(std::span<const PyramidLevel> levels, float* texels, ReduceRows reduce)
{
    for (size_t n = 1; n < levels.size(); ++n) {
        const PyramidLevel& fine = levels[n - 1];
        const PyramidLevel& coarse = levels[n];
        const float* in = texels + fine.first;
        float* out = texels + coarse.first;
        for (int y = 0; y < coarse.size.y; ++y) {
            const float* a = in + static_cast<ptrdiff_t>(2 * y) * fine.size.x;
            const float* b = 2 * y + 1 < fine.size.y ? a + fine.size.x : a;
            reduce(a, b, fine.size.x, out + static_cast<ptrdiff_t>(y) * coarse.size.x);
        }
    }
}

void DepthPyramid::build(Kernel kernel)
{
    if (kernel == Kernel::simd) {
        detail::build_levels_simd(levels_, texels_.data());
    } else {
        detail::build_levels(levels_, texels_.data(), &detail::reduce_rows);
    }
}

// One texel of a level, cut to `pixels`.
bool DepthPyramid::texel_hides(int level, glm::ivec2 at, const detail::TexelRange& pixels,
                               float nearest) const
{
    if (texel(level, at.x, at.y) < nearest) {
        return true;
    }
    const glm::ivec2 low{at.x << level, at.y << level};
    const glm::ivec2 high = glm::ivec2{low.x + (1 << level), low.y + (1 << level)} - 1;
    const bool whole = low.x >= pixels.low.x && low.y >= pixels.low.y &&
                       std::min(high.x, size_px().x - 1) <= pixels.high.x &&
                       std::min(high.y, size_px().y - 1) <= pixels.high.y;
    if (whole) {
        return false; // its farthest pixel is in the rectangle
    }
    // A texel of level 0 is one pixel of the rectangle, so that this one has children.
    const int fine = level - 1;
    const glm::ivec2 first{std::max(2 * at.x, pixels.low.x >> fine),
                           std::max(2 * at.y, pixels.low.y >> fine)};
    const glm::ivec2 last{std::min(2 * at.x + 1, pixels.high.x >> fine),
                          std::min(2 * at.y + 1, pixels.high.y >> fine)};
    for (int y = first.y; y <= last.y; ++y) {
        for (int x = first.x; x <= last.x; ++x) {
            if (!texel_hides(fine, {x, y}, pixels, nearest)) {
                return false;
            }
        }
    }
    return true;
}

// The farthest of at most kSpan x kSpan texels. Without a branch: the last row and the last column
// are looked at again where there are less.
float DepthPyramid::farthest_of(int level, const detail::TexelRange& texels) const
{
    const detail::PyramidLevel& l = levels_[static_cast<size_t>(level)];
    const glm::ivec2 last = texels.high - texels.low;
    const float* row =
        &texels_[l.first + static_cast<size_t>(texels.low.y) * static_cast<size_t>(l.size.x) +
                 static_cast<size_t>(texels.low.x)];
    float farthest = 0.0f;
    for (int y = 0; y < detail::kSpan; ++y) {
        for (int x = 0; x < detail::kSpan; ++x) {
            farthest = farther(farthest, row[std::min(x, last.x)]);
        }
        row += y < last.y ? l.size.x : 0;
    }
    return farthest;
}

bool DepthPyramid::hides(const PixelRect& rect, float nearest, Refinement refinement) const
{
    detail::TexelRange pixels;
    if (!detail::clip(rect, size_px(), pixels)) {
        return true;
    }
    const int level = detail::coarse_level(pixels);
    const detail::TexelRange texels{pixels.low >> level, pixels.high >> level};
    if (farthest_of(level, texels) < nearest) {
        return true;
    }
    if (refinement == Refinement::none) {
        return false;
    }
    const detail::TexelRange whole = detail::whole_texels(pixels, level, size_px());
    return (whole.is_empty() || farthest_of(level, whole) < nearest) &&
           border_hides(level, pixels, nearest);
}

// Texel by texel of the coarse level, where those that are whole hide.
bool DepthPyramid::border_hides(int level, const detail::TexelRange& pixels, float nearest) const
{
    for (int y = pixels.low.y >> level; y <= pixels.high.y >> level; ++y) {
        for (int x = pixels.low.x >> level; x <= pixels.high.x >> level; ++x) {
            if (!texel_hides(level, {x, y}, pixels, nearest)) {
                return false;
            }
        }
    }
    return true;
}

// One texel of a level, cut to `pixels`, against what of the box is before it.
bool DepthPyramid::texel_hides(int level, glm::ivec2 at, const detail::TexelRange& pixels,
                               const ScreenBox& box, uint32_t& texels_left) const
{
    if (texels_left == 0) {
        return false;
    }
    --texels_left;
    const glm::ivec2 low{std::max(at.x << level, pixels.low.x),
                         std::max(at.y << level, pixels.low.y)};
    const glm::ivec2 high{std::min(((at.x + 1) << level) - 1, pixels.high.x),
                          std::min(((at.y + 1) << level) - 1, pixels.high.y)};
    if (box.beyond(double{texel(level, at.x, at.y)}, low, high)) {
        return true;
    }
    if (level == 0) {
        return false;
    }
    const int fine = level - 1;
    for (int y = low.y >> fine; y <= high.y >> fine; ++y) {
        for (int x = low.x >> fine; x <= high.x >> fine; ++x) {
            if (!texel_hides(fine, {x, y}, pixels, box, texels_left)) {
                return false;
            }
        }
    }
    return true;
}

bool DepthPyramid::hides_within(const ScreenBox& box, const PixelRect& rect,
                                uint32_t& texels_left) const
{
    detail::TexelRange pixels;
    if (!detail::clip(rect, size_px(), pixels)) {
        return true;
    }
    // What is seen mostly is so in the middle.
    const glm::ivec2 middle = (pixels.low + pixels.high) / 2;
    if (!box.beyond(double{texel(0, middle.x, middle.y)}, middle, middle)) {
        return false;
    }
    const int level = detail::coarse_level(pixels);
    for (int y = pixels.low.y >> level; y <= pixels.high.y >> level; ++y) {
        for (int x = pixels.low.x >> level; x <= pixels.high.x >> level; ++x) {
            if (!texel_hides(level, {x, y}, pixels, box, texels_left)) {
                return false;
            }
        }
    }
    return true;
}

void DepthPyramid::hides(std::span<const ScreenBounds> bounds, Refinement refinement,
                         std::span<uint8_t> hidden, Kernel kernel) const
{
    OCCLUDE_ASSERT(bounds.size() == hidden.size(), "DepthPyramid::hides needs one result per box");
    if (kernel == Kernel::scalar) {
        for (size_t i = 0; i < bounds.size(); ++i) {
            const ScreenBounds& b = bounds[i];
            hidden[i] = b.valid && hides(b.rect, b.near_depth, refinement) ? 1 : 0;
        }
        return;
    }
    detail::coarse_hides_simd(levels_, texels_.data(), bounds, refinement, hidden.data());
    if (refinement == Refinement::none) {
        return;
    }
    for (size_t i = 0; i < bounds.size(); ++i) {
        if (hidden[i] == detail::kUndecided) {
            detail::TexelRange pixels;
            detail::clip(bounds[i].rect, size_px(), pixels);
            hidden[i] =
                border_hides(detail::coarse_level(pixels), pixels, bounds[i].near_depth) ? 1 : 0;
        }
    }
}

void DepthPyramid::hides(const View& view, std::span<const Aabb> boxes, Refinement refinement,
                         std::span<uint8_t> hidden, Kernel kernel) const
{
    OCCLUDE_ASSERT(boxes.size() == hidden.size(), "DepthPyramid::hides needs one result per box");
    if (view.size_px() != size_px()) {
        std::ranges::fill(hidden, uint8_t{0});
        return;
    }
    std::array<ScreenBounds, 64> block; // stays in the nearest cache
    for (size_t first = 0; first < boxes.size(); first += block.size()) {
        const size_t count = std::min(block.size(), boxes.size() - first);
        const std::span bounds = std::span{block}.first(count);
        project_boxes(view, boxes.subspan(first, count), bounds, kernel);
        hides(bounds, refinement, hidden.subspan(first, count), kernel);
    }
}

float DepthPyramid::farthest_bound(const PixelRect& rect) const
{
    detail::TexelRange pixels;
    if (!detail::clip(rect, size_px(), pixels)) {
        return 0.0f;
    }
    const int level = detail::coarse_level(pixels);
    return farthest_of(level, {pixels.low >> level, pixels.high >> level});
}

} // namespace occlude
