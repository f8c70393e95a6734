#include "worlds/rays.h"

#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>

#include <array>
#include <cmath>
#include <vector>

#include <embree3/rtcore.h>

namespace occlude::worlds {

namespace {

// Rays go from the near plane (0) to the far plane (1). Where two surfaces are closer than this
// share of it, float rounding may choose either.
constexpr float kClearlyNearer = 1e-4f;
// Rays beside the centre of a pixel, so that an edge through it is noticed.
constexpr float kBeside = 0.05f;

struct Hit {
    unsigned item = RTC_INVALID_GEOMETRY_ID;
    float at = 1.0f;
};

glm::dvec3 unproject(const glm::dmat4& world_from_clip, glm::dvec2 ndc, double z)
{
    const glm::dvec4 point = world_from_clip * glm::dvec4{ndc, z, 1.0};
    return glm::dvec3{point} / point.w;
}

} // namespace

struct Rays::Scene {
    RTCDevice device = rtcNewDevice("threads=1");
    RTCScene scene = rtcNewScene(device);

    Scene() { rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST); }
    ~Scene()
    {
        rtcReleaseScene(scene);
        rtcReleaseDevice(device);
    }
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;

    void add(unsigned item, const std::vector<glm::vec3>& corners)
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
                vertices[3 * i + static_cast<size_t>(axis)] = corners[i][axis];
            }
            indices[i] = static_cast<unsigned>(i);
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene, geometry, item);
        rtcReleaseGeometry(geometry);
    }

    Hit first(const glm::dvec3& origin, const glm::dvec3& direction) const
    {
        RTCRayHit ray{};
        ray.ray.org_x = static_cast<float>(origin.x);
        ray.ray.org_y = static_cast<float>(origin.y);
        ray.ray.org_z = static_cast<float>(origin.z);
        ray.ray.dir_x = static_cast<float>(direction.x);
        ray.ray.dir_y = static_cast<float>(direction.y);
        ray.ray.dir_z = static_cast<float>(direction.z);
        ray.ray.tnear = 0.0f;
        ray.ray.tfar = 1.0f;
        ray.ray.mask = ~0u;
        ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene, &context, &ray);
        return {ray.hit.geomID, ray.hit.geomID == RTC_INVALID_GEOMETRY_ID ? 1.0f : ray.ray.tfar};
    }
};

Rays::Rays(const RandomScene& scene)
    : scene_(std::make_unique<Scene>())
{
    for (size_t i = 0; i < scene.bounds().size(); ++i) {
        const std::vector<glm::vec3> corners = scene.triangles(ItemId{i});
        if (!corners.empty() && !has_flag(scene.bounds()[i].flags, ItemFlags::translucent)) {
            scene_->add(static_cast<unsigned>(i), corners);
        }
    }
    rtcCommitScene(scene_->scene);
}

Rays::~Rays() = default;

std::string Rays::disagrees(const View& view, const CpuDevice& picture, uint64_t& compared) const
{
    const glm::dmat4 world_from_clip = glm::inverse(glm::dmat4{view.clip_from_world()});
    const bool reversed = view.convention().order == DepthOrder::near_is_large;
    const double low = view.convention().range == DepthRange::zero_to_one ? 0.0 : -1.0;
    const glm::ivec2 size = view.size_px();
    for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
            std::array<Hit, 5> hits;
            bool agree = true;
            for (size_t i = 0; i < hits.size(); ++i) {
                const glm::dvec2 beside{(i == 1 ? kBeside : 0.0f) - (i == 2 ? kBeside : 0.0f),
                                        (i == 3 ? kBeside : 0.0f) - (i == 4 ? kBeside : 0.0f)};
                const glm::dvec2 ndc =
                    (glm::dvec2{x, y} + 0.5 + beside) / glm::dvec2{size} * 2.0 - 1.0;
                const glm::dvec3 near = unproject(world_from_clip, ndc, reversed ? 1.0 : low);
                const glm::dvec3 far = unproject(world_from_clip, ndc, reversed ? low : 1.0);
                hits[i] = scene_->first(near, far - near);
                agree = agree && hits[i].item == hits[0].item &&
                        std::abs(hits[i].at - hits[0].at) < kClearlyNearer &&
                        hits[i].at > kClearlyNearer;
            }
            if (!agree || hits[0].at > 1.0f - kClearlyNearer) {
                continue; // an edge, a face seen from the side, or something at the near plane
            }
            ++compared;
            const size_t pixel = static_cast<size_t>(y * size.x + x);
            const ItemId owner =
                picture.depth()[pixel] < 1.0f ? picture.owner(pixel).item : ItemId{};
            if (owner == ItemId{hits[0].item}) {
                continue;
            }
            // Two surfaces in one place: whichever is drawn, the other lies as far away.
            const glm::dvec2 ndc = (glm::dvec2{x, y} + 0.5) / glm::dvec2{size} * 2.0 - 1.0;
            const glm::dvec3 near = unproject(world_from_clip, ndc, reversed ? 1.0 : low);
            const glm::dvec3 far = unproject(world_from_clip, ndc, reversed ? low : 1.0);
            const glm::dvec3 point = near + static_cast<double>(hits[0].at) * (far - near);
            const glm::dvec4 clip = glm::dmat4{view.clip_from_world()} * glm::dvec4{point, 1.0};
            const double z = clip.z / clip.w;
            const double stored = low == 0.0 ? z : 0.5 * z + 0.5;
            const double depth = reversed ? 1.0 - stored : stored;
            if (std::abs(depth - static_cast<double>(picture.depth()[pixel])) > 1e-3) {
                return "pixel " + std::to_string(x) + ", " + std::to_string(y) +
                       ": rays see item " + std::to_string(hits[0].item) +
                       (owner.valid() ? ", the picture shows item " + std::to_string(owner.value)
                                      : std::string{", the picture shows nothing"});
            }
        }
    }
    return {};
}

} // namespace occlude::worlds
