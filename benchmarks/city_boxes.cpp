#include "city_boxes.h"

#include <occlude/core/rng.h>

#include <glm/common.hpp>
#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/matrix.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace occlude::bench {

namespace {

constexpr float kPitch = 64.0f;    // from block to block
constexpr float kStreet = 14.0f;   // between the walls on both sides
constexpr float kBuilding = 12.5f; // 4 x 4 buildings fill a block
constexpr size_t kPerBlock = 1000;

size_t blocks_per_side(size_t count)
{
    const auto blocks = static_cast<double>((count + kPerBlock - 1) / kPerBlock);
    return static_cast<size_t>(std::ceil(std::sqrt(blocks)));
}

ItemBounds box_on(const glm::vec3& foot, const glm::vec3& size)
{
    const glm::vec3 half{0.5f * size.x, 0.0f, 0.5f * size.z};
    return {{foot - half, foot + half + glm::vec3{0.0f, size.y, 0.0f}}, 12};
}

// A place on the pavement: a strip 2 wide along one of the four sides of the block.
glm::vec3 on_pavement(Rng& rng, const glm::vec3& corner)
{
    constexpr float kBlock = kPitch - kStreet;
    const float along = rng.range(0.0f, kBlock);
    const float off = rng.range(0.5f, 2.5f);
    switch (rng.below(4)) {
    case 0:
        return corner + glm::vec3{along, 0.0f, -off};
    case 1:
        return corner + glm::vec3{along, 0.0f, kBlock + off};
    case 2:
        return corner + glm::vec3{-off, 0.0f, along};
    default:
        return corner + glm::vec3{kBlock + off, 0.0f, along};
    }
}

// A balcony, sign or window on one of the four walls.
ItemBounds on_wall(Rng& rng, const glm::vec3& foot, float height)
{
    const float along = rng.range(-0.45f, 0.45f) * kBuilding;
    const float out = (rng.below(2) == 0 ? -0.5f : 0.5f) * kBuilding;
    const glm::vec3 up{0.0f, rng.range(0.5f, height - 2.0f), 0.0f};
    const bool along_x = rng.below(2) == 0;
    const glm::vec3 size{rng.range(0.3f, 1.8f), rng.range(0.3f, 1.8f), rng.range(0.1f, 1.0f)};
    return along_x ? box_on(foot + up + glm::vec3{along, 0.0f, out}, size)
                   : box_on(foot + up + glm::vec3{out, 0.0f, along}, {size.z, size.y, size.x});
}

void add_block(std::vector<ItemBounds>& items, Rng& rng, const glm::vec3& corner)
{
    for (int i = 0; i < 16; ++i) {
        const glm::vec3 foot =
            corner + kBuilding * glm::vec3{0.5f + static_cast<float>(i % 4), 0.0f,
                                           0.5f + static_cast<float>(i / 4)};
        const float height = rng.range(12.0f, 60.0f);
        items.push_back(box_on(foot, {kBuilding, height, kBuilding}));
        for (int k = 0; k < 48; ++k) {
            items.push_back(on_wall(rng, foot, height));
        }
        for (int k = 0; k < 4; ++k) {
            const glm::vec3 inside{rng.range(-5.0f, 5.0f), rng.range(0.1f, height - 3.0f),
                                   rng.range(-5.0f, 5.0f)};
            items.push_back(box_on(foot + inside, {rng.range(0.2f, 2.0f), rng.range(0.2f, 2.0f),
                                                   rng.range(0.2f, 2.0f)}));
        }
    }
    for (int k = 0; k < 152; ++k) {
        const glm::vec3 foot = on_pavement(rng, corner);
        items.push_back(
            box_on(foot, {rng.range(0.1f, 0.7f), rng.range(0.2f, 3.0f), rng.range(0.1f, 0.7f)}));
    }
}

struct Ray {
    glm::vec3 from;
    glm::vec3 per_unit; // 1 / direction of the ray
};

// Where the ray enters the box, as a share of its length; 2 where it misses it.
float entry(const Ray& ray, const Aabb& box)
{
    const glm::vec3 a = (box.min - ray.from) * ray.per_unit;
    const glm::vec3 b = (box.max - ray.from) * ray.per_unit;
    const glm::vec3 low = glm::min(a, b);
    const glm::vec3 high = glm::max(a, b);
    const float in = std::max({low.x, low.y, low.z, 0.0f});
    const float out = std::min({high.x, high.y, high.z, 1.0f});
    return in <= out ? in : 2.0f;
}

struct Hit {
    float at = 1.0f; // share of the ray
    uint32_t place = ~0u;
};

Hit nearest_hit(const Hierarchy& hierarchy, const Ray& ray)
{
    Hit best;
    std::vector<std::pair<float, NodeId>> stack{{0.0f, hierarchy.root()}};
    while (!stack.empty()) {
        const auto [at, id] = stack.back();
        stack.pop_back();
        if (at >= best.at) {
            continue;
        }
        const Node& node = hierarchy.node(id);
        for (uint32_t i = node.first_item; i < node.first_item + node.own_items; ++i) {
            const float here = entry(ray, hierarchy.item_bounds()[i].box);
            if (here < best.at) {
                best = {here, i};
            }
        }
        const size_t first = stack.size();
        for (uint32_t c = 0; c < node.child_count; ++c) {
            const NodeId child{node.first_child.value + c};
            stack.emplace_back(entry(ray, hierarchy.node(child).box), child);
        }
        std::sort(stack.begin() + static_cast<std::ptrdiff_t>(first), stack.end(),
                  [](const auto& a, const auto& b) { return a.first > b.first; });
    }
    return best;
}

} // namespace

