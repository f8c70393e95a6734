#include <occlude/scene/animated_bounds.h>

#include <occlude/core/assert.h>

namespace occlude {

// The box moved by `offset`; empty and unbounded boxes stay unchanged.
static Aabb moved(const Aabb& box, const glm::vec3& offset)
{
    return box.is_bounded() ? Aabb{box.min + offset, box.max + offset} : box;
}

// A weight that is not a number counts, because a box that is too large hides nothing.
static bool counts(const PlayingAnimation& animation)
{
    OCCLUDE_ASSERT(animation.weight == animation.weight, "the weight of an animation is a number");
    return !(animation.weight <= 0.0f);
}

AnimationBounds make_animation_bounds(std::span<const Aabb> frame_boxes,
                                      std::span<const glm::vec3> root_translations)
{
    OCCLUDE_ASSERT(root_translations.empty() || root_translations.size() == frame_boxes.size(),
                   "one root translation per frame, or none");
    AnimationBounds bounds;
    for (size_t i = 0; i < frame_boxes.size(); ++i) {
        const glm::vec3 root =
            i < root_translations.size() ? root_translations[i] : glm::vec3{0.0f};
        bounds.in_place = merge(bounds.in_place, moved(frame_boxes[i], -root));
    }
    return bounds;
}

glm::vec3 blended_root_translation(std::span<const PlayingAnimation> playing)
{
    glm::vec3 sum{0.0f};
    float weights = 0.0f;
    for (const PlayingAnimation& animation : playing) {
        if (counts(animation)) {
            sum += animation.weight * animation.root_translation;
            weights += animation.weight;
        }
    }
    return weights == 0.0f ? glm::vec3{0.0f} : sum / weights;
}

Aabb blended_bounds(std::span<const PlayingAnimation> playing, float margin)
{
    Aabb box;
    for (const PlayingAnimation& animation : playing) {
        if (counts(animation)) {
            box = merge(box, animation.bounds.in_place);
        }
    }
    return moved(inflated(box, margin), blended_root_translation(playing));
}

} // namespace occlude
