#include <occlude/screen/screen_box.h>

#include <occlude/core/absolute.h>
#include <occlude/core/assert.h>

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

// A face seen so edge-on that its depth changes by more than this over the screen bounds nothing,
// because rounding would dominate its plane.
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
    const glm::dmat4& clip = view.clip_from_relative();
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
    relative_rows_ = glm::transpose(glm::inverse(clip) * clip_from_screen);
    screen_rows_ = glm::transpose(clip);
    screen_rows_[2] = (screen_rows_[2] - b * screen_rows_[3]) / a;

    const glm::vec4 constant = view.clip_rounding(glm::vec3{0.0f});
    rounding_ =
        glm::transpose(glm::dmat4{view.clip_rounding({1.0f, 0.0f, 0.0f}) - constant,
                                  view.clip_rounding({0.0f, 1.0f, 0.0f}) - constant,
                                  view.clip_rounding({0.0f, 0.0f, 1.0f}) - constant, constant});
    rounding_[2] = (rounding_[2] + std::abs(b) * rounding_[3]) / std::abs(a);
    origin_ = view.origin();
}

// Let R and t be the linear part and the translation of the map. A position relative to the view's
// origin o is R p + t - o, so that seen from the object the origin is R^-1 (o - t). A device goes
// by way of the world, or multiplies the two maps first. Either way it rounds products of terms of
// both.
ScreenSpace ScreenSpace::in(const glm::mat4& world_from_object, const Inflation& inflation) const
{
    const glm::dmat3 linear{glm::dmat4{world_from_object}};
    const glm::dmat4 map{linear};
    const glm::dmat4 magnitude{detail::absolute(map[0]), detail::absolute(map[1]),
                               detail::absolute(map[2]), detail::absolute(map[3])};
    OCCLUDE_ASSERT(glm::determinant(linear) != 0.0, "ScreenSpace::in needs a map with an inverse");
    const glm::dmat3 inverse = glm::inverse(linear);
    const glm::dvec3 away = origin_ - glm::dvec3{world_from_object[3]};
    ScreenSpace own = *this;
    own.inflation_ = inflation;
    own.origin_ = inverse * away;
    for (int row = 0; row < 4; ++row) {
        own.screen_rows_[row] = screen_rows_[row] * map;
        const glm::dvec4 rounding = rounding_[row] * magnitude;
        own.rounding_[row] = glm::dvec4{
            glm::dvec3{rounding},
            rounding_[row].w + glm::dot(glm::dvec3{rounding_[row]}, detail::absolute(away)) +
                glm::dot(glm::dvec3{rounding}, detail::absolute(own.origin_))};
    }
    for (int row = 0; row < 3; ++row) {
        own.relative_rows_[row] = inverse[0][row] * relative_rows_[0] +
                                  inverse[1][row] * relative_rows_[1] +
                                  inverse[2][row] * relative_rows_[2];
    }
    return own;
}

ScreenBox::ScreenBox(const ScreenSpace& screen, const Aabb& box)
{
    const double margin = screen.inflation_.margin(box);
    const glm::dvec3 low = glm::dvec3{box.min} - screen.origin_ - margin;
    const glm::dvec3 high = glm::dvec3{box.max} - screen.origin_ + margin;
    const glm::dvec2& size = screen.size_px_;

    // The error that a device may make at the nearest point of the box.
    const glm::dvec4 reach{glm::max(detail::absolute(low), detail::absolute(high)), 1.0};
    const auto slop = [&](int row) { return glm::dot(screen.rounding_[row], reach); };
    const glm::dvec4& row_w = screen.screen_rows_[3];
    const double nearest_w = glm::dot(glm::dvec3{row_w}, 0.5 * (low + high)) + row_w.w -
                             glm::dot(detail::absolute(glm::dvec3{row_w}), 0.5 * (high - low));
    if (!(nearest_w > 2.0 * slop(3))) {
        return; // nothing is known: nearest_over() says so
    }
    known_ = true;
    const double w = nearest_w - slop(3);
    depth_error_ = double{ScreenBounds::kDepthMargin} + double{screen.inflation_.depth_bias} +
                   (slop(2) + slop(3)) / w;
    const double outset_px =
        0.5 * std::max(size.x * (slop(0) + slop(3)), size.y * (slop(1) + slop(3))) / w;
    from_px_ = screen.sample_from_ - outset_px;
    to_px_ = screen.sample_to_ + outset_px;

    // Relative position is (X, Y, Z) / W, linear functions of (x px, y px, depth, 1), and W > 0
    // before the eye. The lower face of an axis is X - min W >= 0, the upper one max W - X >= 0.
    const glm::dmat4& rows = screen.relative_rows_;
    const glm::dvec4 row_of_w = rows[3];
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2;
        const glm::dvec4 inside =
            face % 2 == 0 ? rows[axis] - low[axis] * row_of_w : high[axis] * row_of_w - rows[axis];
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
    const bool some = low.x <= high.x && low.y <= high.y;
    OCCLUDE_ASSERT(some, "ScreenBox::nearest_over needs the lower left pixel first");
    if (!known_ || !some) {
        return -kInfinity;
    }
    const Samples samples = samples_of(low, high);
    const double entry = first_entry(samples);
    return misses(entry, samples) ? kInfinity : entry - depth_error_;
}

} // namespace occlude
