// A wall that slides past lights, and the exact visible share of each, for every device that draws.
#pragma once

#include "support/trees.h"

#include <occlude/effects/flare_visibility.h>

#include <algorithm>
#include <cmath>

namespace occlude::test {

/// The share of the pixels of a disc (those whose centres lie in it, on the screen or not) at which
/// `depth01` is at least `light_depth01`. By every pixel, one by one.
inline double exact_fraction(std::span<const float> depth01, glm::ivec2 size,
                             const glm::dvec2& center_px, double radius_px, double light_depth01)
{
    int all = 0;
    int seen = 0;
    const int reach = static_cast<int>(std::ceil(radius_px)) + 1;
    const glm::ivec2 middle{glm::floor(center_px)};
    for (int y = middle.y - reach; y <= middle.y + reach; ++y) {
        for (int x = middle.x - reach; x <= middle.x + reach; ++x) {
            const double dx = x + 0.5 - center_px.x;
            const double dy = y + 0.5 - center_px.y;
            if (dx * dx + dy * dy > radius_px * radius_px) {
                continue;
            }
            ++all;
            const bool on_screen = x >= 0 && y >= 0 && x < size.x && y < size.y;
            seen += on_screen && double{depth01[static_cast<size_t>(y * size.x + x)]} >=
                                     light_depth01 - 1e-7
                        ? 1
                        : 0;
        }
    }
    return static_cast<double>(seen) / all;
}

inline glm::dvec2 pixel_of(const View& view, const glm::vec4& position)
{
    const glm::dvec4 clip = glm::dmat4{view.clip_from_world()} * glm::dvec4{position};
    return (glm::dvec2{clip} / clip.w * 0.5 + 0.5) * glm::dvec2{view.size_px()};
}

inline double depth01_of(const View& view, const glm::vec4& position)
{
    if (position.w == 0.0f) {
        return 1.0 - 1e-6; // the sun: behind everything that is drawn
    }
    const glm::dvec4 clip = glm::dmat4{view.clip_from_world()} * glm::dvec4{position};
    return 0.5 * clip.z / clip.w + 0.5;
}

/// Lights that a wall at z = -20, which slides along x, hides one after the other: two at z = -40,
/// one before the wall, one beyond the edge of a 128 x 96 screen, and the sun.
inline std::vector<FlareLight> walk_lights()
{
    return {{{0.3f, 0.2f, -40.0f, 1.0f}, 9.3f},
            {{8.0f, -5.0f, -40.0f, 1.0f}, 16.0f},
            {{-3.0f, 3.0f, -10.0f, 1.0f}, 6.0f},
            {{39.6f, 0.0f, -30.0f, 1.0f}, 8.0f},
            {{-0.2f, 0.25f, -1.0f, 0.0f}, 12.0f}};
}

} // namespace occlude::test
