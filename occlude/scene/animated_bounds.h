// Boxes of animated objects: one per animation, made beforehand, and their union while blending.
//
// Implements  D. Sekulic, "Efficient Occlusion Culling", GPU Gems, 2004, section 29.5.2: the
//             combination of "one box for each animation" with animation in place.
// Use         Beforehand, for each animation: the box of every frame, in the space of the object,
//             and the translation of the object's root in it -> make_animation_bounds. Each
//             frame: blended_bounds of the animations that play -> Scene::move with a matrix that
//             holds the root motion, or Hierarchy::refit with the box.
//             holds the root motion, or Hierarchy::refit with the box.
#pragma once

#include <occlude/core/aabb.h>

#include <glm/vec3.hpp>

#include <span>

namespace occlude {

/// The bounds of one animation.
struct AnimationBounds {
    Aabb in_place; ///< around all its frames, each moved back by its root translation
};

/// An animation that is playing.
struct PlayingAnimation {
    AnimationBounds bounds;
    glm::vec3 root_translation{0.0f}; ///< root translation of the current pose, in the space of the
                                      ///< object
    float weight = 1.0f;              ///< weight in the blend; 0 or less: it does not count
};

/// The box of an animation from the boxes of its frames. `root_translations` has one entry per
/// frame, or is empty for an animation that is made in place already. O(frames).
AnimationBounds make_animation_bounds(std::span<const Aabb> frame_boxes,
                                      std::span<const glm::vec3> root_translations = {});

/// The root translation of the blended pose: the mean by weight. 0 if nothing plays.
glm::vec3 blended_root_translation(std::span<const PlayingAnimation> playing);

/// The box, in the space of the object, of a pose blended from `playing`: the union of their boxes
/// in place, grown by `margin`, moved by the blended root translation. Empty if nothing plays.
/// Certain for poses whose vertices are blended linearly, because a box contains every point
/// between two of its points. Skeletal blends turn joints on arcs, and `margin` must allow for
/// that. If a joint turns by an angle a between two poses, a point at distance L from it leaves the
/// chord by at most L * (1 - cos(a / 2)). The joints of a chain add up.
Aabb blended_bounds(std::span<const PlayingAnimation> playing, float margin = 0.0f);

} // namespace occlude
