#include <occlude/cull/parts/occlusion_grid.h>

#include <occlude/core/assert.h>

#include <glm/common.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace occlude {

PixelRect intersection(const PixelRect& a, const PixelRect& b)
{
    const int left = std::max(a.x, b.x);
    const int bottom = std::max(a.y, b.y);
    const int right = std::min(a.x + a.width, b.x + b.width);
    const int top = std::min(a.y + a.height, b.y + b.height);
    if (left >= right || bottom >= top) {
        return {};
    }
    return {left, bottom, right - left, top - bottom};
}

void OcclusionGrid::reset(glm::ivec2 size_px, int cell_size)
{
    OCCLUDE_ASSERT(cell_size >= 1, "a cell has at least one pixel");
    size_px_ = {std::max(size_px.x, 0), std::max(size_px.y, 0)};
    cell_size_ = cell_size;
    const auto cells_along = [&](int pixels) {
        return pixels / cell_size_ + (pixels % cell_size_ != 0 ? 1 : 0);
    };
    cells_in_ = {cells_along(size_px_.x), cells_along(size_px_.y)};
    cells_.assign(pixel_count(cells_in_), Cell{});
}

PixelRect OcclusionGrid::pixels(glm::ivec2 cell) const
{
    const int x = cell.x * cell_size_;
    const int y = cell.y * cell_size_;
    return {x, y, std::min(cell_size_, size_px_.x - x), std::min(cell_size_, size_px_.y - y)};
}

CellRange OcclusionGrid::touched(const PixelRect& rect) const
{
    OCCLUDE_ASSERT(rect.x >= 0 && rect.y >= 0 && rect.x + rect.width <= size_px_.x &&
                       rect.y + rect.height <= size_px_.y,
                   "the rectangle must lie inside the target");
    if (rect.width <= 0 || rect.height <= 0) {
        return {};
    }
    return {
        {rect.x / cell_size_, rect.y / cell_size_},
        {(rect.x + rect.width - 1) / cell_size_ + 1, (rect.y + rect.height - 1) / cell_size_ + 1}};
}

CellRange OcclusionGrid::internal(const PixelRect& rect) const
{
    CellRange cells = touched(rect);
    const auto trim = [&](int axis, int low, int end, int target_end) {
        if (low % cell_size_ != 0) {
            ++cells.begin[axis];
        }
        if (end % cell_size_ != 0 && end != target_end) {
            --cells.end[axis];
        }
        cells.end[axis] = std::max(cells.begin[axis], cells.end[axis]);
    };
    trim(0, rect.x, rect.x + rect.width, size_px_.x);
    trim(1, rect.y, rect.y + rect.height, size_px_.y);
    return cells;
}

void OcclusionGrid::mark_drawn(const PixelRect& rect)
{
    const CellRange cells = touched(rect);
    for (int y = cells.begin.y; y < cells.end.y; ++y) {
        for (int x = cells.begin.x; x < cells.end.x; ++x) {
            const PixelRect all = pixels({x, y});
            const PixelRect drawn = intersection(all, rect);
            Cell& c = cell({x, y});
            c.untouched = false;
            c.copied = false;
            c.known_free = kUnknown;
            c.covered += static_cast<float>(drawn.width) * static_cast<float>(drawn.height) /
                         (static_cast<float>(all.width) * static_cast<float>(all.height));
        }
    }
}

void OcclusionGrid::update(glm::ivec2 at, float zfar)
{
    Cell& c = cell(at);
    c.zfar = std::min(c.zfar, zfar); // Answers of a device that errs toward far must not raise a
                                     // known bound.
    c.known_free = c.zfar;
}

void OcclusionGrid::learn_hidden(glm::ivec2 at, float depth)
{
    Cell& c = cell(at);
    c.zfar = std::min(c.zfar, std::nextafter(depth, 0.0f));
}

void OcclusionGrid::learn_free(glm::ivec2 at, float depth)
{
    Cell& c = cell(at);
    c.known_free = std::max(c.known_free, depth);
}

float farthest_depth(const float* depths, size_t width, size_t height, size_t stride)
{
    // Several lanes, because compilers do not reorder a maximum of floats.
    constexpr size_t kLanes = 8;
    std::array<float, kLanes> lanes{};
    for (size_t y = 0; y < height; ++y) {
        const float* row = depths + y * stride;
        size_t x = 0;
        for (; x + kLanes <= width; x += kLanes) {
            for (size_t i = 0; i < kLanes; ++i) {
                lanes[i] = row[x + i] > lanes[i] ? row[x + i] : lanes[i];
            }
        }
        for (; x < width; ++x) {
            lanes[0] = row[x] > lanes[0] ? row[x] : lanes[0];
        }
    }
    return *std::max_element(lanes.begin(), lanes.end());
}

bool hides(const float* depths, size_t stride, const PixelRect& part, const ScreenBox& box)
{
    constexpr int kBlock = 8; // Pixels per block: mostly one of them decides for the whole block.
    const auto at = [&](int x, int y) {
        return depths + static_cast<size_t>(y) * stride + static_cast<size_t>(x);
    };
    const glm::ivec2 origin{part.x, part.y};
    for (int y = 0; y < part.height; y += kBlock) {
        for (int x = 0; x < part.width; x += kBlock) {
            const glm::ivec2 low{x, y};
            const glm::ivec2 end = glm::min(low + kBlock, glm::ivec2{part.width, part.height});
            const glm::uvec2 size{end - low};
            if (box.beyond(farthest_depth(at(x, y), size.x, size.y, stride), origin + low,
                           origin + end - 1)) {
                continue;
            }
            for (int py = y; py < end.y; ++py) {
                for (int px = x; px < end.x; ++px) {
                    const glm::ivec2 pixel = origin + glm::ivec2{px, py};
                    if (!box.beyond(*at(px, py), pixel, pixel)) {
                        return false;
                    }
                }
            }
        }
    }
    return true;
}

} // namespace occlude
