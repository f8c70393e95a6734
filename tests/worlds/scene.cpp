#include "worlds/scene.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>

namespace occlude::worlds {

namespace {

// Two triangles for each face of a box whose corners are numbered by the bits of x, y and z.
constexpr std::array<uint32_t, 36> kFaces{0, 1, 2, 2, 1, 3, 4, 6, 5, 5, 6, 7, 0, 4, 1, 1, 4, 5,
                                          2, 3, 6, 6, 3, 7, 0, 2, 4, 4, 2, 6, 1, 5, 3, 3, 5, 7};

glm::vec3 corner(const Aabb& box, size_t index)
{
    return {(index & 1) != 0 ? box.max.x : box.min.x, (index & 2) != 0 ? box.max.y : box.min.y,
            (index & 4) != 0 ? box.max.z : box.min.z};
}

ItemFlags random_flags(Rng& rng)
{
    constexpr std::array kFlags{
        ItemFlags::translucent, ItemFlags::never_occlude, ItemFlags::never_cull,
        ItemFlags::never_cull | ItemFlags::translucent, ItemFlags::alpha_tested};
    return rng.below(6) == 0 ? kFlags[rng.below(kFlags.size())] : ItemFlags::none;
}

} // namespace

RandomScene::RandomScene(const Spec& spec)
    : spec_(spec)
{
    Rng rng{hash64(spec.seed, 0x5ce9e)};
    const float distance = spec.offset * kReach * spec.unit;
    center_ = distance * glm::normalize(glm::vec3{rng.range(-1.0f, 1.0f), rng.range(-1.0f, 1.0f),
                                                  rng.range(0.1f, 1.0f)});
    bounds_.resize(spec.items);
    positions_.resize(spec.items);
    for (size_t i = 0; i < spec.items; ++i) {
        put(i, rng);
    }
}

glm::vec3 RandomScene::point(Rng& rng, float reach) const
{
    const float x = rng.range(-reach, reach);
    const float y = rng.range(-reach, reach);
    const float z = rng.range(-reach, reach);
    return center_ + spec_.unit * glm::vec3{x, y, z};
}

Aabb RandomScene::random_box(size_t item, Rng& rng) const
{
    const glm::vec3 at = point(rng, kReach);
    const int axis = static_cast<int>(rng.below(3));
    glm::vec3 half =
        spec_.unit * glm::vec3{rng.range(0.2f, 2.0f), rng.range(0.2f, 2.0f), rng.range(0.2f, 2.0f)};
    switch (rng.below(10)) {
    case 0:
    case 1: // a wall
        half = spec_.unit * glm::vec3{rng.range(3.0f, 9.0f)};
        half[axis] = spec_.unit * rng.range(0.0f, 0.3f);
        break;
    case 2: // of no thickness
        half[axis] = 0.0f;
        break;
    case 3: // a needle
        half *= 0.01f;
        half[axis] *= 300.0f;
        break;
    case 4: // smaller than a pixel
        half *= 0.002f;
        break;
    case 5: // a copy, at the same place
    case 6: // a box in another
    case 7: // a face in the plane of another's
        if (item > 0) {
            const Aabb& other = bounds_[rng.below(static_cast<uint32_t>(item))].box;
            const uint32_t kind = rng.below(3);
            if (other.is_empty() || kind == 0) {
                return other;
            }
            if (kind == 1) {
                const glm::vec3 inset = rng.range(0.0f, 0.4f) * other.extent();
                return {other.min + inset, other.max - inset};
            }
            Aabb beside{at - half, at + half};
            beside.min[axis] = other.max[axis];
            beside.max[axis] = std::max(beside.max[axis], other.max[axis]);
            return beside;
        }
        break;
    default:
        break;
    }
    return {at - half, at + half};
}

void RandomScene::fill(size_t item, const Aabb& box, Rng& rng)
{
    auto& positions = positions_[item];
    positions.clear();
    if (box.is_empty()) {
        bounds_[item].box = Aabb{};
        return;
    }
    // The box itself, a tent in it, or some slanted triangles in it.
    const uint32_t kind = rng.below(4);
    for (size_t i = 0; i < 8; ++i) {
        glm::vec3 p = corner(box, i);
        if (kind == 0 && (i & 2) != 0) {
            p = {box.center().x, p.y, box.center().z};
        } else if (kind == 1 && rng.below(3) == 0) {
            p = glm::mix(
                box.min, box.max,
                glm::vec3{rng.range(0.0f, 1.0f), rng.range(0.0f, 1.0f), rng.range(0.0f, 1.0f)});
            p = glm::clamp(p, box.min, box.max);
        }
        positions.push_back(p);
    }
    bounds_[item].box = box;
    bounds_[item].triangles = kFaces.size() / 3;
}

void RandomScene::put(size_t item, Rng& rng)
{
    fill(item, random_box(item, rng), rng);
    bounds_[item].triangles = kFaces.size() / 3 * (1 + rng.below(4));
    bounds_[item].flags = spec_.flags ? random_flags(rng) : ItemFlags::none;
}

CpuItem RandomScene::item(ItemId item) const
{
    if (positions_[item.value].empty()) {
        return {};
    }
    return {.positions = positions_[item.value],
            .indices = kFaces,
            .translucent = has_flag(bounds_[item.value].flags, ItemFlags::translucent)};
}

std::vector<glm::vec3> RandomScene::triangles(ItemId item) const
{
    std::vector<glm::vec3> corners;
    if (!positions_[item.value].empty()) {
        for (const uint32_t index : kFaces) {
            corners.push_back(positions_[item.value][index]);
        }
    }
    return corners;
}

std::vector<ItemId> RandomScene::move(Rng& rng)
{
    std::vector<ItemId> moved;
    for (size_t i = 0; i < bounds_.size(); ++i) {
        if (rng.below(4) != 0) {
            continue;
        }
        moved.push_back(ItemId{i});
        const uint32_t kind = rng.below(8);
        if (kind == 0) { // the item is gone
            fill(i, Aabb{}, rng);
        } else if (kind == 1 || bounds_[i].box.is_empty()) { // another item has its number
            put(i, rng);
        } else {
            const glm::vec3 step = point(rng, 1.0f) - center_;
            fill(i, {bounds_[i].box.min + step, bounds_[i].box.max + step}, rng);
        }
    }
    return moved;
}

} // namespace occlude::worlds
