#include <occlude/screen/screen_box.h>

#include <occlude/core/absolute.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace occlude {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A device transforms in float, perhaps to world space first: so many roundings of the largest term
// lie between its coordinates and ours.
constexpr double kTransformSlop = 8.0 * 0x1p-24;

// A face seen so edge-on that its depth changes by more than this over the screen bounds nothing:
// its plane would be a matter of rounding.
constexpr double kSteepest = 1e7;

} // namespace

ScreenSpace::ScreenSpace(const View& view, SamplePositions samples)
    : inflation_(view.inflation())
    , size_px_(view.size_px())
{
    if (samples == SamplePositions::center) {
        sample_from_ = 0.5;
        sample_to_ = 0.5;
    }
    const glm::dmat4 clip{view.clip_from_world()};
    const ClipConvention convention = view.convention();
    const bool reversed = convention.order == DepthOrder::near_is_large;
    const bool symmetric = convention.range == DepthRange::minus_one_to_one;

    // Normalised depth is a * window depth + b.
    double a = reversed ? -1.0 : 1.0;
    double b = reversed ? 1.0 : 0.0;
    if (symmetric) {
        a = 2.0 * a;
        b = 2.0 * b - 1.0;
    }
    const glm::dvec2 size{view.size_px()};
    const glm::dmat4 clip_from_screen{{2.0 / size.x, 0.0, 0.0, 0.0},
                                      {0.0, 2.0 / size.y, 0.0, 0.0},
                                      {0.0, 0.0, a, 0.0},
                                      {-1.0, -1.0, b, 1.0}};
    world_rows_ = glm::transpose(glm::inverse(clip) * clip_from_screen);
    screen_rows_ = glm::transpose(clip);
    screen_rows_[2] = (screen_rows_[2] - b * screen_rows_[3]) / a;
    for (int row = 0; row < 4; ++row) {
        magnitude_[row] = detail::absolute(screen_rows_[row]);
    }
}

// A point of the object is W^-1 times one of the world, homogeneous and affine. A device goes by
// way of the world, or multiplies the two maps first: either way the terms that it rounds are
// products of terms of both.
ScreenSpace ScreenSpace::in(const glm::mat4& world_from_object, const Inflation& inflation) const
{
    const glm::dmat4 map{world_from_object};
    const glm::dmat4 magnitude{detail::absolute(map[0]), detail::absolute(map[1]),
                               detail::absolute(map[2]), detail::absolute(map[3])};
    const glm::dmat3 inverse = glm::inverse(glm::dmat3{map});
    ScreenSpace own = *this;
    own.inflation_ = inflation;
    for (int row = 0; row < 4; ++row) {
        own.screen_rows_[row] = screen_rows_[row] * map;
        own.magnitude_[row] = magnitude_[row] * magnitude;
    }
    const glm::dvec4 from_origin[3] = {world_rows_[0] - map[3].x * world_rows_[3],
                                       world_rows_[1] - map[3].y * world_rows_[3],
                                       world_rows_[2] - map[3].z * world_rows_[3]};
    for (int row = 0; row < 3; ++row) {
        own.world_rows_[row] = inverse[0][row] * from_origin[0] + inverse[1][row] * from_origin[1] +
                               inverse[2][row] * from_origin[2];
    }
    return own;
}

ScreenBox::ScreenBox(const ScreenSpace& screen, const Aabb& box)
{
    const Aabb grown = inflated(box, screen.inflation_.margin(box));
    const glm::dvec3 low{grown.min};
    const glm::dvec3 high{grown.max};
    const glm::dvec2& size = screen.size_px_;

    // What a device may be off by at the nearest point of the box.
    const glm::dvec4 reach{glm::max(detail::absolute(low), detail::absolute(high)), 1.0};
    const auto slop = [&](int row) {
        return kTransformSlop * glm::dot(screen.magnitude_[row], reach);
    };
    const glm::dvec4& row_w = screen.screen_rows_[3];
    const double nearest_w = glm::dot(glm::dvec3{row_w}, 0.5 * (low + high)) + row_w.w -
                             glm::dot(glm::dvec3{screen.magnitude_[3]}, 0.5 * (high - low));
    if (!(nearest_w > 2.0 * slop(3))) {
        return; // nothing is known: nearest_over() says so
    }
    known_ = true;
    const double w = nearest_w - slop(3);
    depth_error_ = double{ScreenBounds::kDepthMargin} + (slop(2) + slop(3)) / w;
    const double outset_px =
        0.5 * std::max(size.x * (slop(0) + slop(3)), size.y * (slop(1) + slop(3))) / w;
    from_px_ = screen.sample_from_ - outset_px;
    to_px_ = screen.sample_to_ + outset_px;

    // World position is (X, Y, Z) / W, linear functions of (x px, y px, depth, 1), and W > 0 before
    // the eye. The lower face of an axis is X - min W >= 0, the upper one max W - X >= 0.
    const glm::dmat4& world_rows = screen.world_rows_;
    const glm::dvec4 world_w = world_rows[3];
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2;
        const glm::dvec4 inside = face % 2 == 0 ? world_rows[axis] - low[axis] * world_w
                                                : high[axis] * world_w - world_rows[axis];
        const double across =
            std::abs(inside.x) * size.x + std::abs(inside.y) * size.y + std::abs(inside.w);
        if (!(std::abs(inside.z) * kSteepest > across)) {
            continue;
        }
        const glm::dvec4 depth = inside * (-1.0 / inside.z);
        if (inside.z > 0.0) {
            planes_[static_cast<size_t>(entries_++)] = {
                depth.x, depth.y, depth.w, std::min(depth.x, 0.0), std::min(depth.y, 0.0)};
        } else {
            planes_[static_cast<size_t>(5 - exits_++)] = {
                depth.x, depth.y, depth.w, std::max(depth.x, 0.0), std::max(depth.y, 0.0)};
        }
    }
}

double ScreenBox::nearest_over(glm::ivec2 low, glm::ivec2 high) const
{
    if (!known_) {
        return -kInfinity;
    }
    const Samples samples = samples_of(low, high);
    const double entry = first_entry(samples);
    return misses(entry, samples) ? kInfinity : entry - depth_error_;
}

} // namespace occlude
