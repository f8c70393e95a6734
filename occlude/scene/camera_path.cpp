#include <occlude/scene/camera_path.h>

#include <occlude/core/assert.h>

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include <algorithm>
#include <cmath>

namespace occlude {
namespace {

/// The point at `s` in [0, 1] between key i and key i + 1 on the cubic Hermite curve whose tangents
/// are the slopes between each key's neighbours (Catmull-Rom for uneven times).
template <class Get>
glm::vec3 on_curve(std::span<const Keyframe> run, size_t i, float s, const Get& get)
{
    const auto tangent = [&](size_t at) {
        const size_t before = at == 0 ? 0 : at - 1;
        const size_t after = std::min(at + 1, run.size() - 1);
        const float span = run[after].time - run[before].time;
        return span > 0.0f ? (get(run[after]) - get(run[before])) / span : glm::vec3{0.0f};
    };
    const float dt = run[i + 1].time - run[i].time;
    const float s2 = s * s;
    const float s3 = s2 * s;
    // Written so that equal keys give exactly their point.
    const glm::vec3 from = get(run[i]);
    return from + (3.0f * s2 - 2.0f * s3) * (get(run[i + 1]) - from) +
           (s3 - 2.0f * s2 + s) * dt * tangent(i) + (s3 - s2) * dt * tangent(i + 1);
}

float mix_range(float a, float b, float s)
{
    // 0 means "chosen from the scene", so it cannot be interpolated.
    return a > 0.0f && b > 0.0f ? a + (b - a) * s : a;
}

/// The camera at `time` in a run of keys without cuts.
Camera camera_at(std::span<const Keyframe> run, float time)
{
    const auto after = std::upper_bound(run.begin(), run.end(), time,
                                        [](float t, const Keyframe& key) { return t < key.time; });
    if (after == run.begin()) {
        return run.front().camera;
    }
    if (after == run.end()) {
        return run.back().camera;
    }
    const size_t i = static_cast<size_t>(after - run.begin()) - 1;
    const float s = (time - run[i].time) / (run[i + 1].time - run[i].time);
    const Camera& a = run[i].camera;
    const Camera& b = run[i + 1].camera;
    Camera camera;
    camera.eye = on_curve(run, i, s, [](const Keyframe& key) { return key.camera.eye; });
    camera.target = on_curve(run, i, s, [](const Keyframe& key) { return key.camera.target; });
    const glm::vec3 up = glm::mix(a.up, b.up, s);
    camera.up = glm::dot(up, up) > 0.0f ? glm::normalize(up) : a.up;
    camera.fov_y = a.fov_y + (b.fov_y - a.fov_y) * s;
    camera.near = mix_range(a.near, b.near, s);
    camera.far = mix_range(a.far, b.far, s);
    return camera;
}

glm::mat4 projection(const Camera& camera, float aspect, ClipConvention convention)
{
    const bool reversed = convention.order == DepthOrder::near_is_large;
    const float first = reversed ? camera.far : camera.near;
    const float last = reversed ? camera.near : camera.far;
    const float fov = glm::radians(camera.fov_y);
    return convention.range == DepthRange::zero_to_one
               ? glm::perspectiveRH_ZO(fov, aspect, first, last)
               : glm::perspectiveRH_NO(fov, aspect, first, last);
}

} // namespace

std::vector<Camera> interpolate(std::span<const Keyframe> keys, size_t frame_count)
{
    OCCLUDE_ASSERT(!keys.empty(), "a path needs at least one key");
    if (keys.empty()) {
        return {};
    }
    OCCLUDE_ASSERT(std::ranges::is_sorted(keys, {}, &Keyframe::time),
                   "the times of a path's keys ascend");
    std::vector<Camera> frames;
    frames.reserve(frame_count);
    const double begin = keys.front().time;
    const double length = static_cast<double>(keys.back().time) - begin;
    size_t run_begin = 0;
    size_t run_end = 0; // of the keys between two cuts
    for (size_t frame = 0; frame < frame_count; ++frame) {
        const double share = frame_count > 1
                                 ? static_cast<double>(frame) / static_cast<double>(frame_count - 1)
                                 : 0.0;
        const auto time = frame + 1 == frame_count && frame > 0
                              ? keys.back().time
                              : static_cast<float>(begin + length * share);
        while (run_end == run_begin || (run_end < keys.size() && keys[run_end].time <= time)) {
            run_begin = run_end;
            ++run_end;
            while (run_end < keys.size() && !keys[run_end].cut) {
                ++run_end;
            }
        }
        frames.push_back(camera_at(keys.subspan(run_begin, run_end - run_begin), time));
    }
    return frames;
}

View make_view(const Camera& camera, glm::ivec2 size_px, ClipConvention convention,
               const ViewOptions& options)
{
    OCCLUDE_ASSERT(camera.near > 0.0f && camera.far > camera.near, "0 < near < far");
    OCCLUDE_ASSERT(camera.fov_y > 0.0f && camera.fov_y < 180.0f,
                   "a camera's field of view is between 0 and 180 degrees");
    // In double and as directions: a target close to the eye may equal the eye in float.
    glm::dvec3 forward = glm::dvec3{camera.target} - glm::dvec3{camera.eye};
    const double distance = glm::length(forward);
    forward = distance > 0.0 ? forward / distance : glm::dvec3{0.0, 0.0, -1.0};

    glm::dvec3 up{camera.up};
    const double up_length = glm::length(up);
    constexpr double kParallel = 1e-4; // sine of the angle between up and the view direction
    if (!(up_length > 0.0) || glm::length(glm::cross(forward, up / up_length)) < kParallel) {
        // The axis that is farthest from the view direction.
        const glm::dvec3 along = glm::abs(forward);
        up = along.y <= along.x && along.y <= along.z ? glm::dvec3{0.0, 1.0, 0.0}
             : along.z <= along.x                     ? glm::dvec3{0.0, 0.0, 1.0}
                                                      : glm::dvec3{1.0, 0.0, 0.0};
    }
    const glm::dvec3 right = glm::normalize(glm::cross(forward, up));
    const glm::dmat4 eye_from_relative =
        glm::transpose(glm::dmat4{glm::dmat3{right, glm::cross(right, forward), -forward}});
    const float aspect =
        static_cast<float>(std::max(size_px.x, 1)) / static_cast<float>(std::max(size_px.y, 1));
    const glm::dmat4 clip_from_eye{projection(camera, aspect, convention)};
    return View::camera_relative(glm::mat4{clip_from_eye * eye_from_relative},
                                 glm::dvec3{camera.eye}, size_px, convention, options);
}

} // namespace occlude
