#include <occlude/backends/cpu_fast/detail/clipping.h>

#include <occlude/backends/cpu_fast/detail/triangle_setup.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace occlude::cpu_fast {

namespace {

int32_t snapped(double cells)
{
    return static_cast<int32_t>(std::nearbyint(cells * kSubcells));
}

// Gives the corners that clipping made their places on the grid, and drops edges of length 0.
void snap(Polygon& polygon, float z_slack)
{
    for (size_t i = 0; i < polygon.count; ++i) {
        PolygonCorner& corner = polygon.corners[i];
        if (!corner.given) {
            const glm::dvec4& c = corner.clip;
            corner.corner = {snapped(c.x / c.w), snapped(c.y / c.w),
                             std::max(static_cast<float>(c.z / c.w) + z_slack + 0x1p-24f, 0.0f)};
        }
    }
    size_t kept = 0;
    for (size_t i = 0; i < polygon.count; ++i) {
        const Corner& here = polygon.corners[i].corner;
        const Corner& next = polygon.corners[(i + 1) % polygon.count].corner;
        if (here.x != next.x || here.y != next.y) {
            polygon.corners[kept++] = polygon.corners[i];
        } else {
            // The next corner takes its place, with the farther depth of both.
            Corner& other = polygon.corners[(i + 1) % polygon.count].corner;
            other.z = std::max(other.z, here.z);
        }
    }
    polygon.count = kept;
}

} // namespace

int8_t Polygon::facing() const
{
    bool left = true;
    bool right = true;
    for (size_t i = 2; i < count; ++i) {
        const int64_t twice =
            twice_area(corners[0].corner, corners[i - 1].corner, corners[i].corner);
        left = left && twice > 0;
        right = right && twice < 0;
    }
    return static_cast<int8_t>(count < 3 || left == right ? 0 : left ? 1 : -1);
}

// Sutherland and Hodgman. An edge is cut from its inside to its outside, whichever way it runs, so
// that both of its triangles find the same point; vertices that need no clipping count as inside.
void clip(const InstanceTransform& transform, Polygon& polygon)
{
    struct Plane {
        glm::dvec4 normal;
        double offset;
        uint8_t edge;
    };
    const glm::dvec2 low{transform.guard_low};
    const glm::dvec2 high{transform.guard_high};
    const std::array<Plane, 6> planes{{
        {{0.0, 0.0, 0.0, 1.0}, double{transform.least_w}, kCutEdge},
        {{0.0, 0.0, 1.0, 0.0}, double{transform.least_z}, kCutEdge},
        {{1.0, 0.0, 0.0, -low.x}, 0.0, kGuardEdge},
        {{-1.0, 0.0, 0.0, high.x}, 0.0, kGuardEdge},
        {{0.0, 1.0, 0.0, -low.y}, 0.0, kGuardEdge},
        {{0.0, -1.0, 0.0, high.y}, 0.0, kGuardEdge},
    }};
    for (const Plane& plane : planes) {
        if (std::isinf(plane.offset)) {
            continue; // no near plane
        }
        const auto distance = [&](const PolygonCorner& corner) {
            const double d = glm::dot(plane.normal, corner.clip) - plane.offset;
            return corner.given ? std::max(d, 0.0) : d;
        };
        Polygon kept;
        for (size_t i = 0; i < polygon.count; ++i) {
            const PolygonCorner& from = polygon.corners[i];
            const PolygonCorner& to = polygon.corners[(i + 1) % polygon.count];
            const double d_from = distance(from);
            const double d_to = distance(to);
            const bool from_inside = d_from >= 0.0;
            const bool to_inside = d_to >= 0.0;
            if (from_inside) {
                kept.corners[kept.count++] = from;
            }
            if (from_inside != to_inside) {
                const PolygonCorner& in = from_inside ? from : to;
                const PolygonCorner& out = from_inside ? to : from;
                const double t = from_inside ? d_from / (d_from - d_to) : d_to / (d_to - d_from);
                PolygonCorner& cut = kept.corners[kept.count++];
                cut.clip = in.clip + t * (out.clip - in.clip);
                cut.given = false;
                cut.edge = from_inside ? plane.edge : from.edge;
            }
        }
        polygon = kept;
    }
    snap(polygon, transform.z_slack);
}

} // namespace occlude::cpu_fast
