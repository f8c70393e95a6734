#include <occlude/cull/depth_pyramid.h>

#include <glm/common.hpp>

#include <algorithm>

namespace occlude {

// A query looks at no more than kSpan x kSpan texels of one level.
static constexpr int kSpan = 4;

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
        texels_.assign(texels, 1.0f);
    }
    return empty() ? std::span<float>{}
                   : std::span{texels_}.first(static_cast<size_t>(levels_[0].size.x) *
                                              static_cast<size_t>(levels_[0].size.y));
}

// Two rows of `width` texels (or one row twice) into one of half the width, rounded up.
static void reduce_rows(const float* a, const float* b, int width, float* out)
{
    const int pairs = width / 2;
    for (int x = 0; x < pairs; ++x) {
        out[x] = farther(farther(a[2 * x], a[2 * x + 1]), farther(b[2 * x], b[2 * x + 1]));
    }
    if (width % 2 != 0) {
        out[pairs] = farther(a[width - 1], b[width - 1]);
    }
}

void DepthPyramid::build()
{
    for (size_t n = 1; n < levels_.size(); ++n) {
        const Level& fine = levels_[n - 1];
        const Level& coarse = levels_[n];
        const float* in = texels_.data() + fine.first;
        float* out = texels_.data() + coarse.first;
        for (int y = 0; y < coarse.size.y; ++y) {
            const float* a = in + static_cast<ptrdiff_t>(2 * y) * fine.size.x;
            const float* b = 2 * y + 1 < fine.size.y ? a + fine.size.x : a;
            reduce_rows(a, b, fine.size.x, out + static_cast<ptrdiff_t>(y) * coarse.size.x);
        }
    }
}

bool DepthPyramid::clip(const PixelRect& rect, Range& pixels) const
{
    pixels.low = {std::max(rect.x, 0), std::max(rect.y, 0)};
    // In 64 bits: a rectangle may be as wide as the numbers go.
    const glm::ivec2 last = size_px() - 1;
    const int64_t right = int64_t{rect.x} + rect.width - 1;
    const int64_t top = int64_t{rect.y} + rect.height - 1;
    pixels.high = {static_cast<int>(std::clamp<int64_t>(right, -1, last.x)),
                   static_cast<int>(std::clamp<int64_t>(top, -1, last.y))};
    return pixels.low.x <= pixels.high.x && pixels.low.y <= pixels.high.y;
}

int DepthPyramid::coarse_level(const Range& pixels) const
{
    int level = 0;
    while ((pixels.high.x >> level) - (pixels.low.x >> level) >= kSpan ||
           (pixels.high.y >> level) - (pixels.low.y >> level) >= kSpan) {
        ++level;
    }
    return level;
}

// One texel of a level, cut to `pixels`.
bool DepthPyramid::texel_hides(int level, glm::ivec2 at, const Range& pixels, float nearest) const
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

bool DepthPyramid::hides(const PixelRect& rect, float nearest, Refinement refinement) const
{
    Range pixels;
    if (!clip(rect, pixels)) {
        return true;
    }
    const int level = coarse_level(pixels);
    for (int y = pixels.low.y >> level; y <= pixels.high.y >> level; ++y) {
        for (int x = pixels.low.x >> level; x <= pixels.high.x >> level; ++x) {
            const bool hidden = refinement == Refinement::none
                                    ? texel(level, x, y) < nearest
                                    : texel_hides(level, {x, y}, pixels, nearest);
            if (!hidden) {
                return false;
            }
        }
    }
    return true;
}

// One texel of a level, cut to `pixels`, against what of the box is before it.
bool DepthPyramid::texel_hides(int level, glm::ivec2 at, const Range& pixels, const ScreenBox& box,
                               uint32_t& texels_left) const
{
    if (texels_left == 0) {
        return false;
    }
    --texels_left;
    const glm::ivec2 low = glm::max(glm::ivec2{at.x << level, at.y << level}, pixels.low);
    const glm::ivec2 high =
        glm::min(glm::ivec2{(at.x + 1) << level, (at.y + 1) << level} - 1, pixels.high);
    if (double{texel(level, at.x, at.y)} < box.nearest_over(low, high)) {
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

bool DepthPyramid::hides(const ScreenBox& box, const PixelRect& rect, uint32_t most_texels) const
{
    Range pixels;
    if (!clip(rect, pixels)) {
        return true;
    }
    const int level = coarse_level(pixels);
    for (int y = pixels.low.y >> level; y <= pixels.high.y >> level; ++y) {
        for (int x = pixels.low.x >> level; x <= pixels.high.x >> level; ++x) {
            if (!texel_hides(level, {x, y}, pixels, box, most_texels)) {
                return false;
            }
        }
    }
    return true;
}

float DepthPyramid::farthest_bound(const PixelRect& rect) const
{
    Range pixels;
    float bound = 0.0f;
    if (!clip(rect, pixels)) {
        return bound;
    }
    const int level = coarse_level(pixels);
    for (int y = pixels.low.y >> level; y <= pixels.high.y >> level; ++y) {
        for (int x = pixels.low.x >> level; x <= pixels.high.x >> level; ++x) {
            bound = farther(bound, texel(level, x, y));
        }
    }
    return bound;
}

} // namespace occlude
