// Rectangles of pixels, and how many pixels there are.
#pragma once

#include <glm/vec2.hpp>

#include <cstddef>

namespace occlude {

/// A rectangle of pixels: x, y of the lower left one, then the size. Row 0 is the bottom row.
struct PixelRect {
    int x = 0;
    int y = 0;
    int width = 0;
    int height = 0;

    bool operator==(const PixelRect&) const = default;
};

/// How many pixels, or tiles, a grid of this size has. Precondition: no side is negative.
constexpr size_t pixel_count(glm::ivec2 size)
{
    return static_cast<size_t>(size.x) * static_cast<size_t>(size.y);
}

/// Precondition: the size is not negative.
constexpr size_t pixel_count(const PixelRect& rect)
{
    return pixel_count(glm::ivec2{rect.width, rect.height});
}

/// True if all pixels of `rect` are pixels of a target of this size, which a rectangle without
/// pixels may border on. False for negative sizes. Never overflows.
constexpr bool is_inside(const PixelRect& rect, glm::ivec2 size_px)
{
    return rect.x >= 0 && rect.y >= 0 && rect.width >= 0 && rect.height >= 0 &&
           rect.width <= size_px.x - rect.x && rect.height <= size_px.y - rect.y;
}

} // namespace occlude
