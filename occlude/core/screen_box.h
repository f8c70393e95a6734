// A box on the screen, tighter than its rectangle: where its faces are, pixel by pixel.
//
//        . . . . . . . .        The rectangle of a box (dots) is wider than the box, and its nearest
//        .   _/\_      .        depth is that of one corner. Here a box is what it is: the
//        . /      \    .        intersection of six half-spaces, each of which is one linear function
//        .|        |   .        of pixel position: the depth at which a ray enters it, or leaves it.
//        . \_    _/    .        A ray meets the box from its last entry to its first exit, and misses
//        . . .\/ . . . .        it if that exit comes first.
//
// Guarantees  Errs outward: over any block of pixels nearest_over() is no greater than the depth of
//             any sample of anything in the box.
// Cost        about 0.1 us to make one, a few ns per block.
#pragma once

#include <occlude/core/aabb.h>
#include <occlude/core/view.h>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>

#include <array>
#include <cstdint>

namespace occlude {

/// Where the samples of a pixel are.
enum class SamplePositions : uint8_t {
    anywhere, ///< in the pixel: multisampled, or not known
    center,   ///< one, in the middle
};

/// The screen of one view: pixels and window depth (0 near, 1 far in every convention) against the
/// world. Made once for all boxes.
class ScreenSpace {
public:
    ScreenSpace() = default;
    /// `view` must be one in which boxes can be tested: project() is valid of some.
    explicit ScreenSpace(const View& view, SamplePositions samples = SamplePositions::anywhere);

private:
    friend class ScreenBox;
    View view_;
    glm::dmat4 world_from_screen_{1.0}; ///< of (x px, y px, depth, 1)
    glm::dmat4 screen_rows_{1.0};       ///< x, y, window depth and w of clip space, as columns
    double sample_from_ = 0.0;          ///< samples of a pixel are from here to there in it, along
    double sample_to_ = 1.0;            ///< both axes
};

class ScreenBox {
public:
    /// Of `box`, the box around the things themselves (it is inflated here, rule R2).
    /// Precondition: project(view, box).valid.
    ScreenBox(const ScreenSpace& screen, const Aabb& box);

    /// A depth that nothing in the box is nearer than, over all samples of the pixels from `low` to
    /// `high`, both included; infinity if the box misses them all.
    double nearest_over(glm::ivec2 low, glm::ivec2 high) const;

private:
    /// depth = x * dx + y * dy + at_origin, in pixels.
    struct Plane {
        double dx;
        double dy;
        double at_origin;
    };

    std::array<Plane, 6> planes_; ///< entries from the front, exits from the back
    int entries_ = 0;
    int exits_ = 0;
    double depth_error_ = 0.0;
    double from_px_ = 0.0; ///< where samples are, from the corner of the first pixel ...
    double to_px_ = 0.0;   ///< ... and of the last
    bool known_ = false;
};

} // namespace occlude
