// Cameras of every kind that the library supports, for the tests of core/.
#pragma once

#include <occlude/core/frustum.h>
#include <occlude/core/rng.h>

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

namespace occlude::test {

inline constexpr ClipConvention kOpenGl{DepthRange::minus_one_to_one, DepthOrder::near_is_small};
inline constexpr ClipConvention kVulkan{DepthRange::zero_to_one, DepthOrder::near_is_small};
inline constexpr ClipConvention kReversed{DepthRange::zero_to_one, DepthOrder::near_is_large};
inline constexpr ClipConvention kReversedGl{DepthRange::minus_one_to_one,
                                            DepthOrder::near_is_large};

struct Projection {
    const char* name;
    glm::mat4 clip_from_eye;
    ClipConvention convention;
    bool orthographic = false;
};

/// The projection with nearer and farther exchanged: z becomes w - z, or -z.
inline glm::mat4 reversed(const glm::mat4& clip_from_eye, DepthRange range)
{
    glm::mat4 result = clip_from_eye;
    for (int c = 0; c < 4; ++c) {
        const float z = clip_from_eye[c][2];
        result[c][2] = range == DepthRange::zero_to_one ? clip_from_eye[c][3] - z : -z;
    }
    return result;
}

/// The projection with its near plane ([0,1] depth: the row of z) replaced by `plane` in eye space,
/// scaled so that the far corners stay within the depth range.
inline glm::mat4 oblique(const glm::mat4& clip_from_eye, const glm::vec4& plane)
{
    const glm::vec4 far_corner =
        glm::inverse(clip_from_eye) *
        glm::vec4{plane.x > 0.0f ? 1.0f : -1.0f, plane.y > 0.0f ? 1.0f : -1.0f, 1.0f, 1.0f};
    const glm::vec4 row = plane / glm::dot(plane, far_corner);
    glm::mat4 result = clip_from_eye;
    for (int c = 0; c < 4; ++c) {
        result[c][2] = row[c];
    }
    return result;
}

/// Near 0.1 and far 100 where they apply. The oblique one keeps points with z < -0.5 + 0.3 x.
inline std::vector<Projection> all_projections()
{
    const float fov = glm::radians(70.0f);
    const glm::mat4 gl = glm::perspectiveRH_NO(fov, 1.5f, 0.1f, 100.0f);
    const glm::mat4 vk = glm::perspectiveRH_ZO(fov, 1.5f, 0.1f, 100.0f);
    const glm::mat4 ortho_gl = glm::orthoRH_NO(-30.0f, 20.0f, -10.0f, 15.0f, 0.1f, 100.0f);
    const glm::mat4 ortho_vk = glm::orthoRH_ZO(-30.0f, 20.0f, -10.0f, 15.0f, 0.1f, 100.0f);
    const glm::mat4 infinite_gl = glm::infinitePerspectiveRH(fov, 1.5f, 0.1f);
    glm::mat4 infinite_vk = infinite_gl; // z = -z_eye - near, w = -z_eye
    infinite_vk[2][2] = -1.0f;
    infinite_vk[3][2] = -0.1f;
    constexpr auto zero_to_one = DepthRange::zero_to_one;
    constexpr auto minus_one_to_one = DepthRange::minus_one_to_one;
    return {
        {"perspective [-1,1]", gl, kOpenGl},
        {"perspective [0,1]", vk, kVulkan},
        {"perspective, left-handed", glm::perspectiveLH_ZO(fov, 1.5f, 0.1f, 100.0f), kVulkan},
        {"perspective, reversed [0,1]", reversed(vk, zero_to_one), kReversed},
        {"perspective, reversed [-1,1]", reversed(gl, minus_one_to_one), kReversedGl},
        {"infinite [-1,1]", infinite_gl, kOpenGl},
        {"infinite [0,1]", infinite_vk, kVulkan},
        {"infinite, reversed [0,1]", reversed(infinite_vk, zero_to_one), kReversed},
        {"off-centre", glm::frustumRH_NO(-0.02f, 0.15f, -0.1f, 0.03f, 0.1f, 100.0f), kOpenGl},
        {"oblique", oblique(vk, {0.3f, 0.0f, -1.0f, -0.5f}), kVulkan},
        {"orthographic [-1,1]", ortho_gl, kOpenGl, true},
        {"orthographic [0,1]", ortho_vk, kVulkan, true},
        {"orthographic, reversed", reversed(ortho_vk, zero_to_one), kReversed, true},
    };
}

/// A rigid map that looks from a random place in a random direction.
inline glm::mat4 random_eye_from_world(Rng& rng, float extent)
{
    const glm::vec3 eye{rng.range(-extent, extent), rng.range(-extent, extent),
                        rng.range(-extent, extent)};
    const glm::vec3 toward{rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1)};
    return glm::lookAt(eye, eye + extent * glm::normalize(toward), {0.1f, 0.2f, 0.95f});
}

inline Aabb random_box(Rng& rng, float extent, float largest)
{
    const glm::vec3 low{rng.range(-extent, extent), rng.range(-extent, extent),
                        rng.range(-extent, extent)};
    // Cubed: most boxes are small, some are large.
    const float size = largest * std::pow(rng.range(0.02f, 1.0f), 3.0f);
    return {low, low + glm::vec3{rng.range(0, size), rng.range(0, size), rng.range(0, size)}};
}

inline glm::vec3 corner(const Aabb& box, int i)
{
    return {(i & 1) != 0 ? box.max.x : box.min.x, (i & 2) != 0 ? box.max.y : box.min.y,
            (i & 4) != 0 ? box.max.z : box.min.z};
}

/// How far `clip` is inside the near and far planes, in clip units: negative outside.
inline double clip_depth_margin(const glm::dvec4& clip, ClipConvention convention)
{
    const double low = convention.range == DepthRange::zero_to_one ? clip.z : clip.w + clip.z;
    return std::min(low, clip.w - clip.z);
}

/// How far `clip` is inside the clip volume, in clip units: negative outside.
inline double clip_margin(const glm::dvec4& clip, ClipConvention convention)
{
    return std::min({clip.w - std::abs(clip.x), clip.w - std::abs(clip.y),
                     clip_depth_margin(clip, convention)});
}

} // namespace occlude::test
