#include "worlds/rays.h"

#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <sstream>
#include <vector>

#include <embree3/rtcore.h>

namespace occlude::worlds {

namespace {

// Rays go from the near plane (0) to the far plane (1). Where two surfaces are closer together than
// this share of the ray, rounding to float may choose either.
constexpr double kClearlyNearer = 1e-4;
constexpr double kSamePlace = 2.0 * kClearlyNearer;
// Four steps of a float below 1, in window depth.
constexpr double kDepthSteps = 0x1p-22;
// Rays beside the centre of a pixel detect edges that pass through the pixel.
constexpr double kBeside = 0.05;

struct Hit {
    unsigned item = RTC_INVALID_GEOMETRY_ID;
    double at = 1.0;
    double depth01 = 1.0;
    double depth_error = kDepthSteps; ///< of a rasteriser: it moves vertices, with their depths, to
                                      ///< a grid of 1/256 pixel
};

/// From the near plane (at 0) to the far plane, or beyond the whole scene, (at 1), relative to the
/// centre of the scene.
struct Ray {
    glm::dvec3 origin{0.0};
    glm::dvec3 direction{0.0};

    double at(const glm::dvec3& point) const
    {
        return glm::dot(point - origin, direction) / glm::dot(direction, direction);
    }
};

/// From pixels and window depth to positions relative to a centre.
class Unprojection {
public:
    Unprojection(const View& view, const glm::dvec3& center)
        : clip_from_relative_(view.clip_from_relative())
        , relative_from_clip_(glm::inverse(clip_from_relative_))
        , offset_(view.origin() - center)
        , size_(view.size_px())
        , reversed_(view.convention().order == DepthOrder::near_is_large)
        , low_(view.convention().range == DepthRange::zero_to_one ? 0.0 : -1.0)
    {
    }

    /// No point behind the eye, and none at infinity.
    std::optional<glm::dvec3> point(glm::dvec2 px, double depth01) const
    {
        const double stored = reversed_ ? 1.0 - depth01 : depth01;
        const glm::dvec4 p = relative_from_clip_ *
                             glm::dvec4{px / size_ * 2.0 - 1.0, low_ + (1.0 - low_) * stored, 1.0};
        const glm::dvec3 point = glm::dvec3{p} / p.w + offset_;
        const bool before_eye = p.w > 0.0 && std::isfinite(glm::dot(point, point));
        return before_eye ? std::optional{point} : std::nullopt;
    }

    double depth01(const glm::dvec3& point) const
    {
        const glm::dvec4 clip = clip_from_relative_ * glm::dvec4{point - offset_, 1.0};
        const double stored = (clip.z / clip.w - low_) / (1.0 - low_);
        return reversed_ ? 1.0 - stored : stored;
    }

    /// (x, y, 1) times w of a point on the screen, counted from `middle`, in pixels.
    glm::dvec3 from_middle(const glm::dvec3& point, const glm::dvec2& middle) const
    {
        const glm::dvec4 clip = clip_from_relative_ * glm::dvec4{point - offset_, 1.0};
        const glm::dvec2 px = 0.5 * (glm::dvec2{clip} + clip.w) * size_ - middle * clip.w;
        return {px, clip.w};
    }

