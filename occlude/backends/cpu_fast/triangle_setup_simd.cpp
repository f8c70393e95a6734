// triangle_setup.cpp for as many vertices or triangles at once as a vector has lanes: the same
// operations in the same order, so that results agree to the bit. Read it beside that file.
// Long because: it follows that file function by function.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "occlude/backends/cpu_fast/triangle_setup_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <occlude/backends/cpu_fast/detail/triangle_setup.h>

#include <algorithm>
#include <array>
#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace occlude::cpu_fast::HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR // a processor without vectors

const SetupKernels* setup_kernel_table()
{
    return &setup_kernels(Kernel::scalar);
}

#else

namespace {

namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 16>;
using I = hn::RebindToSigned<F>;
using U = hn::RebindToUnsigned<F>;
constexpr F kF;
constexpr I kI;
constexpr U kU;
using VF = hn::Vec<F>;
using VI = hn::Vec<I>;
using VU = hn::Vec<U>;
using M = hn::Mask<F>;
constexpr size_t kMostLanes = hn::MaxLanes(F{});

HWY_INLINE VF set(float value)
{
    return hn::Set(kF, value);
}
HWY_INLINE VF cells(VI subcells)
{
    return hn::Mul(hn::ConvertTo(kF, subcells), set(1.0f / static_cast<float>(kSubcells)));
}
HWY_INLINE VI clamped(VI value, VI low, VI high)
{
    return hn::Min(hn::Max(value, low), high);
}

HWY_INLINE VF row_of(const InstanceTransform& t, int row, VF x, VF y, VF z)
{
    return hn::Add(
        hn::Add(hn::Add(hn::Mul(set(t.column[0][row]), x), hn::Mul(set(t.column[1][row]), y)),
                hn::Mul(set(t.column[2][row]), z)),
        set(t.column[3][row]));
}

// One vector of vertices; returns their codes.
HWY_INLINE VU transform_vector(const float* positions, const InstanceTransform& t,
                               ScreenVertices& out, size_t i)
{
    VF px, py, pz;
    hn::LoadInterleaved3(kF, positions, px, py, pz);
    const VF x = row_of(t, 0, px, py, pz);
    const VF y = row_of(t, 1, px, py, pz);
    const VF z = row_of(t, 2, px, py, pz);
    const VF w = row_of(t, 3, px, py, pz);
    const auto bit = [](M where, uint32_t value) HWY_ATTR {
        return hn::IfThenElseZero(hn::RebindMask(kU, where), hn::Set(kU, value));
    };
    const M zero_if_finite =
        hn::Eq(hn::Mul(set(0.0f), hn::Add(hn::Add(hn::Add(x, y), z), w)), hn::Zero(kF));
    VU code = hn::IfThenZeroElse(hn::RebindMask(kU, hn::Ge(w, set(t.least_w))),
                                 hn::Set(kU, kBeforeLeastW));
    code = hn::Or(code, bit(hn::Lt(z, set(t.least_z)), kBeforeNear));
    code = hn::Or(code, bit(hn::Lt(x, hn::Mul(set(t.guard_low.x), w)), kBeyondGuardLeft));
    code = hn::Or(code, bit(hn::Gt(x, hn::Mul(set(t.guard_high.x), w)), kBeyondGuardRight));
    code = hn::Or(code, bit(hn::Lt(y, hn::Mul(set(t.guard_low.y), w)), kBeyondGuardBottom));
    code = hn::Or(code, bit(hn::Gt(y, hn::Mul(set(t.guard_high.y), w)), kBeyondGuardTop));
    code = hn::Or(code,
                  hn::IfThenZeroElse(hn::RebindMask(kU, zero_if_finite), hn::Set(kU, kNotFinite)));
    const auto usable = hn::Eq(code, hn::Zero(kU));
    const M usable_f = hn::RebindMask(kF, usable);
    const VF inverse_w = hn::Div(set(1.0f), hn::IfThenElse(usable_f, w, set(1.0f)));
    const auto snapped = [&](VF v) HWY_ATTR {
        const VF on_grid = hn::Mul(hn::Mul(v, inverse_w), set(static_cast<float>(kSubcells)));
        return hn::NearestInt(hn::IfThenElseZero(usable_f, on_grid));
    };
    const VF depth = hn::Max(hn::Add(hn::Mul(z, inverse_w), set(t.z_slack)), hn::Zero(kF));
    hn::StoreU(snapped(x), kI, out.x.data() + i);
    hn::StoreU(snapped(y), kI, out.y.data() + i);
    hn::StoreU(hn::IfThenElseZero(usable_f, depth), kF, out.z.data() + i);
    hn::StoreU(code, kU, out.code.data() + i);
    return code;
}

uint32_t transform(std::span<const glm::vec3> positions, const InstanceTransform& t,
                   ScreenVertices& out)
{
    const size_t lanes = hn::Lanes(kF);
    out.reserve(positions.size());
    VU all = hn::Zero(kU);
    size_t i = 0;
    for (; i + lanes <= positions.size(); i += lanes) {
        all = hn::Or(all, transform_vector(&positions[i].x, t, out, i));
    }
    if (i < positions.size()) { // the last position again and again
        glm::vec3 rest[kMostLanes];
        for (size_t k = 0; k < kMostLanes; ++k) {
            rest[k] = positions[std::min(i + k, positions.size() - 1)];
        }
        all = hn::Or(all, transform_vector(&rest[0].x, t, out, i));
    }
    alignas(64) uint32_t codes[kMostLanes] = {};
    hn::Store(all, kU, codes);
    uint32_t any = 0;
    for (const uint32_t code : codes) {
        any |= code;
    }
    return any;
}

struct Corners {
    VI x, y;
    VF z;
};
struct Triangles {
    Corners a, b, c;
};

HWY_INLINE Corners gather(const ScreenVertices& vertices, VU index)
{
    const VI i = hn::BitCast(kI, index);
    return {hn::GatherIndex(kI, vertices.x.data(), i), hn::GatherIndex(kI, vertices.y.data(), i),
            hn::GatherIndex(kF, vertices.z.data(), i)};
}

HWY_INLINE Triangles load(const OccluderMesh::Triangle* triangles, const ScreenVertices& vertices)
{
    VU a, b, c;
    hn::LoadInterleaved3(kU, triangles->data(), a, b, c);
    return {gather(vertices, a), gather(vertices, b), gather(vertices, c)};
}

// The sign of twice_area(). In float the terms are exact below 2^24, and else known to 2^-21 of
// themselves; where that does not decide, one by one in integers.
HWY_INLINE void orientation(const Triangles& t, M& counterclockwise, M& clockwise)
{
    const VF p =
        hn::Mul(hn::ConvertTo(kF, hn::Sub(t.b.x, t.a.x)), hn::ConvertTo(kF, hn::Sub(t.c.y, t.a.y)));
    const VF q =
        hn::Mul(hn::ConvertTo(kF, hn::Sub(t.b.y, t.a.y)), hn::ConvertTo(kF, hn::Sub(t.c.x, t.a.x)));
    const VF area = hn::Sub(p, q);
    const VF terms = hn::Add(hn::Abs(p), hn::Abs(q));
    const M known =
        hn::Or(hn::Lt(terms, set(0x1p24f)), hn::Gt(hn::Abs(area), hn::Mul(terms, set(0x1p-21f))));
    counterclockwise = hn::Gt(area, hn::Zero(kF));
    clockwise = hn::Lt(area, hn::Zero(kF));
    if (hn::AllTrue(kF, known)) {
        return;
    }
    alignas(64) int32_t ax[kMostLanes], ay[kMostLanes], bx[kMostLanes], by[kMostLanes],
        cx[kMostLanes], cy[kMostLanes];
    hn::Store(t.a.x, kI, ax);
    hn::Store(t.a.y, kI, ay);
    hn::Store(t.b.x, kI, bx);
    hn::Store(t.b.y, kI, by);
    hn::Store(t.c.x, kI, cx);
    hn::Store(t.c.y, kI, cy);
    alignas(64) int32_t sign[kMostLanes];
    for (size_t i = 0; i < hn::Lanes(kF); ++i) {
        const int64_t exact =
            twice_area({ax[i], ay[i], 0.0f}, {bx[i], by[i], 0.0f}, {cx[i], cy[i], 0.0f});
        sign[i] = exact > 0 ? 1 : exact < 0 ? -1 : 0;
    }
    const VI signs = hn::Load(kI, sign);
    counterclockwise = hn::RebindMask(kF, hn::Gt(signs, hn::Zero(kI)));
    clockwise = hn::RebindMask(kF, hn::Lt(signs, hn::Zero(kI)));
}

// Calls use(first triangle, how many, Triangles) for each vector; the rest of the last one is of
// triangles without area.
template <class Use>
HWY_INLINE void for_each_vector(std::span<const OccluderMesh::Triangle> triangles,
                                const ScreenVertices& vertices, Use&& use)
{
    const size_t lanes = hn::Lanes(kF);
    size_t i = 0;
    for (; i + lanes <= triangles.size(); i += lanes) {
        use(i, lanes, load(&triangles[i], vertices));
    }
    if (i < triangles.size()) {
        OccluderMesh::Triangle rest[kMostLanes] = {};
        std::copy(triangles.begin() + static_cast<ptrdiff_t>(i), triangles.end(), rest);
        use(i, triangles.size() - i, load(rest, vertices));
    }
}

void facings(std::span<const OccluderMesh::Triangle> triangles, const ScreenVertices& vertices,
             int8_t* facings)
{
    for_each_vector(
        triangles, vertices, [&](size_t first, size_t count, const Triangles& t) HWY_ATTR {
            M counterclockwise, clockwise;
            orientation(t, counterclockwise, clockwise);
            const VI sign =
                hn::Sub(hn::IfThenElseZero(hn::RebindMask(kI, counterclockwise), hn::Set(kI, 1)),
                        hn::IfThenElseZero(hn::RebindMask(kI, clockwise), hn::Set(kI, 1)));
            alignas(64) int32_t signs[kMostLanes];
            hn::Store(sign, kI, signs);
            for (size_t i = 0; i < count; ++i) {
                facings[first + i] = static_cast<int8_t>(signs[i]);
            }
        });
}

struct Lines {
    VF slope, at;
};

HWY_INLINE Lines edge_line(VF x, VF y, VF dx, VF dy, VF outward)
{
    const VF slope = hn::Div(dx, hn::IfThenElse(hn::Eq(dy, hn::Zero(kF)), set(1.0f), dy));
    const VF moved = hn::Mul(outward, hn::Add(hn::Abs(slope), set(1.0f)));
    const VF at = hn::Sub(x, hn::Mul(slope, y));
    return {slope,
            hn::IfThenElse(hn::Lt(dy, hn::Zero(kF)), hn::Sub(at, moved), hn::Add(at, moved))};
}

HWY_INLINE Lines choose(M mask, const Lines& yes, const Lines& no)
{
    return {hn::IfThenElse(mask, yes.slope, no.slope), hn::IfThenElse(mask, yes.at, no.at)};
}

struct Rects {
    VI x0, y0, x1, y1;
};

HWY_INLINE Rects cells_of(VI x0, VI y0, VI x1, VI y1, const TriangleSetup& setup)
{
    const VI zero = hn::Zero(kI);
    const VI one = hn::Set(kI, 1);
    const VI width = hn::Set(kI, setup.size.x);
    const VI height = hn::Set(kI, setup.size.y);
    if (setup.kind == PrimKind::alone) {
        const VI g = hn::Set(kI, subcells_of(setup.growth.edge));
        const VI up = hn::Add(g, hn::Set(kI, kSubcells - 1));
        x0 = hn::ShiftRight<kSubcellBits>(hn::Add(x0, up));
        y0 = hn::ShiftRight<kSubcellBits>(hn::Add(y0, up));
        x1 = hn::Sub(hn::ShiftRight<kSubcellBits>(hn::Sub(x1, g)), one);
        y1 = hn::Sub(hn::ShiftRight<kSubcellBits>(hn::Sub(y1, g)), one);
    } else {
        const VI g = hn::Set(kI, subcells_of(setup.growth.touch));
        x0 = hn::ShiftRight<kSubcellBits>(hn::Sub(x0, hn::Add(g, one)));
        y0 = hn::ShiftRight<kSubcellBits>(hn::Sub(y0, hn::Add(g, one)));
        x1 = hn::ShiftRight<kSubcellBits>(hn::Add(x1, g));
        y1 = hn::ShiftRight<kSubcellBits>(hn::Add(y1, g));
    }
    const VI none = hn::Set(kI, -1);
    return {clamped(x0, zero, width), clamped(y0, zero, height),
            clamped(x1, none, hn::Sub(width, one)), clamped(y1, none, hn::Sub(height, one))};
}

struct Planes {
    VF zx, zy, z, z_max, z_min;
};

HWY_INLINE Planes planes_of(const Triangles& t, VI width, VI height, VF ax, VF ay, VF growth)
{
    const VF bx = cells(hn::Sub(t.b.x, t.a.x));
    const VF by = cells(hn::Sub(t.b.y, t.a.y));
    const VF cx = cells(hn::Sub(t.c.x, t.a.x));
    const VF cy = cells(hn::Sub(t.c.y, t.a.y));
    const VF p = hn::Mul(bx, cy);
    const VF q = hn::Mul(by, cx);
    const VF area = hn::Sub(p, q);
    const VF terms = hn::Add(hn::Abs(p), hn::Abs(q));
    Planes out;
    out.z_max = hn::Max(hn::Max(t.a.z, t.b.z), t.c.z);
    out.z_min = hn::Min(hn::Min(t.a.z, t.b.z), t.c.z);
    const M fat = hn::Gt(area, hn::Mul(terms, set(kThinnest)));
    const VF inverse = hn::Div(set(1.0f), hn::IfThenElse(fat, area, set(1.0f)));
    const VF bz = hn::Sub(t.b.z, t.a.z);
    const VF cz = hn::Sub(t.c.z, t.a.z);
    const VF zx = hn::Mul(hn::Sub(hn::Mul(bz, cy), hn::Mul(cz, by)), inverse);
    const VF zy = hn::Mul(hn::Sub(hn::Mul(cz, bx), hn::Mul(bz, cx)), inverse);
    const VF reach = hn::Add(cells(hn::Add(width, height)), set(16.0f));
    const VF spread = hn::Add(hn::Mul(hn::Abs(bz), hn::Add(hn::Abs(cx), hn::Abs(cy))),
                              hn::Mul(hn::Abs(cz), hn::Add(hn::Abs(bx), hn::Abs(by))));
    const VF condition = hn::Add(set(1.0f), hn::Mul(terms, inverse));
    const VF error =
        hn::Mul(hn::Mul(hn::Mul(set(kPlaneRounding), condition), hn::Mul(spread, inverse)), reach);
    const VF sub_tile =
        hn::Add(hn::Mul(hn::Abs(zx), hn::Add(set(0.5f * float{kSubTileWidth}), growth)),
                hn::Mul(hn::Abs(zy), hn::Add(set(0.5f * float{kSubTileHeight}), growth)));
    const VF z = hn::Add(hn::Sub(hn::Sub(t.a.z, hn::Mul(zx, ax)), hn::Mul(zy, ay)),
                         hn::Add(sub_tile, hn::Add(error, set(kDepthRounding))));
    out.zx = hn::IfThenElseZero(fat, zx);
    out.zy = hn::IfThenElseZero(fat, zy);
    out.z = hn::IfThenElse(fat, z, out.z_max);
    return out;
}

// Writes the wanted prims one behind the other, in four parts of 16 bytes; returns how many.
HWY_INLINE size_t write_prims(M wanted, const Rects& r, uint32_t piece_and_kind,
                              const std::array<Lines, 2>& left, const std::array<Lines, 2>& right,
                              const Planes& z, Prim* out)
{
    const VI low = hn::Or(r.x0, hn::ShiftLeft<16>(r.y0));
    const VI high = hn::Or(r.x1, hn::ShiftLeft<16>(r.y1));
    const VI name = hn::Set(kI, static_cast<int32_t>(piece_and_kind));
    alignas(64) float parts[4][4 * kMostLanes];
    hn::StoreInterleaved4(left[0].slope, left[0].at, left[1].slope, left[1].at, kF, parts[0]);
    hn::StoreInterleaved4(right[0].slope, right[0].at, right[1].slope, right[1].at, kF, parts[1]);
    hn::StoreInterleaved4(z.zx, z.zy, z.z, z.z_max, kF, parts[2]);
    hn::StoreInterleaved4(hn::BitCast(kF, low), hn::BitCast(kF, high), hn::BitCast(kF, name),
                          z.z_min, kF, parts[3]);
    uint8_t bytes[8] = {};
    hn::StoreMaskBits(kF, wanted, bytes);
    size_t count = 0;
    for (unsigned bits = bytes[0] | static_cast<unsigned>(bytes[1]) << 8; bits != 0;
         bits &= bits - 1) {
        const auto lane = static_cast<size_t>(hwy::Num0BitsBelowLS1Bit_Nonzero32(bits));
        auto* to = reinterpret_cast<std::byte*>(out + count++);
        for (size_t part = 0; part < 4; ++part) {
            std::memcpy(to + 16 * part, parts[part] + 4 * lane, 16);
        }
    }
    return count;
}

// Sorts one vector of triangles out and writes the prims of the rest; returns how many.
HWY_INLINE size_t setup_vector(const Triangles& given, const TriangleSetup& setup, Prim* out)
{
    M counterclockwise, clockwise;
    orientation(given, counterclockwise, clockwise);
    M wanted = setup.counterclockwise ? counterclockwise : hn::MaskFromVec(hn::Zero(kF));
    wanted = setup.clockwise ? hn::Or(wanted, clockwise) : wanted;
    const auto turned = hn::RebindMask(kI, clockwise);
    const Triangles t{
        given.a,
        {hn::IfThenElse(turned, given.c.x, given.b.x), hn::IfThenElse(turned, given.c.y, given.b.y),
         hn::IfThenElse(clockwise, given.c.z, given.b.z)},
        {hn::IfThenElse(turned, given.b.x, given.c.x), hn::IfThenElse(turned, given.b.y, given.c.y),
         hn::IfThenElse(clockwise, given.b.z, given.c.z)}};
    const VI low_x = hn::Min(hn::Min(t.a.x, t.b.x), t.c.x);
    const VI low_y = hn::Min(hn::Min(t.a.y, t.b.y), t.c.y);
    const VI high_x = hn::Max(hn::Max(t.a.x, t.b.x), t.c.x);
    const VI high_y = hn::Max(hn::Max(t.a.y, t.b.y), t.c.y);
    const Rects r = cells_of(low_x, low_y, high_x, high_y, setup);
    const auto fills = hn::Not(hn::Or(hn::Gt(r.x0, r.x1), hn::Gt(r.y0, r.y1)));
    wanted = hn::And(wanted, hn::RebindMask(kF, fills));
    if (hn::AllFalse(kF, wanted)) {
        return 0;
    }
    const VI half = hn::Set(kI, kSubcells / 2);
    const VI x0 = hn::Add(hn::ShiftLeft<kSubcellBits>(r.x0), half);
    const VI y0 = hn::Add(hn::ShiftLeft<kSubcellBits>(r.y0), half);
    const VF outward = set(setup.kind == PrimKind::alone ? -(0.5f + setup.growth.edge)
                                                         : 0.5f + setup.growth.touch);
    const Corners corners[4] = {t.a, t.b, t.c, t.a};
    Lines lines[3];
    M left[3];
    M right[3];
    for (size_t i = 0; i < 3; ++i) {
        const Corners& from = corners[i];
        const Corners& to = corners[i + 1];
        const VF dy = cells(hn::Sub(to.y, from.y));
        lines[i] = edge_line(cells(hn::Sub(from.x, x0)), cells(hn::Sub(from.y, y0)),
                             cells(hn::Sub(to.x, from.x)), dy, outward);
        left[i] = hn::Lt(dy, hn::Zero(kF));
        right[i] = hn::Gt(dy, hn::Zero(kF));
    }
    const Lines left0 = choose(left[0], lines[0], choose(left[1], lines[1], lines[2]));
    const Lines left1 = choose(left[2], lines[2], choose(left[1], lines[1], lines[0]));
    const Lines right0 = choose(right[0], lines[0], choose(right[1], lines[1], lines[2]));
    const Lines right1 = choose(right[2], lines[2], choose(right[1], lines[1], lines[0]));
    const Planes z =
        planes_of(t, hn::Sub(high_x, low_x), hn::Sub(high_y, low_y), cells(hn::Sub(t.a.x, x0)),
                  cells(hn::Sub(t.a.y, y0)), set(setup.growth.touch + kRounding));
    return write_prims(wanted, r, Prim::pack(setup.piece, setup.kind), {left0, left1},
                       {right0, right1}, z, out);
}

size_t triangles(std::span<const OccluderMesh::Triangle> triangles, const ScreenVertices& vertices,
                 const TriangleSetup& setup, Prim* out)
{
    size_t count = 0;
    for_each_vector(triangles, vertices, [&](size_t, size_t, const Triangles& t) HWY_ATTR {
        count += setup_vector(t, setup, out + count);
    });
    return count;
}

} // namespace

const SetupKernels* setup_kernel_table()
{
    static constexpr SetupKernels kKernels{&transform, &facings, &triangles};
    return &kKernels;
}

#endif

} // namespace occlude::cpu_fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace occlude::cpu_fast {
HWY_EXPORT(setup_kernel_table);

const SetupKernels& simd_setup_kernels()
{
    return *HWY_DYNAMIC_DISPATCH(setup_kernel_table)();
}

} // namespace occlude::cpu_fast
#endif
