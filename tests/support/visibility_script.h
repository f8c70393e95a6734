// A made-up truth of visible items, as answers for a ScriptedDevice. It is consistent over inner
// nodes, leaves and groups, in every order of tests.
#pragma once

#include <occlude/core/rng.h>
#include <occlude/device/scripted_device.h>
#include <occlude/hierarchy/hierarchy.h>

#include <glm/vector_relational.hpp>

#include <vector>

namespace occlude::test {

/// Item i is visible in frame f with probability `share`. It keeps its state for about ten frames.
inline bool item_visible(uint64_t seed, uint64_t frame, ItemId item, float share)
{
    const uint64_t phase = hash64(seed, item.value) % 10;
    return uniform01(hash64(seed, item.value, (frame + phase) / 10)) < share;
}

inline bool overlap(const Aabb& a, const Aabb& b)
{
    return glm::all(glm::lessThanEqual(a.min, b.max)) && glm::all(glm::lessThanEqual(b.min, a.max));
}

/// Answers as if exactly the items chosen by item_visible() were visible, with 10 samples each.
/// `frame` is read when a test is issued, so that the test may advance it.
inline BoxScript consistent_visibility(const Hierarchy& hierarchy, uint64_t seed,
                                       const uint64_t& frame, float share)
{
    return [&hierarchy, seed, &frame, share](std::span<const QueryBox> boxes) {
        uint64_t samples = 0;
        for (const QueryBox& box : boxes) {
            if (!box.subject.valid()) { // not a node: any part of space
                for (size_t i = 0; i < hierarchy.items().size(); ++i) {
                    if (item_visible(seed, frame, hierarchy.items()[i], share) &&
                        overlap(box.box, hierarchy.item_bounds()[i].box)) {
                        samples += 10;
                    }
                }
                continue;
            }
            for (const ItemId item : hierarchy.subtree_items(box.subject)) {
                samples += item_visible(seed, frame, item, share) ? 10 : 0;
            }
        }
        return samples;
    };
}

} // namespace occlude::test
