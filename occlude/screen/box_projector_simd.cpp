// BoxProjector::project for as many boxes at once as a vector has lanes: the same operations in the
// same order, so that results are equal to the bit. Read it beside box_projector.cpp.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "occlude/screen/box_projector_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <occlude/screen/detail/box_projector.h>

#include <algorithm>
#include <array>

HWY_BEFORE_NAMESPACE();
namespace occlude::HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR // a processor without vectors

void project_boxes(const detail::BoxProjector& p, const Aabb* boxes, size_t count,
                   detail::BoundsBlock& bounds)
{
    for (size_t i = 0; i < count; ++i) {
        ScreenBounds b;
        p.project(boxes[i], b);
        bounds.set(i, b);
    }
}

#else

namespace hn = hwy::HWY_NAMESPACE;

using F = hn::ScalableTag<float>;
using I = hn::RebindToSigned<F>;
using V = hn::Vec<F>;
using M = hn::Mask<F>;
constexpr F kF;
constexpr I kI;
constexpr size_t kMaxLanes = hn::MaxLanes(F{});

struct V3 {
    V x, y, z;
};
struct V4 {
    V x, y, z, w;
};
struct Boxes {
    V3 min, max;
};

HWY_INLINE V4 set(const glm::vec4& v)
{
    return {hn::Set(kF, v.x), hn::Set(kF, v.y), hn::Set(kF, v.z), hn::Set(kF, v.w)};
}
HWY_INLINE V4 plus(const V4& a, const V4& b)
{
    return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z), hn::Add(a.w, b.w)};
}
HWY_INLINE V4 times(const V4& a, V s)
{
    return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s), hn::Mul(a.w, s)};
}
HWY_INLINE V dot(const V3& a, const V3& b)
{
    return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE V clamp(V v, V low, V high)
{
    return hn::Min(hn::Max(v, low), high);
}

HWY_INLINE Boxes load(const Aabb* boxes)
{
    static_assert(sizeof(Aabb) == 6 * sizeof(float));
    // The corners in turn, the minimum of a box and then its maximum: one load holds half a vector
    // of boxes.
    const size_t lanes = hn::Lanes(kF);
    V3 a, b;
    hn::LoadInterleaved3(kF, &boxes[0].min.x, a.x, a.y, a.z);
    hn::LoadInterleaved3(kF, &boxes[0].min.x + 3 * lanes, b.x, b.y, b.z);
    return {
        {hn::ConcatEven(kF, b.x, a.x), hn::ConcatEven(kF, b.y, a.y), hn::ConcatEven(kF, b.z, a.z)},
        {hn::ConcatOdd(kF, b.x, a.x), hn::ConcatOdd(kF, b.y, a.y), hn::ConcatOdd(kF, b.z, a.z)}};
}

// The same as Aabb::is_empty and Aabb::is_bounded.
HWY_INLINE void classify(const Boxes& b, M& empty, M& bounded)
{
    const M below = hn::And(hn::And(hn::Le(b.min.x, b.max.x), hn::Le(b.min.y, b.max.y)),
                            hn::Le(b.min.z, b.max.z));
    const M gx = hn::Gt(b.min.x, b.max.x);
    const M gy = hn::Gt(b.min.y, b.max.y);
    const M gz = hn::Gt(b.min.z, b.max.z);
    const M known =
        hn::And(hn::And(hn::Or(gx, hn::Le(b.min.x, b.max.x)), hn::Or(gy, hn::Le(b.min.y, b.max.y))),
                hn::Or(gz, hn::Le(b.min.z, b.max.z)));
    empty = hn::And(known, hn::Or(hn::Or(gx, gy), gz));
    const V inf = hn::Set(kF, Aabb::kInfinity);
    const V lowest = hn::Min(hn::Min(b.min.x, b.min.y), b.min.z);
    const V highest = hn::Max(hn::Max(b.max.x, b.max.y), b.max.z);
    bounded = hn::And(below, hn::And(hn::Gt(lowest, hn::Neg(inf)), hn::Lt(highest, inf)));
}

// The box relative to `origin`.
HWY_INLINE Boxes relative_to(const glm::vec3& origin, const Boxes& b)
{
    const V3 o{hn::Set(kF, origin.x), hn::Set(kF, origin.y), hn::Set(kF, origin.z)};
    return {{hn::Sub(b.min.x, o.x), hn::Sub(b.min.y, o.y), hn::Sub(b.min.z, o.z)},
            {hn::Sub(b.max.x, o.x), hn::Sub(b.max.y, o.y), hn::Sub(b.max.z, o.z)}};
}

// Inflation::margin of a box, given the box and the same box relative to the origin.
HWY_INLINE V margin_of(const Inflation& rule, const Boxes& box, const Boxes& b)
{
    const V3 extent{hn::Sub(box.max.x, box.min.x), hn::Sub(box.max.y, box.min.y),
                    hn::Sub(box.max.z, box.min.z)};
    const V4 row = set(rule.row_w);
    const V most_x = hn::Max(hn::Mul(row.x, b.min.x), hn::Mul(row.x, b.max.x));
    const V most_y = hn::Max(hn::Mul(row.y, b.min.y), hn::Mul(row.y, b.max.y));
    const V most_z = hn::Max(hn::Mul(row.z, b.min.z), hn::Mul(row.z, b.max.z));
    const V largest_w = hn::Add(hn::Add(hn::Add(most_x, most_y), most_z), row.w);
    const V magnitude = hn::Max(hn::Max(hn::Max(hn::Abs(b.min.x), hn::Abs(b.max.x)),
                                        hn::Max(hn::Abs(b.min.y), hn::Abs(b.max.y))),
                                hn::Max(hn::Abs(b.min.z), hn::Abs(b.max.z)));
    const V distance = hn::Add(magnitude, hn::Set(kF, rule.reach));
    const V pixels = hn::Mul(hn::Set(kF, rule.per_w), hn::Max(largest_w, hn::Zero(kF)));
    const V diagonal = hn::Mul(hn::Set(kF, rule.per_diagonal), hn::Sqrt(dot(extent, extent)));
    return hn::Add(hn::Add(pixels, diagonal), hn::Mul(hn::Set(kF, rule.per_coordinate), distance));
}

// One corner, and the running extremes of all corners.
struct Corners {
    V4 nearest, farthest; // w is not used
    V least_z, least_w;

    HWY_INLINE void add(const V4& c)
    {
        const V over_w = hn::Div(hn::Set(kF, 1.0f), c.w);
        const V x = hn::Mul(c.x, over_w);
        const V y = hn::Mul(c.y, over_w);
        const V z = hn::Mul(c.z, over_w);
        least_z = hn::Min(least_z, c.z);
        least_w = hn::Min(least_w, c.w);
        nearest.x = hn::Min(nearest.x, x);
        nearest.y = hn::Min(nearest.y, y);
        nearest.z = hn::Min(nearest.z, z);
        farthest.x = hn::Max(farthest.x, x);
        farthest.y = hn::Max(farthest.y, y);
        farthest.z = hn::Max(farthest.z, z);
    }
};

HWY_INLINE Corners all_corners(const detail::BoxProjector& p, const V3& low, const V3& high)
{
    const V4 origin = set(p.column[3]);
    const V4 x0 = plus(origin, times(set(p.column[0]), low.x));
    const V4 x1 = plus(origin, times(set(p.column[0]), high.x));
    const V4 y0 = times(set(p.column[1]), low.y);
    const V4 y1 = times(set(p.column[1]), high.y);
    const V4 z0 = times(set(p.column[2]), low.z);
    const V4 z1 = times(set(p.column[2]), high.z);
    const V4 a = plus(x0, y0);
    const V4 b = plus(x1, y0);
    const V4 c = plus(x0, y1);
    const V4 d = plus(x1, y1);
    const V inf = hn::Set(kF, Aabb::kInfinity);
    const V4 plus_inf{inf, inf, inf, inf};
    const V4 minus_inf{hn::Neg(inf), hn::Neg(inf), hn::Neg(inf), hn::Neg(inf)};
    Corners corners{plus_inf, minus_inf, inf, inf};
    corners.add(plus(a, z0));
    corners.add(plus(b, z0));
    corners.add(plus(c, z0));
    corners.add(plus(d, z0));
    corners.add(plus(a, z1));
    corners.add(plus(b, z1));
    corners.add(plus(c, z1));
    corners.add(plus(d, z1));
    return corners;
}

// Writes the fields of `known` lanes. The others are either `empty` or unknown (all of the target).
HWY_INLINE void write(const detail::BoxProjector& p, const V3& nearest, const V3& farthest, M known,
                      M empty, detail::BoundsBlock& out, size_t at)
{
    const V zero = hn::Zero(kF);
    const V one = hn::Set(kF, 1.0f);
    const V width = hn::Set(kF, p.size.x);
    const V height = hn::Set(kF, p.size.y);
    const V inset = hn::Set(kF, p.sample_inset_px);
    const auto first = [&](V v, V end) HWY_ATTR {
        return hn::ConvertTo(kI, clamp(hn::Add(v, inset), zero, end));
    };
    const auto past = [&](V v, V end) HWY_ATTR {
        return hn::ConvertTo(kI, hn::Ceil(clamp(hn::Sub(v, inset), zero, end)));
    };
    const auto first_x = first(nearest.x, width);
    const auto first_y = first(nearest.y, height);
    const auto size_x = hn::Sub(past(farthest.x, width), first_x);
    const auto size_y = hn::Sub(past(farthest.y, height), first_y);
    const auto none = hn::Zero(kI);
    const auto touches = hn::And(hn::Gt(size_x, none), hn::Gt(size_y, none));
    const auto known_i = hn::RebindMask(kI, known);
    const auto lost_i = hn::Not(hn::RebindMask(kI, hn::Or(known, empty)));
    const auto pixels = hn::And(known_i, touches);
    const auto all_x = hn::IfThenElseZero(lost_i, hn::Set(kI, p.everywhere.rect.width));
    const auto all_y = hn::IfThenElseZero(lost_i, hn::Set(kI, p.everywhere.rect.height));
    hn::Store(hn::IfThenElseZero(pixels, first_x), kI, &out.x[at]);
    hn::Store(hn::IfThenElseZero(pixels, first_y), kI, &out.y[at]);
    hn::Store(hn::IfThenElse(pixels, size_x, all_x), kI, &out.width[at]);
    hn::Store(hn::IfThenElse(pixels, size_y, all_y), kI, &out.height[at]);

    const V margin = hn::Set(kF, ScreenBounds::kDepthMargin);
    const V near_depth = clamp(hn::Sub(nearest.z, margin), zero, one);
    const V far_depth = clamp(hn::Add(farthest.z, margin), zero, one);
    hn::Store(hn::IfThenElse(known, near_depth, hn::IfThenElseZero(empty, one)), kF,
              &out.near_depth[at]);
    hn::Store(hn::IfThenElse(known, far_depth, one), kF, &out.far_depth[at]);
    hn::Store(hn::IfThenZeroElse(lost_i, hn::Set(kI, 1)), kI, &out.valid[at]);
}

HWY_INLINE void project_vector(const detail::BoxProjector& p, const Aabb* boxes,
                               detail::BoundsBlock& out, size_t at)
{
    const Boxes box = load(boxes);
    M empty, bounded;
    classify(box, empty, bounded);

    const Boxes seen = relative_to(p.inflation.origin, box);
    const V margin = margin_of(p.inflation, box, seen);
    const V3 low{hn::Sub(seen.min.x, margin), hn::Sub(seen.min.y, margin),
                 hn::Sub(seen.min.z, margin)};
    const V3 high{hn::Add(seen.max.x, margin), hn::Add(seen.max.y, margin),
                  hn::Add(seen.max.z, margin)};
    const V4 s = plus(plus(plus(times(set(p.slop[0]), hn::Max(hn::Abs(low.x), hn::Abs(high.x))),
                                times(set(p.slop[1]), hn::Max(hn::Abs(low.y), hn::Abs(high.y)))),
                           times(set(p.slop[2]), hn::Max(hn::Abs(low.z), hn::Abs(high.z)))),
                      set(p.slop[3]));
    const Corners c = all_corners(p, low, high);

    const V largest_slop = hn::Set(kF, detail::BoxProjector::kLargestSlop);
    M known = hn::And(hn::And(hn::Lt(s.x, largest_slop), hn::Lt(s.y, largest_slop)),
                      hn::And(hn::Lt(s.z, largest_slop), hn::Lt(s.w, largest_slop)));
    known = hn::And(known, hn::And(hn::Gt(c.least_z, hn::Add(s.z, hn::Set(kF, p.least_depth))),
                                   hn::Gt(c.least_w, hn::Mul(hn::Set(kF, 2.0f), s.w))));
    known = hn::And(known, hn::Gt(c.least_w, hn::Set(kF, detail::BoxProjector::kSmallestW)));
    const M usable = hn::RebindMask(kF, hn::Ne(hn::Set(kI, p.usable ? 1 : 0), hn::Zero(kI)));
    known = hn::And(known, hn::And(bounded, usable));

    const V over_w = hn::Div(hn::Set(kF, 1.0f), hn::Sub(c.least_w, s.w));
    const auto error = [&](V slop, V nearest, V farthest) HWY_ATTR {
        const V largest = hn::Max(hn::Abs(nearest), hn::Abs(farthest));
        return hn::Mul(hn::Add(slop, hn::Mul(largest, s.w)), over_w);
    };
    const V3 e{error(s.x, c.nearest.x, c.farthest.x), error(s.y, c.nearest.y, c.farthest.y),
               error(s.z, c.nearest.z, c.farthest.z)};
    write(p, {hn::Sub(c.nearest.x, e.x), hn::Sub(c.nearest.y, e.y), hn::Sub(c.nearest.z, e.z)},
          {hn::Add(c.farthest.x, e.x), hn::Add(c.farthest.y, e.y), hn::Add(c.farthest.z, e.z)},
          known, empty, out, at);
}

void project_boxes(const detail::BoxProjector& p, const Aabb* boxes, size_t count,
                   detail::BoundsBlock& bounds)
{
    static_assert(detail::BoundsBlock::kBoxes % kMaxLanes == 0);
    const size_t lanes = hn::Lanes(kF);
    size_t i = 0;
    for (; i + lanes <= count; i += lanes) {
        project_vector(p, boxes + i, bounds, i);
    }
    if (i < count) {
        std::array<Aabb, kMaxLanes> rest; // the others stay empty
        std::copy(boxes + i, boxes + count, rest.begin());
        project_vector(p, rest.data(), bounds, i);
    }
}

#endif

} // namespace occlude::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace occlude {
HWY_EXPORT(project_boxes);

void detail::project_boxes_simd(const BoxProjector& p, std::span<const Aabb> boxes,
                                BoundsBlock& bounds)
{
    HWY_DYNAMIC_DISPATCH(project_boxes)(p, boxes.data(), boxes.size(), bounds);
}

} // namespace occlude
#endif
