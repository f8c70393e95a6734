// The projection of boxes, one after the other. It is the specification of box_projector_simd.cpp.
//
// The extremes of x / w, y / w and depth / w over a box are at its corners, because they are
// fractions of linear functions with a positive denominator. Everything is computed in float, as on
// a device. Let u = 2^-24, and S the sum of the absolute terms of a coordinate. A device that
// transforms to world space first is off by up to 8 u S, and the sums here by up to 5 u S; 20 u S
// are allowed. Since S >= w, the rest covers the quotient (2 u of it) and the rounding of the error
// itself.
//
// A pixel's sample is at least `sample_inset_px` from its borders. So only those pixels must be
// looked at that the box still reaches when it shrinks by this inset on each side. Adding the inset
// rounds once more, by u of the sum. That takes less than one seventh of the 14 u |x| + 7 u
// half_size that are left above (S of x is at least w times both).
#include <occlude/screen/detail/box_projector.h>

#include <occlude/core/absolute.h>
#include <occlude/core/assert.h>
#include <occlude/core/detail/float4.h>

#include <glm/common.hpp>
#include <glm/mat4x4.hpp>

#include <algorithm>
#include <array>

namespace occlude {

namespace detail {

// In units of the 8 u S that View::clip_rounding() allows a device.
static constexpr double kSlopOverDevice = 20.0 / 8.0;

static float inset_px(SamplePositions samples)
{
    return samples == SamplePositions::center ? 0.5f : 0.0f;
}

static glm::dmat4 magnitude(const glm::dmat4& m)
{
    return {detail::absolute(m[0]), detail::absolute(m[1]), detail::absolute(m[2]),
            detail::absolute(m[3])};
}

// View::clip_rounding(), column by column.
static glm::dmat4 rounding_of(const View& view)
{
    const glm::vec4 constant = view.clip_rounding(glm::vec3{0.0f});
    return {view.clip_rounding({1.0f, 0.0f, 0.0f}) - constant,
            view.clip_rounding({0.0f, 1.0f, 0.0f}) - constant,
            view.clip_rounding({0.0f, 0.0f, 1.0f}) - constant, constant};
}

BoxProjector::BoxProjector(const View& view, SamplePositions samples)
    : inflation(view.inflation())
    , sample_inset_px(inset_px(samples))
{
    // Boxes are taken relative to the view's origin rounded to float, which lies beside the origin.
    const glm::dvec3 beside = glm::dvec3{inflation.origin} - view.origin();
    glm::dmat4 clip = view.clip_from_relative();
    glm::dmat4 rounding = rounding_of(view);
    clip[3] = clip * glm::dvec4{beside, 1.0};
    rounding[3] = rounding * glm::dvec4{detail::absolute(beside), 1.0};
    set_columns(view, clip, rounding);
}

BoxProjector::BoxProjector(const View& view, const glm::mat4& world_from_box,
                           const Inflation& own_inflation, SamplePositions samples)
    : inflation(own_inflation)
    , sample_inset_px(inset_px(samples))
{
    set_object_columns(view, world_from_box);
}

BoxProjector::BoxProjector(const View& view, const glm::mat4& world_from_box)
    : inflation(view.inflation().in(world_from_box, inverse_stretch(world_from_box)))
{
    inflation = {.per_diagonal = 0.0f, .per_coordinate = 0.0f, .origin = inflation.origin};
    set_object_columns(view, world_from_box);
}

BoxProjector BoxProjector::of_tests(const View& view)
{
    BoxProjector projector{view, SamplePositions::anywhere};
    projector.inflation = {
        .per_diagonal = 0.0f, .per_coordinate = 0.0f, .origin = projector.inflation.origin};
    return projector;
}

// A device goes by way of the world, so two more kinds of terms round: the object's own
// coordinates, and its position.
void BoxProjector::set_object_columns(const View& view, const glm::mat4& world_from_box)
{
    const glm::dmat4 map{world_from_box};
    const glm::dmat4 linear{glm::dmat3{map}};
    const glm::dvec3 origin{inflation.origin};
    const glm::dvec3 place = glm::dvec3{map[3]} - view.origin();
    glm::dmat4 clip = view.clip_from_relative() * linear;
    clip[3] = view.clip_from_relative() * glm::dvec4{glm::dmat3{map} * origin + place, 1.0};
    const glm::dmat4 rounding = rounding_of(view);
    glm::dmat4 error = rounding * magnitude(linear);
    error[3] =
        rounding * glm::dvec4{glm::abs(place), 1.0} + error * glm::dvec4{glm::abs(origin), 0.0};
    set_columns(view, clip, error);
}

// `clip`: from (point - inflation.origin) to clip space; `rounding`: as View::clip_rounding().
void BoxProjector::set_columns(const View& view, const glm::dmat4& clip, const glm::dmat4& rounding)
{
    size = glm::vec2{glm::max(view.size_px(), glm::ivec2{0})};
    everywhere.rect = {0, 0, static_cast<int>(size.x), static_cast<int>(size.y)};
    usable = view.usable();
    least_depth = view.ignores_near_plane() ? -Aabb::kInfinity : 0.0f;
    const ClipConvention convention = view.convention();
    const glm::dvec2 half_size = 0.5 * glm::dvec2{size};
    for (int k = 0; k < 4; ++k) {
        glm::dvec4 c = clip[k];
        glm::dvec4 e = rounding[k];
        c.x = half_size.x * (c.x + c.w);
        e.x = half_size.x * (e.x + e.w);
        c.y = half_size.y * (c.y + c.w);
        e.y = half_size.y * (e.y + e.w);
        if (convention.range == DepthRange::minus_one_to_one) {
            c.z = 0.5 * (c.z + c.w);
            e.z = 0.5 * (e.z + e.w);
        }
        if (convention.order == DepthOrder::near_is_large) {
            c.z = c.w - c.z;
            e.z += e.w;
        }
        column[static_cast<size_t>(k)] = glm::vec4{c};
        slop[static_cast<size_t>(k)] = glm::vec4{kSlopOverDevice * e};
    }
}

// The running extremes of the eight corners of a box; lanes: x px, y px, depth, w.
struct Corners {
    Float4 least = splat(Aabb::kInfinity); ///< before the division by w
    Float4 nearest = splat(Aabb::kInfinity);
    Float4 farthest = splat(-Aabb::kInfinity);

