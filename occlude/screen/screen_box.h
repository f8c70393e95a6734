// A box on the screen, tighter than its rectangle: the depth of its faces, pixel by pixel.
//
//        . . . . . . . .
//        .     _/\_     .       dots: the rectangle of the box
//        .   /      \   .       lines: its outline
//        .  |        |  .
//        .   \_    _/   .
//        . . . .\/. . . .
//
// The rectangle of a box is wider than the box, and its nearest depth is the depth of one corner.
// Here a box is the intersection of six half-spaces. Each is a linear function of pixel position:
// the depth at which a ray enters it, or leaves it. A ray is in the box from its last entry to its
// first exit, and misses the box if that exit comes first.
//
// Guarantees  Errs outward: over any block of pixels nearest_over() is no greater than the depth of
//             any sample of anything in the box.
// Cost        about 0.1 us to make one, a few ns per block.
#pragma once

#include <occlude/core/aabb.h>
#include <occlude/core/view.h>
#include <occlude/screen/projection.h>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace occlude {

/// The screen of one view, in pixels and window depth (0 near, 1 far in every convention), mapped
/// to the world or to the space of an object. Made once for all boxes of that space.
class ScreenSpace {
public:
    ScreenSpace() = default;
    /// Precondition: boxes can be tested in `view`, so that project() is valid for some box.
    explicit ScreenSpace(const View& view, SamplePositions samples = SamplePositions::anywhere);

    /// The screen mapped to the space of an object; `inflation` is Inflation::in() of that space.
    /// Preconditions: *this maps to the world; `world_from_object` is affine and has an inverse.
    /// About 0.1 us.
    ScreenSpace in(const glm::mat4& world_from_object, const Inflation& inflation) const;

private:
    friend class ScreenBox;
    Inflation inflation_;
    glm::dvec3 origin_{0.0}; ///< the view's origin in the boxes' space
    glm::dvec2 size_px_{0.0};
    glm::dmat4 relative_rows_{1.0}; ///< X, Y, Z and W of (position - origin) from (x px, y px,
                                    ///< depth, 1), as columns
    glm::dmat4 screen_rows_{1.0};   ///< x, y, window depth and w of clip space from (position -
                                    ///< origin), also
    glm::dmat4 rounding_{0.0};      ///< the errors that a device may make in these
    double sample_from_ = 0.0;      ///< samples lie between these positions in their
    double sample_to_ = 1.0;        ///< pixel, along both axes
};

class ScreenBox {
public:
    /// `box` must bound the contents in the space of `screen` and not be inflated, because this
    /// constructor inflates it (rule R2). Precondition: project(view, box).valid, or the same of
    /// project_boxes() in that space.
    ScreenBox(const ScreenSpace& screen, const Aabb& box);

    /// A depth that nothing in the box is nearer than, over all samples of the pixels from `low` to
    /// `high`, both included. Infinity if the box misses all of them.
    double nearest_over(glm::ivec2 low, glm::ivec2 high) const;

    /// True if depth < nearest_over(low, high). Mostly the entries alone decide, in the time of one
    /// texel of a pyramid.
    bool beyond(double depth, glm::ivec2 low, glm::ivec2 high) const
    {
        if (!known_) {
            return false;
        }
        const Samples samples = samples_of(low, high);
        const double entry = first_entry(samples);
        return depth < entry - depth_error_ || misses(entry, samples);
    }

private:
    /// depth = x * dx + y * dy + at_origin, in pixels.
    struct Plane {
        double dx = 0.0;
        double dy = 0.0;
        double at_origin = 0.0;
        double per_width = 0.0;  ///< the most that one more pixel in a block can add,
        double per_height = 0.0; ///< at the corner that matters: <= 0 for entries, >= 0 for exits
    };
    /// The rectangle that holds all samples of a block of pixels.
    struct Samples {
        glm::dvec2 low;
        glm::dvec2 size;
    };

    Samples samples_of(glm::ivec2 low, glm::ivec2 high) const
    {
        return {glm::dvec2{low} + from_px_, glm::dvec2{high - low} + (to_px_ - from_px_)};
    }
    static double extreme(const Plane& p, const Samples& samples)
    {
        return p.at_origin + p.dx * samples.low.x + p.dy * samples.low.y +
               p.per_width * samples.size.x + p.per_height * samples.size.y;
    }
    /// The first depth at which some ray of the block can be inside of all entries.
    double first_entry(const Samples& samples) const
    {
        double entry = -std::numeric_limits<double>::infinity();
        for (int i = 0; i < entries_; ++i) {
            entry = std::max(entry, extreme(planes_[static_cast<size_t>(i)], samples));
        }
        return entry;
    }
    /// True if every ray of the block has left by some exit before `entry`.
    bool misses(double entry, const Samples& samples) const
    {
        for (int i = 0; i < exits_; ++i) {
            const double exit = extreme(planes_[static_cast<size_t>(5 - i)], samples);
            if (entry - depth_error_ > exit + depth_error_) {
                return true;
            }
        }
        return false;
    }

    std::array<Plane, 6> planes_; ///< entries from the front, exits from the back
    int entries_ = 0;
    int exits_ = 0;
    double depth_error_ = 0.0;
    double from_px_ = 0.0; ///< sample positions, from the corner of the first pixel ...
    double to_px_ = 0.0;   ///< ... and of the last
    bool known_ = false;
};

} // namespace occlude