    /// At most `length` long: far planes may lie at infinity, and oblique ones behind the horizon.
    std::optional<Ray> ray(glm::dvec2 px, double length) const
    {
        const auto near = point(px, 0.0);
        const auto beyond = point(px, 1.0 / 64.0);
        if (!near || !beyond) {
            return std::nullopt;
        }
        const auto far = point(px, 1.0);
        const double to_far = far ? glm::distance(*near, *far) : length;
        return Ray{*near, std::min(length, to_far) * glm::normalize(*beyond - *near)};
    }

private:
    glm::dmat4 clip_from_relative_;
    glm::dmat4 relative_from_clip_;
    glm::dvec3 offset_;
    glm::dvec2 size_;
    bool reversed_;
    double low_;
};

/// True if a triangle reaches to within a snap of the middle of a pixel. Rasterisers move vertices
/// to a grid of 1/256 pixel. A triangle edge-on, or thinner than the distance of the rays, may
/// therefore show where no ray meets it. Needs no clipping: its edges are lines through the eye.
bool within_a_snap(const Unprojection& unprojection, const std::array<glm::dvec3, 3>& triangle,
                   const glm::dvec2& middle)
{
    constexpr double kSnap = 1.0 / 128.0;
    std::array<glm::dvec3, 3> corners;
    for (size_t i = 0; i < corners.size(); ++i) {
        corners[i] = unprojection.from_middle(triangle[i], middle);
    }
    bool inside_left = true;
    bool inside_right = true;
    for (size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec3 line = glm::cross(corners[i], corners[(i + 1) % corners.size()]);
        const double distance = line.z / glm::length(glm::dvec2{line});
        inside_left = inside_left && !(distance < -kSnap);
        inside_right = inside_right && !(distance > kSnap);
    }
    return inside_left || inside_right;
}

/// The same for the triangle that a pixel shows.
bool shows_by_a_snap(const RandomScene& world, const Unprojection& unprojection,
                     const glm::dvec3& center, const CpuDevice::Owner& owner,
                     const glm::dvec2& middle)
{
    const std::vector<glm::vec3> corners = world.triangles(owner.item);
    const size_t first = 3 * size_t{owner.triangle};
    return first + 2 < corners.size() && within_a_snap(unprojection,
                                                       {glm::dvec3{corners[first]} - center,
                                                        glm::dvec3{corners[first + 1]} - center,
                                                        glm::dvec3{corners[first + 2]} - center},
                                                       middle);
}

/// One for each thread: to create one takes longer than a world.
RTCDevice device_of_thread()
{
    struct Owned {
        RTCDevice device = rtcNewDevice("threads=1");
        ~Owned() { rtcReleaseDevice(device); }
    };
    thread_local Owned owned;
    return owned.device;
}

} // namespace

struct Rays::Scene {
    RTCDevice device = device_of_thread();
    RTCScene scene = rtcNewScene(device);

    Scene() { rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST); }
    ~Scene() { rtcReleaseScene(scene); }
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;

    void add(unsigned item, const std::vector<glm::vec3>& corners, const glm::dvec3& center)
    {
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* vertices = static_cast<float*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                    sizeof(glm::vec3), corners.size()));
        auto* indices = static_cast<unsigned*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                    3 * sizeof(unsigned), corners.size() / 3));
        for (size_t i = 0; i < corners.size(); ++i) {
            for (int axis = 0; axis < 3; ++axis) {
                vertices[3 * i + static_cast<size_t>(axis)] =
                    static_cast<float>(double{corners[i][axis]} - center[axis]);
            }
            indices[i] = static_cast<unsigned>(i);
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene, geometry, item);
        rtcReleaseGeometry(geometry);
    }

    Hit first(const Ray& along) const
    {
        RTCRayHit ray{};
        ray.ray.org_x = static_cast<float>(along.origin.x);
        ray.ray.org_y = static_cast<float>(along.origin.y);
        ray.ray.org_z = static_cast<float>(along.origin.z);
        ray.ray.dir_x = static_cast<float>(along.direction.x);
        ray.ray.dir_y = static_cast<float>(along.direction.y);
        ray.ray.dir_z = static_cast<float>(along.direction.z);
        ray.ray.tnear = 0.0f;
        ray.ray.tfar = 1.0f;
        ray.ray.mask = ~0u;
        ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene, &context, &ray);
        return {ray.hit.geomID,
                ray.hit.geomID == RTC_INVALID_GEOMETRY_ID ? 1.0 : double{ray.ray.tfar}};
    }

    /// The item that all rays through and around the middle of a pixel meet at about the same
    /// depth.
    std::optional<Hit> sure(const Unprojection& unprojection, const glm::dvec2& middle,
                            double length) const
    {
        constexpr std::array<glm::dvec2, 5> kAround{
            {{0.0, 0.0}, {kBeside, 0.0}, {-kBeside, 0.0}, {0.0, kBeside}, {0.0, -kBeside}}};
        std::optional<Hit> known;
        for (const glm::dvec2& beside : kAround) {
            const auto ray = unprojection.ray(middle + beside, length);
            const Hit hit = ray ? first(*ray) : Hit{};
            const bool clear = hit.at > kClearlyNearer && hit.at < 1.0 - kClearlyNearer;
            if (!clear || (known && (hit.item != known->item ||
                                     std::abs(hit.at - known->at) >= kClearlyNearer))) {
                return std::nullopt;
            }
            const double depth01 = unprojection.depth01(ray->origin + hit.at * ray->direction);
            if (!known) {
                known = hit;
                known->depth01 = depth01;
            }
            const double per_pixel = std::abs(depth01 - known->depth01) / kBeside;
            known->depth_error = std::max(known->depth_error, kDepthSteps + per_pixel / 128.0);
        }
        return known;
    }
};

