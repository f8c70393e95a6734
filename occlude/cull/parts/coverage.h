// The probability that something is hidden by earlier draws, estimated from areas on the screen.
//
// Implements  M. Guthe, A. Balazs, R. Klein, "Near Optimal Hierarchical Culling: Performance Driven
//             Use of Hardware Occlusion Queries", EGSR 2006: the statistical occlusion model.
// Deviations  A projected box is its screen rectangle halved, the mean area of a box in it, instead
//             of the mean face of the box over the squared distance.
#pragma once

#include <occlude/screen/projection.h>

#include <glm/vec2.hpp>

#include <algorithm>
#include <cmath>

namespace occlude {

class ScreenCoverage {
public:
    /// Nothing is drawn yet: c_scr = 0.
    void start_frame(glm::ivec2 size_px)
    {
        covered_ = 0.0;
        pixels_ = std::max(static_cast<double>(size_px.x) * static_cast<double>(size_px.y), 1.0);
    }

    /// c_bb: the share of the screen that the projection of a box covers.
    double share(const ScreenBounds& bounds) const
    {
        constexpr double kBoxPerRectangle = 0.5;
        return kBoxPerRectangle * static_cast<double>(bounds.rect.width) *
               static_cast<double>(bounds.rect.height) / pixels_;
    }

    /// Records the draw of something that covers `share` of the screen, after everything nearer.
    void add_drawn(double share) { covered_ += (1.0 - covered_) * std::min(share, 1.0); }

    /// p_cov: the probability that something that covers `share` lies wholly behind what is drawn.
    double chance_covered(double share) const
    {
        if (share >= covered_) {
            return 0.0;
        }
        const double root = std::sqrt(covered_) - std::sqrt(share);
        return root * root;
    }

private:
    double covered_ = 0.0; ///< c_scr
    double pixels_ = 1.0;
};

} // namespace occlude
