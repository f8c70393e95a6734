// Random worlds of boxes, and cameras of every kind in them, to compare culled images with full
// images: on both devices, at every distance from the origin and in every unit.
#pragma once

#include "screen/projections.h"

#include <occlude/core/rng.h>
#include <occlude/core/view.h>
#include <occlude/hierarchy/hierarchy.h>

#include <glm/geometric.hpp>

#include <cstdlib>
#include <string>
#include <vector>

namespace occlude::test {

/// Factor on the random cases of `./dev test`: OCCLUDE_SOAK, or 1 if it is not set.
inline uint64_t soak_factor()
{
    const char* text = std::getenv("OCCLUDE_SOAK");
    const long factor = text != nullptr ? std::strtol(text, nullptr, 10) : 1;
    return factor > 1 ? static_cast<uint64_t>(factor) : 1;
}

/// A camera without a projection: its position and orientation, in double.
struct Pose {
    glm::dvec3 eye{0.0};
    glm::dvec3 forward{0.0, 0.0, -1.0};
    glm::dvec3 up{0.0, 1.0, 0.0};
    bool left_handed = false; ///< eye space has its z axis forward

    /// From (position - eye) to eye space.
    glm::dmat4 eye_from_relative() const
    {
        const glm::dvec3 ahead = glm::normalize(forward);
        const glm::dvec3 right = glm::normalize(glm::cross(ahead, up));
        return glm::transpose(
            glm::dmat4{glm::dmat3{right, glm::cross(right, ahead), left_handed ? ahead : -ahead}});
    }
};

/// The projection in a world whose unit is `unit` times as long: near and far are, too.
inline glm::dmat4 in_units(const glm::mat4& clip_from_eye, double unit)
{
    const glm::dvec3 shrink{1.0 / unit};
    return unit * glm::dmat4{clip_from_eye} *
           glm::dmat4{{shrink.x, 0, 0, 0}, {0, shrink.y, 0, 0}, {0, 0, shrink.z, 0}, {0, 0, 0, 1}};
}

/// How the engine passes its camera to the library.
enum class Drawing : uint8_t {
    relative, ///< View::camera_relative: positions are taken relative to the eye first
    absolute, ///< View::from_clip: world positions in float
};

inline View view_of(const Projection& projection, const Pose& pose, glm::ivec2 size,
                    double unit = 1, Drawing drawing = Drawing::relative,
                    const ViewOptions& options = {})
{
    const glm::dmat4 relative = in_units(projection.clip_from_eye, unit) * pose.eye_from_relative();
    if (drawing == Drawing::relative) {
        return View::camera_relative(glm::mat4{relative}, pose.eye, size, projection.convention,
                                     options);
    }
    glm::dmat4 absolute = relative;
    absolute[3] = relative * glm::dvec4{-pose.eye, 1.0};
    return View::from_clip(glm::mat4{absolute}, size, projection.convention, options);
}

/// Near planes that lean by up to 85 degrees, 1/8 to 3 units before the eye, as for mirrors,
/// portals and water. The far corner of the screen stays at the far end.
inline Projection random_oblique(Rng& rng)
{
    const bool reversed_depth = rng.below(2) == 1;
    const float fov = rng.range(0.6f, 1.6f);
    const float turn = rng.range(0.0f, 6.28318f);
    const float lean = rng.range(0.0f, 1.48f);
    const glm::vec3 normal{std::sin(lean) * std::cos(turn), std::sin(lean) * std::sin(turn),
                           -std::cos(lean)};
    const float distance = 0.125f * std::pow(24.0f, rng.range(0.0f, 1.0f));
    const glm::mat4 clip =
        oblique(glm::perspectiveRH_ZO(fov, rng.range(0.7f, 1.8f), 0.1f, rng.range(60.0f, 400.0f)),
                {normal, -distance});
    if (reversed_depth) {
        return {"oblique, reversed", reversed(clip, DepthRange::zero_to_one), kReversed};
    }
    return {"oblique", clip, kVulkan};
}

/// all_projections() and special ones: tiny and huge near planes, a mirrored camera, a narrow one,
/// a very wide one, an oblique one of each depth order.
inline std::vector<Projection> projections_for_images()
{
    std::vector<Projection> all = all_projections();
    const float fov = glm::radians(70.0f);
    all.push_back({"tiny near", glm::perspectiveRH_NO(fov, 1.5f, 1e-4f, 100.0f), kOpenGl});
    all.push_back({"huge near", glm::perspectiveRH_ZO(fov, 1.5f, 8.0f, 100.0f), kVulkan});
    glm::mat4 mirrored = glm::perspectiveRH_NO(fov, 1.5f, 0.1f, 100.0f);
    mirrored[0][0] = -mirrored[0][0];
    all.push_back({"mirrored", mirrored, kOpenGl});
    all.push_back({"y down",
                   glm::scale(glm::mat4{1.0f}, {1.0f, -1.0f, 1.0f}) *
                       glm::perspectiveRH_ZO(fov, 1.5f, 0.1f, 100.0f),
                   kVulkan});
    all.push_back({"narrow", glm::perspectiveRH_ZO(0.2f, 1.0f, 0.1f, 100.0f), kVulkan});
    all.push_back({"wide", glm::perspectiveRH_NO(2.6f, 1.8f, 0.05f, 100.0f), kOpenGl});
    Rng rng(77);
    for (int i = 0; i < 4; ++i) {
        all.push_back(random_oblique(rng));
    }
    return all;
}

inline bool is_left_handed(const Projection& projection)
{
    return std::string_view{projection.name}.ends_with("left-handed");
}

/// Boxes within 40 units of the origin, in double: a few walls and rooms, and many small boxes.
/// Some are flat, thin as needles, doubled, or touch each other.
struct DoubleBox {
    glm::dvec3 min, max;
};

/// `apart`: no two faces coincide on purpose, for images that would depend on the order of draws.
inline std::vector<DoubleBox> random_world(Rng& rng, size_t count, bool apart = false)
{
    std::vector<DoubleBox> boxes;
    const auto place = [&](float reach) {
        return glm::dvec3{rng.range(-reach, reach), rng.range(-reach, reach),
                          rng.range(-reach, reach)};
    };
    while (boxes.size() < count) {
        const uint32_t kind = rng.below(20);
        glm::dvec3 half{rng.range(0.1f, 1.5f), rng.range(0.1f, 1.5f), rng.range(0.1f, 1.5f)};
        if (kind < 2 || kind >= 14) { // a wall
            half = {rng.range(4.0f, 14.0f), rng.range(4.0f, 14.0f), rng.range(4.0f, 14.0f)};
            half[static_cast<int>(rng.below(3))] = rng.range(0.0f, 0.4f);
        } else if (kind == 2) {
            half[static_cast<int>(rng.below(3))] = 0.0;
        } else if (kind == 3) { // a needle
            half = {0.02, 0.02, 0.02};
            half[static_cast<int>(rng.below(3))] = rng.range(1.0f, 8.0f);
        } else if (kind == 4 && !apart && !boxes.empty()) {
            boxes.push_back(boxes[rng.below(static_cast<uint32_t>(boxes.size()))]);
            continue;
        }
        glm::dvec3 center = place(30.0f);
        if (kind == 5 && !apart && !boxes.empty()) { // stands on another
            const DoubleBox& below = boxes[rng.below(static_cast<uint32_t>(boxes.size()))];
            center.y = below.max.y + half.y;
            center.x = below.min.x + half.x;
        }
        boxes.push_back({center - half, center + half});
    }
    return boxes;
}

/// The boxes after scaling by `unit` and moving by `offset`, rounded to float: the geometry itself
/// is rounded, so that its bounds are exact.
inline std::vector<ItemBounds> placed(std::span<const DoubleBox> boxes, double unit,
                                      const glm::dvec3& offset)
{
    std::vector<ItemBounds> items;
    for (const DoubleBox& box : boxes) {
        ItemBounds item;
        item.box = {glm::vec3{unit * box.min + offset}, glm::vec3{unit * box.max + offset}};
        item.triangles = 12;
        items.push_back(item);
    }
    return items;
}

/// A camera among or beside the boxes, looking across them.
inline Pose random_pose(Rng& rng, double unit = 1.0, const glm::dvec3& offset = glm::dvec3{0.0})
{
    const auto within = [&](float reach) {
        return glm::dvec3{rng.range(-reach, reach), rng.range(-reach, reach),
                          rng.range(-reach, reach)};
    };
    Pose pose;
    const glm::dvec3 eye = within(36.0f);
    pose.forward = glm::normalize(within(12.0f) - eye);
    pose.eye = unit * eye + offset;
    pose.up = glm::normalize(glm::dvec3{0.1, 1.0, 0.05});
    return pose;
}

} // namespace occlude::test