Rays::Rays(const RandomScene& scene)
    : world_(scene)
    , scene_(std::make_unique<Scene>())
    , center_(scene.center())
    , length_(8.0 * double{RandomScene::kReach} * double{scene.unit()})
{
    for (size_t i = 0; i < scene.bounds().size(); ++i) {
        const std::vector<glm::vec3> corners = scene.triangles(ItemId{i});
        if (!corners.empty() && !has_flag(scene.bounds()[i].flags, ItemFlags::translucent)) {
            scene_->add(static_cast<unsigned>(i), corners, center_);
        }
    }
    rtcCommitScene(scene_->scene);
}

Rays::~Rays() = default;

std::string Rays::disagrees(const View& view, const CpuDevice& picture, uint32_t pixels,
                            uint64_t seed, uint64_t& compared) const
{
    if (view.ignores_near_plane()) {
        return {};
    }
    const Unprojection unprojection{view, center_};
    const auto width = static_cast<uint32_t>(view.size_px().x);
    const uint32_t all = width * static_cast<uint32_t>(view.size_px().y);
    Rng rng{seed};
    for (uint32_t i = 0; i < std::min(pixels, all); ++i) {
        const uint32_t pixel = pixels >= all ? i : rng.below(all);
        const glm::dvec2 middle = glm::dvec2{pixel % width, pixel / width} + 0.5;
        const auto ray = unprojection.ray(middle, length_);
        const std::optional<Hit> hit =
            ray ? scene_->sure(unprojection, middle, length_) : std::nullopt;
        if (!hit) {
            continue; // an edge, a face seen from the side, or something at the near plane
        }
        ++compared;
        const float depth = picture.depth()[pixel];
        const ItemId owner = depth < 1.0f ? picture.owner(pixel).item : ItemId{};
        if (owner == ItemId{hit->item}) {
            continue;
        }
        // Two surfaces in one place, or closer together than a rasteriser can distinguish (as with
        // oblique near planes, where depth varies much over the screen): either may be drawn.
        const auto shown = unprojection.point(middle, double{depth});
        const bool same_place = shown && std::abs(ray->at(*shown) - hit->at) <= kSamePlace;
        if (same_place || std::abs(hit->depth01 - double{depth}) <= hit->depth_error) {
            continue;
        }
        const bool before_hit = shown && ray->at(*shown) < hit->at;
        if (!before_hit ||
            !shows_by_a_snap(world_, unprojection, center_, picture.owner(pixel), middle)) {
            std::ostringstream text;
            text << "pixel " << pixel % width << ", " << pixel / width << ": rays see item "
                 << hit->item << " after " << hit->at << " of their way, at depth " << hit->depth01
                 << "; the picture shows ";
            if (owner.valid()) {
                text << "item " << owner.value << " after " << (shown ? ray->at(*shown) : 1.0);
            } else {
                text << "nothing";
            }
            text << ", at depth " << depth;
            return text.str();
        }
    }
    return {};
}

} // namespace occlude::worlds
