#include <occlude/screen/depth_pyramid.h>

#include <occlude/core/assert.h>
#include <occlude/core/detail/float4.h>
#include <occlude/screen/detail/pyramid_kernels.h>

#include <glm/common.hpp>

#include <algorithm>
#include <array>
#include <bit>

namespace occlude {

// The farther of two depths, in a form that compiles to one instruction.
static float farther(float a, float b)
{
    return a < b ? b : a;
}

std::span<float> DepthPyramid::resize(glm::ivec2 size_px, int base)
{
    OCCLUDE_ASSERT(base >= 0, "DepthPyramid::resize: the base is a level");
    if (this->size_px() != size_px) {
        levels_.clear();
        glm::ivec2 size = size_px;
        if (size.y > 0 &&
            static_cast<size_t>(std::max(size.x, 0)) > kMaxPixels / static_cast<size_t>(size.y)) {
            size = glm::ivec2{0};
        }
        while (size.x > 0 && size.y > 0) {
            levels_.push_back({size, 0});
            if (size == glm::ivec2{1, 1}) {
                break;
            }
            size = (size + 1) / 2;
        }
        base_ = -1;
    }
    const int last = std::max(static_cast<int>(levels_.size()) - 1, 0);
    if (std::min(base, last) != base_) {
        base_ = std::min(base, last);
        size_t texels = 0;
        for (size_t n = 0; n < levels_.size(); ++n) {
            levels_[n].first = texels;
            texels += n < static_cast<size_t>(base_) ? 0 : pixel_count(levels_[n].size);
        }
        texels_.assign(texels + detail::kSpan - 1, 1.0f);
    }
    return empty()
               ? std::span<float>{}
               : std::span{texels_}.first(pixel_count(levels_[static_cast<size_t>(base_)].size));
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

void detail::build_levels(std::span<const PyramidLevel> levels, int base, float* texels,
                          ReduceRows reduce)
{
    for (size_t n = static_cast<size_t>(base) + 1; n < levels.size(); ++n) {
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
        detail::build_levels_simd(levels_, base_, texels_.data());
    } else {
        detail::build_levels(levels_, base_, texels_.data(), &detail::reduce_rows);
    }
}

// One texel of a level, clipped to `pixels`.
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
    if (whole || level == base_) {
        return false; // its farthest pixel lies, or may lie, in the rectangle
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

// Without a branch: if there are fewer rows, the last one is read again.
static detail::Float4 farthest_of_columns(const detail::PyramidLevel& level, const float* texels,
                                          const detail::TexelRange& range)
{
    const int rows = range.high.y - range.low.y;
    const float* row = texels + level.first +
                       static_cast<size_t>(range.low.y) * static_cast<size_t>(level.size.x) +
                       static_cast<size_t>(range.low.x);
    detail::Float4 columns = detail::load4(row);
    for (int y = 1; y < detail::kSpan; ++y) {
        row += y <= rows ? level.size.x : 0;
        columns = detail::max4(columns, detail::load4(row));
    }
    return columns;
}

bool detail::all_nearer(const PyramidLevel& level, const float* texels, const TexelRange& range,
                        float nearest)
{
    const Float4 columns = farthest_of_columns(level, texels, range);
    const uint32_t inside = (2u << (range.high.x - range.low.x)) - 1;
    return (inside & ~bits_of(columns < splat(nearest))) == 0;
}

bool detail::coarse_hides(std::span<const PyramidLevel> levels, int base, const float* texels,
                          const PixelRect& rect, float nearest)
{
    TexelRange pixels;
    if (!clip(rect, levels[0].size, pixels)) {
        return true;
    }
    const int n = std::max(coarse_level(pixels), base);
    return all_nearer(levels[static_cast<size_t>(n)], texels, {pixels.low >> n, pixels.high >> n},
                      nearest);
}

bool DepthPyramid::hides(const PixelRect& rect, float nearest, Refinement refinement) const
{
    if (empty() || detail::coarse_hides(levels_, base_, texels_.data(), rect, nearest)) {
        return true;
    }
    if (refinement == Refinement::none) {
        return false;
    }
    detail::TexelRange pixels;
    detail::clip(rect, size_px(), pixels);
    return pixels_hide(pixels, nearest);
}

// Decides where a coarse test does not hide: first by the texels that lie wholly in the rectangle,
// then texel by texel.
bool DepthPyramid::pixels_hide(const detail::TexelRange& pixels, float nearest) const
{
    const int level = std::max(detail::coarse_level(pixels), base_);
    const detail::TexelRange whole = detail::whole_texels(pixels, level, size_px());
    if (!whole.is_empty() &&
        !detail::all_nearer(levels_[static_cast<size_t>(level)], texels_.data(), whole, nearest)) {
        return false;
    }
    for (int y = pixels.low.y >> level; y <= pixels.high.y >> level; ++y) {
        for (int x = pixels.low.x >> level; x <= pixels.high.x >> level; ++x) {
            if (!texel_hides(level, {x, y}, pixels, nearest)) {
                return false;
            }
        }
    }
    return true;
}

// Tests one texel of a level, clipped to `pixels`, against the part of the box before it.
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
    if (level == base_) {
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
    // The middle comes first: a visible box mostly shows there, and one texel is cheap. If the
    // texel is a tile, its test fails whenever the test of one of its pixels would.
    const glm::ivec2 middle = (pixels.low + pixels.high) / 2;
    if (!box.beyond(double{texel(base_, middle.x >> base_, middle.y >> base_)}, middle, middle)) {
        return false;
    }
    const int level = std::max(detail::coarse_level(pixels), base_);
    for (int y = pixels.low.y >> level; y <= pixels.high.y >> level; ++y) {
        for (int x = pixels.low.x >> level; x <= pixels.high.x >> level; ++x) {
            if (!texel_hides(level, {x, y}, pixels, box, texels_left)) {
                return false;
            }
        }
    }
    return true;
}

bool DepthPyramid::by_vectors(Kernel kernel) const
{
    return kernel == Kernel::simd && !empty() && levels_.size() <= detail::kMostVectorLevels;
}

// Coarse tests by vectors. Boxes that they do not hide are collected without a branch, and are then
// tested down to pixels.
void DepthPyramid::block_hides(const detail::BoundsBlock& block, Refinement refinement,
                               std::span<uint8_t> hidden) const
{
    detail::BoundsBlock::Field<uint8_t> coarse;
    detail::coarse_hides_simd(levels_, base_, texels_.data(), block, hidden.size(), coarse);
    std::copy_n(coarse.begin(), hidden.size(), hidden.begin());
    if (refinement == Refinement::none) {
        return;
    }
    detail::BoundsBlock::Field<uint8_t> open;
    size_t open_count = 0;
    for (size_t i = 0; i < hidden.size(); ++i) {
        open[open_count] = static_cast<uint8_t>(i);
        open_count += block.valid[i] != 0 && coarse[i] == 0 ? 1 : 0;
    }
    for (const uint8_t i : std::span{open}.first(open_count)) {
        detail::TexelRange pixels;
        detail::clip(block.rect(i), size_px(), pixels);
        hidden[i] = pixels_hide(pixels, block.near_depth[i]) ? 1 : 0;
    }
}

void DepthPyramid::hides(std::span<const ScreenBounds> bounds, Refinement refinement,
                         std::span<uint8_t> hidden, Kernel kernel) const
{
    OCCLUDE_ASSERT(bounds.size() == hidden.size(), "DepthPyramid::hides needs one result per box");
    if (bounds.size() != hidden.size()) {
        std::ranges::fill(hidden, uint8_t{0});
        return;
    }
    if (!by_vectors(kernel)) {
        for (size_t i = 0; i < bounds.size(); ++i) {
            const ScreenBounds& b = bounds[i];
            hidden[i] = b.valid && hides(b.rect, b.near_depth, refinement) ? 1 : 0;
        }
        return;
    }
    detail::BoundsBlock block;
    for (size_t first = 0; first < bounds.size(); first += block.kBoxes) {
        const size_t count = std::min(block.kBoxes, bounds.size() - first);
        for (size_t i = 0; i < count; ++i) {
            block.set(i, bounds[first + i]);
        }
        block_hides(block, refinement, hidden.subspan(first, count));
    }
}

void DepthPyramid::hides(const View& view, std::span<const Aabb> boxes, Refinement refinement,
                         std::span<uint8_t> hidden, Kernel kernel) const
{
    OCCLUDE_ASSERT(boxes.size() == hidden.size(), "DepthPyramid::hides needs one result per box");
    if (boxes.size() != hidden.size()) {
        std::ranges::fill(hidden, uint8_t{0});
        return;
    }
    if (view.size_px() != size_px()) {
        std::ranges::fill(hidden, uint8_t{0});
        return;
    }
    const detail::BoxProjector projector{view, SamplePositions::anywhere};
    if (!by_vectors(kernel)) {
        std::array<ScreenBounds, 64>
            some; // two loops, so that mispredictions in one do not slow down the other
        for (size_t first = 0; first < boxes.size(); first += some.size()) {
            const size_t count = std::min(some.size(), boxes.size() - first);
            for (size_t i = 0; i < count; ++i) {
                projector.project(boxes[first + i], some[i]);
            }
            hides(std::span{some}.first(count), refinement, hidden.subspan(first, count),
                  Kernel::scalar);
        }
        return;
    }
    detail::BoundsBlock block;
    for (size_t first = 0; first < boxes.size(); first += block.kBoxes) {
        const size_t count = std::min(block.kBoxes, boxes.size() - first);
        detail::project_boxes_simd(projector, boxes.subspan(first, count), block);
        block_hides(block, refinement, hidden.subspan(first, count));
    }
}

} // namespace occlude
