// The boxes and triangles of a random world, and how they move.
#pragma once

#include "worlds/spec.h"

#include <occlude/backends/cpu/cpu_scene.h>
#include <occlude/core/rng.h>
#include <occlude/hierarchy/hierarchy.h>

#include <span>
#include <vector>

namespace occlude::worlds {

/// Rooms, walls, plates, needles, specks, copies, boxes in boxes and faces in one plane, around a
/// centre, in a cube of half width kReach units.
class RandomScene final : public CpuScene {
public:
    static constexpr float kReach = 10.0f;

    explicit RandomScene(const Spec& spec);

    std::span<const ItemBounds> bounds() const { return bounds_; }
    const glm::vec3& center() const { return center_; }
    float unit() const { return spec_.unit; }
    CpuItem item(ItemId item) const override;

    /// The triangles of an item in the world, three positions each.
    std::vector<glm::vec3> triangles(ItemId item) const;

    /// Moves some items, removes some and replaces them by others. Returns the changed ones.
    std::vector<ItemId> move(Rng& rng);

private:
    void put(size_t item, Rng& rng);
    void fill(size_t item, const Aabb& box, Rng& rng);
    Aabb random_box(size_t item, Rng& rng) const;
    glm::vec3 point(Rng& rng, float reach) const;

    Spec spec_;
    glm::vec3 center_{0.0f};
    std::vector<ItemBounds> bounds_;
    std::vector<std::vector<glm::vec3>> positions_;
};

} // namespace occlude::worlds
