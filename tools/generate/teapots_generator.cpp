#include "generate/teapots_generator.h"

#include "generate/teapot.h"
#include "walk/path_tools.h"

#include <occlude/core/rng.h>

#include <fmt/format.h>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include <algorithm>

namespace occlude::tools {
namespace {

constexpr float kSpacing = 4.0f; // of middles, in Newell's units
constexpr float kFreeWay = 4.6f; // from the middle of a teapot (3.6 long at most) to the path
constexpr glm::vec3 kMiddle{0.25f, 1.5f, 0.0f}; // of a teapot

float random_sign_range(Rng& rng)
{
    return rng.range(-1.0f, 1.0f);
}

/// A turn about the origin, all alike likely.
glm::mat3 random_turn(Rng& rng)
{
    for (;;) {
        const float w = random_sign_range(rng);
        const float x = random_sign_range(rng);
        const float y = random_sign_range(rng);
        const float z = random_sign_range(rng);
        const float square = w * w + x * x + y * y + z * z;
        if (square <= 1.0f && square > 0.01f) {
            return glm::mat3_cast(glm::normalize(glm::quat{w, x, y, z}));
        }
    }
}

/// Around a corner of the heap, past one of its faces, then through it and out at the other side.
std::vector<glm::vec3> way_of_flight(float half)
{
    const std::vector<glm::vec3> corners{
        {-1.25f, 0.35f, 1.25f}, {0.0f, 0.3f, 1.45f},  {0.75f, 0.15f, 1.2f}, {0.45f, 0.1f, 0.5f},
        {0.0f, -0.1f, 0.0f},    {-0.5f, 0.1f, -0.3f}, {-0.3f, 0.0f, -1.3f}};
    std::vector<glm::vec3> scaled;
    for (const glm::vec3& corner : corners) {
        scaled.push_back(half * corner);
    }
    return resampled(rounded(scaled, 0.45f * half), 0.04f * half);
}

std::vector<Keyframe> flight(const std::vector<glm::vec3>& way, float half)
{
    std::vector<Keyframe> keys;
    for (size_t i = 0; i < way.size(); ++i) {
        const float share = static_cast<float>(i) / static_cast<float>(way.size() - 1);
        Keyframe key;
        key.time = 60.0f * share;
        key.camera.eye = way[i];
        // Outside it looks at the heap, inside along its way, at the end back into the heap's edge.
        const glm::vec3 ahead =
            way[std::min(i + 5, way.size() - 1)] +
            (i + 5 >= way.size() ? glm::vec3{0.0f, 0.0f, -0.2f * half} : glm::vec3{0.0f});
        const float in = std::clamp((share - 0.25f) / 0.3f, 0.0f, 1.0f);
        const float smooth = in * in * (3.0f - 2.0f * in);
        const glm::vec3 to_heap = glm::normalize(-way[i]);
        const glm::vec3 along = glm::normalize(ahead - way[i]);
        key.camera.target = way[i] + 10.0f * glm::normalize(glm::mix(to_heap, along, smooth));
        keys.push_back(key);
    }
    return keys;
}

/// A short piece of the flight with the whole heap ahead: one and a half teapots long among 5,000,
/// so that 120 frames take 75 to pass a teapot.
std::vector<Keyframe> drift(const std::vector<Keyframe>& flight)
{
    return {flight.begin() + 20, flight.begin() + 25};
}

bool is_free(const glm::vec3& point, const std::vector<glm::vec3>& way)
{
    return std::all_of(way.begin(), way.end(), [&](const glm::vec3& on_way) {
        return glm::distance(point, on_way) > kFreeWay;
    });
}

} // namespace

SceneModel generate_teapots(const TeapotsOptions& options, const SceneOptions& scene_options)
{
    SceneModel model;
    model.name = fmt::format("teapots:count={},triangles={},seed={}", options.count,
                             options.triangles, options.seed);
    model.meshes.push_back(
        make_teapot(teapot_steps(options.triangles), std::max(scene_options.item_triangles, 1u)));
    uint64_t side = 4; // in a smaller heap there would be no room beside the flight
    while (side * side * side < options.count) {
        ++side;
    }
    const float half = 0.5f * kSpacing * static_cast<float>(side);
    const std::vector<glm::vec3> way = way_of_flight(half);
    Rng rng(hash64(options.seed, 21));
    for (uint64_t i = 0; i < options.count; ++i) {
        glm::vec3 at{0.0f};
        do {
            for (int axis = 0; axis < 3; ++axis) {
                at[axis] = half * random_sign_range(rng);
            }
        } while (!is_free(at, way));
        const glm::mat3 turn = random_turn(rng);
        glm::mat4 world_from_mesh{turn};
        world_from_mesh[3] = glm::vec4{at - turn * kMiddle, 1.0f};
        const float red = rng.range(0.25f, 0.9f);
        const float green = rng.range(0.25f, 0.9f);
        model.instances.push_back({fmt::format("teapot {}", i), 0, world_from_mesh,
                                   glm::vec3{red, green, rng.range(0.25f, 0.9f)}});
    }
    const std::vector<Keyframe> whole = flight(way, half);
    model.paths = {{"flight", whole}, {"drift", drift(whole)}};
    return model;
}

} // namespace occlude::tools