std::vector<ItemBounds> city_boxes(size_t count)
{
    Rng rng(7);
    const size_t side = blocks_per_side(count);
    std::vector<ItemBounds> items;
    items.reserve(side * side * kPerBlock);
    for (size_t block = 0; items.size() < count; ++block) {
        const glm::vec3 corner{kPitch * static_cast<float>(block % side), 0.0f,
                               kPitch * static_cast<float>(block / side)};
        add_block(items, rng, corner);
    }
    items.resize(count);
    return items;
}

View street_view(size_t count, size_t frame, size_t frames, glm::ivec2 size_px)
{
    const auto half = static_cast<float>(blocks_per_side(count) / 2);
    const float ahead = 16.0f * static_cast<float>(frame) / static_cast<float>(frames);
    const glm::vec3 eye{kPitch * half - 0.5f * kStreet, 6.0f, kPitch * half + 10.0f - ahead};
    const glm::mat4 clip_from_eye = glm::perspectiveRH_NO(
        glm::radians(60.0f), static_cast<float>(size_px.x) / static_cast<float>(size_px.y), 0.5f,
        20000.0f);
    const glm::mat4 eye_from_world =
        glm::lookAtRH(eye, eye + glm::vec3{0.7f, 0.0f, -1.0f}, glm::vec3{0.0f, 1.0f, 0.0f});
    return View::from_clip(clip_from_eye * eye_from_world, size_px);
}

Truth look_through_pixels(const Hierarchy& hierarchy, const View& view)
{
    const glm::ivec2 size = view.size_px();
    const glm::dmat4 world_from_clip = glm::inverse(glm::dmat4{view.clip_from_world()});
    const auto world_at = [&](double x, double y, double z) {
        const glm::dvec4 p = world_from_clip * glm::dvec4{x, y, z, 1.0};
        return glm::dvec3{p} / p.w;
    };
    const size_t pixels = static_cast<size_t>(size.x) * static_cast<size_t>(size.y);
    Truth truth;
    truth.depth.assign(pixels, 1.0f);
    std::vector<uint32_t> seen(pixels, ~0u);
    tbb::parallel_for(size_t{0}, pixels, [&](size_t pixel) {
        const size_t width = static_cast<size_t>(size.x);
        const double x = 2.0 * (static_cast<double>(pixel % width) + 0.5) / size.x - 1.0;
        const double y = 2.0 * (static_cast<double>(pixel / width) + 0.5) / size.y - 1.0;
        const glm::vec3 from{world_at(x, y, -1.0)};
        const glm::vec3 along = glm::vec3{world_at(x, y, 1.0)} - from;
        const Hit hit = nearest_hit(hierarchy, {from, 1.0f / along});
        if (hit.place != ~0u) {
            const glm::vec4 clip = view.clip_from_world() * glm::vec4{from + hit.at * along, 1.0f};
            truth.depth[pixel] = 0.5f * clip.z / clip.w + 0.5f;
            seen[pixel] = hit.place;
        }
    });
    std::sort(seen.begin(), seen.end());
    seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
    if (!seen.empty() && seen.back() == ~0u) {
        seen.pop_back();
    }
    truth.visible = std::move(seen);
    return truth;
}

} // namespace occlude::bench
