#include "generate/city_paths.h"

#include "walk/path_tools.h"

#include <occlude/core/rng.h>

#include <algorithm>

namespace occlude::tools {
namespace {

constexpr float kEyeHeight = 1.7f;
constexpr float kWalkSpeed = 1.4f; // metres per second
constexpr float kCorner = 5.0f;    // corners are cut this far before them

/// A walk through the middle of the city: along a street, down a lane, along the next street, down
/// the next lane and on.
std::vector<glm::vec3> street_corners(const CityStreets& streets)
{
    const uint32_t middle = streets.blocks() / 2;
    const uint32_t column = middle;
    const float first_z = streets.avenue_z(middle);
    const float second_z = streets.avenue_z(middle + 1);
    const float lane = streets.lane_x(middle, column);
    const auto at = [](float x, float z) { return glm::vec3{x, kEyeHeight, z}; };
    return {at(lane - 60.0f, first_z), at(lane, first_z), at(lane, second_z),
            at(lane + 60.0f, second_z)};
}

std::vector<Keyframe> rise_keys(const std::vector<Keyframe>& walk, const CityStreets& streets)
{
    std::vector<Keyframe> keys(walk.begin(), walk.begin() + static_cast<long>(walk.size() / 4));
    const Camera from = keys.back().camera;
    const float start = keys.back().time;
    const glm::vec3 ahead = from.target - from.eye;
    constexpr uint32_t kSteps = 12;
    for (uint32_t i = 1; i <= kSteps; ++i) {
        const float t = static_cast<float>(i) / static_cast<float>(kSteps);
        const float smooth = t * t * (3.0f - 2.0f * t);
        Keyframe key = keys.back();
        key.time = start + 4.0f * static_cast<float>(i);
        key.camera.eye = from.eye + glm::vec3{0.0f, smooth * 110.0f, 0.0f};
        // Looks on ahead, and down more and more, at last at the city's middle distance.
        const float reach = 1.0f + smooth * (0.4f * streets.half_size() - 1.0f) / 10.0f;
        key.camera.target = key.camera.eye + ahead * reach;
        key.camera.target.y = kEyeHeight;
        keys.push_back(key);
    }
    return keys;
}

std::vector<Keyframe> roof_keys(const CityStreets& streets)
{
    const float half = streets.half_size();
    std::vector<Keyframe> keys;
    for (uint32_t i = 0; i <= 4; ++i) {
        const float t = static_cast<float>(i) / 4.0f;
        Keyframe key;
        key.time = 15.0f * static_cast<float>(i);
        const float bow = 4.0f * t * (1.0f - t);
        key.camera.eye = {half * (0.8f * t - 0.4f), 1.25f * half + 60.0f,
                          half * (0.55f - 0.15f * bow)};
        key.camera.target = {0.3f * half * (2.0f * t - 1.0f), 0.0f, 0.03f * half};
        keys.push_back(key);
    }
    return keys;
}

} // namespace

CityStreets::CityStreets(uint32_t blocks, uint64_t seed)
    : blocks_(blocks)
{
    for (uint32_t row = 0; row < blocks; ++row) {
        // Half a block to and fro, so that lanes end at facades, and not all at their middle.
        const float jitter = 16.0f * uniform01(hash64(seed, row, 300)) - 8.0f;
        shifts_.push_back((row % 2 == 0 ? -0.25f : 0.25f) * kPitch + jitter);
    }
}

glm::vec3 CityStreets::block_center(uint32_t row, uint32_t column) const
{
    const float middle = 0.5f * static_cast<float>(blocks_ - 1);
    return {kPitch * (static_cast<float>(column) - middle) + shifts_[row], 0.0f,
            kPitch * (static_cast<float>(row) - middle)};
}

float CityStreets::avenue_z(uint32_t row) const
{
    return kPitch * (static_cast<float>(row) - 0.5f * static_cast<float>(blocks_));
}

float CityStreets::lane_x(uint32_t row, uint32_t column) const
{
    return block_center(row, column).x - 0.5f * kPitch;
}

std::vector<SceneModel::NamedPath> city_paths(const CityStreets& streets)
{
    const std::vector<glm::vec3> corners = street_corners(streets);
    const WalkStyle style{.speed = kWalkSpeed, .look_ahead = 12.0f};
    const std::vector<Keyframe> street = walk_along(rounded(corners, kCorner), style);
    return {{"street", street},
            {"rise", rise_keys(street, streets)},
            {"roofs", roof_keys(streets)},
            {"teleport", with_cuts(street, glm::vec3{0.0f, 1.0f, 0.0f})}};
}

std::vector<Keyframe> rise_from(const Camera& street, float height, float reach)
{
    constexpr uint32_t kSteps = 12;
    std::vector<Keyframe> keys;
    const glm::vec3 ahead = street.target - street.eye;
    for (uint32_t i = 0; i <= kSteps; ++i) {
        const float t = static_cast<float>(i) / static_cast<float>(kSteps);
        const float smooth = t * t * (3.0f - 2.0f * t);
        Keyframe key{4.0f * static_cast<float>(i), street, false};
        key.camera.eye.y += height * smooth;
        key.camera.target = key.camera.eye + ahead * (1.0f + reach * smooth);
        key.camera.target.y = kEyeHeight;
        keys.push_back(key);
    }
    return keys;
}

} // namespace occlude::tools