    void add(Float4 corner)
    {
        const Float4 over_w = 1.0f / splat(corner[3]);
        const Float4 on_screen = corner * over_w;
        least = min4(least, corner);
        nearest = min4(nearest, on_screen);
        farthest = max4(farthest, on_screen);
    }
};

static inline Float4 lanes(const glm::vec4& v)
{
    return load4(&v.x);
}

static inline Corners all_corners(const std::array<glm::vec4, 4>& column, const glm::vec3& low,
                                  const glm::vec3& high)
{
    const Float4 x[2] = {lanes(column[3]) + lanes(column[0]) * low.x,
                         lanes(column[3]) + lanes(column[0]) * high.x};
    const Float4 y[2] = {lanes(column[1]) * low.y, lanes(column[1]) * high.y};
    const Float4 z[2] = {lanes(column[2]) * low.z, lanes(column[2]) * high.z};
    Corners corners;
    for (const Float4 over_y : y) {
        for (const Float4 over_x : x) {
            const Float4 xy = over_x + over_y;
            corners.add(xy + z[0]);
            corners.add(xy + z[1]);
        }
    }
    return corners;
}

void BoxProjector::project(const Aabb& box, ScreenBounds& bounds) const
{
    if (!usable || !box.is_bounded()) {
        bounds = box.is_empty() ? ScreenBounds{PixelRect{}, 1.0f, 1.0f, true} : everywhere;
        return;
    }
    const float margin = inflation.margin(box);
    const glm::vec3 low = (box.min - inflation.origin) - margin;
    const glm::vec3 high = (box.max - inflation.origin) + margin;
    const glm::vec3 reach = glm::max(detail::absolute(low), detail::absolute(high));
    const Float4 s = lanes(slop[0]) * reach.x + lanes(slop[1]) * reach.y +
                     lanes(slop[2]) * reach.z + lanes(slop[3]);
    const Corners c = all_corners(column, low, high);
    // Written so that NaN (from overflow) gives false.
    const bool certain = bits_of(s < kLargestSlop) == 0xfu && c.least[2] > s[2] + least_depth &&
                         c.least[3] > 2.0f * s[3] && c.least[3] > kSmallestW;
    if (!certain) {
        bounds = everywhere;
        return;
    }
    // (v + dv) / (w + dw) differs from v / w by at most (dv + |v / w| dw) / (w - dw).
    const Float4 largest = max4(abs4(c.nearest), abs4(c.farthest));
    const Float4 error = (s + largest * s[3]) * (1.0f / (c.least[3] - s[3]));
    const Float4 zero = splat(0.0f);
    const Float4 end{size.x, size.y, 1.0f, 1.0f};
    const Float4 margins{-sample_inset_px, -sample_inset_px, ScreenBounds::kDepthMargin, 0.0f};
    const Float4 from = min4(max4(c.nearest - error - margins, zero), end);
    const Float4 to = min4(max4(c.farthest + error + margins, zero), end);

    const Int4 first = truncate4(from);
    const Int4 sides = ceil4(to) - first;
    const bool touches = sides[0] > 0 && sides[1] > 0;
    bounds.rect = touches ? PixelRect{first[0], first[1], sides[0], sides[1]} : PixelRect{};
    bounds.near_depth = from[2];
    bounds.far_depth = to[2];
    bounds.valid = true;
}

} // namespace detail

void project_query_boxes(const View& view, std::span<const QueryBox> boxes,
                         std::span<ScreenBounds> bounds)
{
    OCCLUDE_ASSERT(boxes.size() == bounds.size(), "project_query_boxes needs one result per box");
    std::fill(bounds.begin() + static_cast<std::ptrdiff_t>(std::min(boxes.size(), bounds.size())),
              bounds.end(), ScreenBounds{});
    boxes = boxes.first(std::min(boxes.size(), bounds.size()));
    const detail::BoxProjector from_world = detail::BoxProjector::of_tests(view);
    for (size_t i = 0; i < boxes.size(); ++i) {
        const glm::mat4* world_from_box = boxes[i].world_from_box;
        if (world_from_box == nullptr) {
            from_world.project(boxes[i].box, bounds[i]);
        } else {
            detail::BoxProjector{view, *world_from_box}.project(boxes[i].box, bounds[i]);
        }
    }
}

ScreenBounds project(const View& view, const Aabb& box, SamplePositions samples)
{
    ScreenBounds bounds;
    detail::BoxProjector{view, samples}.project(box, bounds);
    return bounds;
}

static void project_by(const detail::BoxProjector& projector, std::span<const Aabb> boxes,
                       std::span<ScreenBounds> bounds, Kernel kernel)
{
    OCCLUDE_ASSERT(boxes.size() == bounds.size(), "project_boxes needs one result per box");
    std::fill(bounds.begin() + static_cast<std::ptrdiff_t>(std::min(boxes.size(), bounds.size())),
              bounds.end(), ScreenBounds{});
    boxes = boxes.first(std::min(boxes.size(), bounds.size()));
    if (kernel == Kernel::scalar) {
        for (size_t i = 0; i < boxes.size(); ++i) {
            projector.project(boxes[i], bounds[i]);
        }
        return;
    }
    detail::BoundsBlock block;
    for (size_t first = 0; first < boxes.size(); first += block.kBoxes) {
        const size_t count = std::min(block.kBoxes, boxes.size() - first);
        detail::project_boxes_simd(projector, boxes.subspan(first, count), block);
        for (size_t i = 0; i < count; ++i) {
            bounds[first + i] = block[i];
        }
    }
}

void project_boxes(const View& view, std::span<const Aabb> boxes, std::span<ScreenBounds> bounds,
                   Kernel kernel, SamplePositions samples)
{
    project_by(detail::BoxProjector{view, samples}, boxes, bounds, kernel);
}

void project_boxes(const View& view, const glm::mat4& world_from_object, const Inflation& inflation,
                   std::span<const Aabb> boxes, std::span<ScreenBounds> bounds, Kernel kernel,
                   SamplePositions samples)
{
    project_by(detail::BoxProjector{view, world_from_object, inflation, samples}, boxes, bounds,
               kernel);
}

} // namespace occlude
