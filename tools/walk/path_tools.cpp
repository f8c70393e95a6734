#include "walk/path_tools.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace occlude::tools {

std::vector<glm::vec3> rounded(std::span<const glm::vec3> corners, float cut)
{
    constexpr uint32_t kSteps = 8;
    if (corners.size() < 3) {
        return {corners.begin(), corners.end()};
    }
    std::vector<glm::vec3> points{corners.front()};
    for (size_t i = 1; i + 1 < corners.size(); ++i) {
        const auto toward = [&](const glm::vec3& other) {
            const float distance = glm::distance(corners[i], other);
            const float reach = std::min(cut, 0.5f * distance);
            return distance > 0.0f ? corners[i] + (other - corners[i]) * (reach / distance)
                                   : corners[i];
        };
        const glm::vec3 from = toward(corners[i - 1]);
        const glm::vec3 to = toward(corners[i + 1]);
        for (uint32_t step = 0; step <= kSteps; ++step) {
            const float t = static_cast<float>(step) / static_cast<float>(kSteps);
            points.push_back((1.0f - t) * (1.0f - t) * from + 2.0f * t * (1.0f - t) * corners[i] +
                             t * t * to);
        }
    }
    points.push_back(corners.back());
    return points;
}

std::vector<glm::vec3> resampled(std::span<const glm::vec3> points, float spacing)
{
    float length = 0.0f;
    for (size_t i = 1; i < points.size(); ++i) {
        length += glm::distance(points[i - 1], points[i]);
    }
    const auto count = std::max(1u, static_cast<uint32_t>(length / spacing + 0.5f));
    const float step = length / static_cast<float>(count);
    std::vector<glm::vec3> result{points.front()};
    float walked = 0.0f; // at points[i - 1]
    for (size_t i = 1; i < points.size(); ++i) {
        const float piece = glm::distance(points[i - 1], points[i]);
        while (result.size() < count && step * static_cast<float>(result.size()) < walked + piece) {
            const float s = (step * static_cast<float>(result.size()) - walked) / piece;
            result.push_back(glm::mix(points[i - 1], points[i], s));
        }
        walked += piece;
    }
    result.push_back(points.back());
    return result;
}

std::vector<Keyframe> walk_along(std::span<const glm::vec3> points, const WalkStyle& style)
{
    // The heading follows the way ahead with a short lag, so that hairpins become quick turns.
    constexpr float kFollow = 0.35f;
    constexpr float kTooNear = 0.4f; // of look_ahead: the way turns back, the heading waits
    const std::vector<glm::vec3> eyes = resampled(points, style.key_distance);
    const auto ahead =
        std::max(size_t{1}, static_cast<size_t>(style.look_ahead / style.key_distance));
    std::vector<Keyframe> keys;
    glm::vec3 heading{0.0f};
    float time = 0.0f;
    for (size_t i = 0; i < eyes.size(); ++i) {
        if (i > 0) {
            time += glm::distance(eyes[i - 1], eyes[i]) / style.speed;
        }
        const glm::vec3 way = eyes[std::min(i + ahead, eyes.size() - 1)] - eyes[i];
        const float distance = glm::length(way);
        if (i == 0) {
            heading = distance > 0.0f ? way / distance : points[1] - points[0];
        } else if (distance > kTooNear * style.look_ahead) {
            glm::vec3 turned = glm::mix(heading, way / distance, kFollow);
            if (glm::dot(heading, way) < -0.9f * distance) {
                turned += 0.5f * glm::cross(style.up, heading); // straight back: turn leftward
            }
            heading = glm::normalize(turned);
        }
        Keyframe key;
        key.time = time;
        key.camera.eye = eyes[i];
        key.camera.target = eyes[i] + style.look_ahead * heading;
        key.camera.up = style.up;
        key.camera.fov_y = style.fov_y;
        keys.push_back(key);
    }
    return keys;
}

std::vector<Keyframe> with_cuts(std::span<const Keyframe> keys, const glm::vec3& up)
{
    constexpr std::array<size_t, 8> kOrder{0, 4, 1, 6, 3, 7, 2, 5};
    if (keys.size() < 2 * kOrder.size()) {
        return {keys.begin(), keys.end()};
    }
    std::vector<Keyframe> result;
    float time = keys.front().time;
    for (size_t piece : kOrder) {
        const size_t begin = keys.size() * piece / kOrder.size();
        const size_t end = keys.size() * (piece + 1) / kOrder.size();
        const size_t turn = (begin + end) / 2;
        for (size_t i = begin; i < end; ++i) {
            Keyframe key = keys[i];
            key.cut = i == begin || i == turn;
            if (i >= turn) {
                const glm::vec3 ahead = key.camera.target - key.camera.eye;
                key.camera.target = key.camera.eye + glm::cross(ahead, up);
            }
            if (!result.empty()) {
                time += i > begin ? keys[i].time - keys[i - 1].time : keys[1].time - keys[0].time;
            }
            key.time = time;
            result.push_back(key);
        }
    }
    return result;
}

} // namespace occlude::tools
