#include "generate/city_buildings.h"

#include "generate/city_house.h"

#include <occlude/core/rng.h>

#include <algorithm>

namespace occlude::tools {

House::House(const HousePlan& plan, size_t budget)
    : plan_(plan)
    , budget_(budget)
    , height_(house_height(plan))
{
    plan_walls();
    for (uint32_t i = 0; i < walls_.size(); ++i) {
        if (walls_[i].has_windows) {
            plan_openings(walls_[i], i);
        }
    }
    std::stable_sort(openings_.begin(), openings_.end(),
                     [](const Opening& a, const Opening& b) { return a.floor < b.floor; });
}

void House::plan_walls()
{
    const float half = 0.5f * plan_.width;
    const glm::vec3 up{0.0f, 1.0f, 0.0f};
    const glm::vec3 x{1.0f, 0.0f, 0.0f};
    const glm::vec3 z{0.0f, 0.0f, 1.0f};
    const auto add = [&](uint32_t side, const SurfaceFrame& frame, float length) {
        const bool on_street = (plan_.street_sides & side) != 0;
        walls_.push_back({frame, length, on_street || (plan_.yard_sides & side) != 0, on_street});
    };
    add(HousePlan::kFront, {{-half, 0.0f, 0.0f}, x, up, z}, plan_.width);
    add(HousePlan::kRight, {{half, 0.0f, 0.0f}, -z, up, x}, plan_.depth);
    add(HousePlan::kBack, {{half, 0.0f, -plan_.depth}, -x, up, -z}, plan_.width);
    add(HousePlan::kLeft, {{-half, 0.0f, -plan_.depth}, z, up, -x}, plan_.depth);
}

void House::plan_openings(const Wall& wall, uint32_t wall_number)
{
    const auto bays = std::max(1u, static_cast<uint32_t>(wall.length / kHouseBay));
    const float bay = wall.length / static_cast<float>(bays);
    const uint32_t door_bay = uniform_below(hash64(plan_.seed, wall_number, 1), bays);
    const uint32_t balcony_phase = uniform_below(hash64(plan_.seed, wall_number, 2), 3);
    const bool has_shop = uniform_below(hash64(plan_.seed, 3), 2) == 0;
    for (uint32_t floor = 0; floor < plan_.floors; ++floor) {
        const float foot =
            floor == 0 ? 0.0f : kGroundFloor + kHouseFloor * static_cast<float>(floor - 1);
        const float head = floor == 0 ? kGroundFloor : foot + kHouseFloor;
        for (uint32_t i = 0; i < bays; ++i) {
            Opening opening;
            opening.frame = wall.frame;
            opening.bay_u = {bay * static_cast<float>(i), bay * static_cast<float>(i + 1)};
            opening.bay_v = {floor == 0 ? -kFoundation : foot, head};
            opening.floor = floor;
            opening.on_street = wall.on_street;
            opening.is_door = wall.on_street && floor == 0 && i == door_bay;
            opening.has_balcony = wall.on_street && floor > 0 && i % 3 == balcony_phase && bays > 2;
            opening.hash = hash64(plan_.seed, wall_number, floor, i);
            const float middle = bay * (static_cast<float>(i) + 0.5f);
            float half_width = 0.6f;
            float sill = foot + 0.9f;
            float lintel = foot + 2.6f;
            if (opening.is_door) {
                half_width = 0.65f;
                sill = 0.35f; // two steps up
                lintel = 2.9f;
            } else if (floor == 0 && has_shop && wall.on_street) {
                half_width = 0.4f * bay;
                sill = 0.6f;
                lintel = 3.1f;
            } else if (opening.has_balcony) {
                sill = foot + 0.1f;
            }
            opening.low = {middle - half_width, sill};
            opening.high = {middle + half_width, lintel};
            openings_.push_back(opening);
        }
    }
}

bool House::relief(const SurfaceFrame& frame, const glm::vec3& low, const glm::vec3& high)
{
    if (!can_pay(10)) {
        return false;
    }
    frame.relief(builder_, low, high);
    return true;
}

/// Blank walls, roof and everything that must be there whatever the budget.
void House::add_shell()
{
    for (const Wall& wall : walls_) {
        if (!wall.has_windows) {
            wall.frame.panel(builder_, {0.0f, -kFoundation}, {wall.length, height_}, 0.0f);
        }
    }
    if (plan_.pitched_roof) {
        add_pitched_roof();
    } else {
        const float half = 0.5f * plan_.width;
        builder_.quad({-half, height_, 0.0f}, {half, height_, 0.0f}, {half, height_, -plan_.depth},
                      {-half, height_, -plan_.depth});
    }
    if (plan_.wing > 0.0f) {
        add_wing();
    }
}

/// The two slopes rise 3 on 4, so that their frames are exact.
void House::add_pitched_roof()
{
    const float half = 0.5f * plan_.width;
    const float middle = -0.5f * plan_.depth;
    const float ridge = height_ + 0.375f * plan_.depth;
    builder_.quad({-half, height_, 0.0f}, {half, height_, 0.0f}, {half, ridge, middle},
                  {-half, ridge, middle});
    builder_.quad({half, height_, -plan_.depth}, {-half, height_, -plan_.depth},
                  {-half, ridge, middle}, {half, ridge, middle});
    builder_.triangle({half, height_, 0.0f}, {half, height_, -plan_.depth}, {half, ridge, middle});
    builder_.triangle({-half, height_, -plan_.depth}, {-half, height_, 0.0f},
                      {-half, ridge, middle});
}

void House::add_wing()
{
    constexpr float kWingDepth = 6.0f;
    const float left = 0.5f * plan_.width - plan_.wing - 0.5f;
    const float top = height_ - kHouseFloor;
    builder_.box({left, -kFoundation, -plan_.depth - kWingDepth},
                 {left + plan_.wing, top, -plan_.depth + 0.1f},
                 MeshBuilder::kAllFaces & ~(MeshBuilder::kNegY | MeshBuilder::kPosZ));
}

/// Walls with real openings where the budget allows, flat ones with panes before them where not.
void House::add_walls()
{
    constexpr size_t kOpening = 18;
    has_reveals_ = can_pay((kOpening + 10) * openings_.size());
    if (!has_reveals_) {
        for (const Wall& wall : walls_) {
            if (wall.has_windows) {
                wall.frame.panel(builder_, {0.0f, -kFoundation}, {wall.length, height_}, 0.0f);
            }
        }
        for (const Opening& opening : openings_) {
            if (can_pay(2)) {
                opening.frame.panel(builder_, opening.low, opening.high, 0.03f);
            }
        }
        return;
    }
    for (const Opening& o : openings_) {
        const SurfaceFrame& f = o.frame;
        f.panel(builder_, {o.bay_u.x, o.bay_v.x}, {o.low.x, o.bay_v.y}, 0.0f);
        f.panel(builder_, {o.high.x, o.bay_v.x}, {o.bay_u.y, o.bay_v.y}, 0.0f);
        f.panel(builder_, {o.low.x, o.bay_v.x}, {o.high.x, o.low.y}, 0.0f);
        f.panel(builder_, {o.low.x, o.high.y}, {o.high.x, o.bay_v.y}, 0.0f);
        f.panel(builder_, o.low, o.high, -kReveal);
        const auto at = [&](float u, float v, float w) { return f.at(u, v, w); };
        const glm::vec2 a = o.low;
        const glm::vec2 b = o.high;
        builder_.quad(at(a.x, a.y, 0.0f), at(b.x, a.y, 0.0f), at(b.x, a.y, -kReveal),
                      at(a.x, a.y, -kReveal));
        builder_.quad(at(a.x, b.y, -kReveal), at(b.x, b.y, -kReveal), at(b.x, b.y, 0.0f),
                      at(a.x, b.y, 0.0f));
        builder_.quad(at(a.x, a.y, 0.0f), at(a.x, a.y, -kReveal), at(a.x, b.y, -kReveal),
                      at(a.x, b.y, 0.0f));
        builder_.quad(at(b.x, a.y, -kReveal), at(b.x, a.y, 0.0f), at(b.x, b.y, 0.0f),
                      at(b.x, b.y, -kReveal));
    }
}

void House::add_parapets()
{
    constexpr float kThick = 0.3f;
    if (plan_.pitched_roof) {
        return;
    }
    for (const Wall& wall : walls_) {
        // Sideways a little short, so that the ends of two walls do not lie in one plane.
        relief(wall.frame, {0.01f, height_, -kThick},
               {wall.length - 0.01f, height_ + kParapet, 0.0f});
        if (can_pay(2)) {
            const SurfaceFrame& f = wall.frame; // its inner face
            builder_.quad(f.at(wall.length, height_, -kThick), f.at(0.0f, height_, -kThick),
                          f.at(0.0f, height_ + kParapet, -kThick),
                          f.at(wall.length, height_ + kParapet, -kThick));
        }
    }
}

void House::add_roof_furniture()
{
    Rng rng(hash64(plan_.seed, 10));
    const float half = 0.5f * plan_.width - 1.5f;
    const uint32_t chimneys = 2 + rng.below(3);
    for (uint32_t i = 0; i < chimneys; ++i) {
        const float x = rng.range(-half, half);
        const float z = -rng.range(0.25f, 0.75f) * plan_.depth;
        const float top = height_ + (plan_.pitched_roof ? 0.5f * plan_.depth : 2.0f);
        if (!can_pay(10 + 2 * 24)) {
            return;
        }
        builder_.box({x - 0.6f, height_ - 0.1f, z - 0.35f}, {x + 0.6f, top, z + 0.35f},
                     MeshBuilder::kAllFaces & ~MeshBuilder::kNegY);
        for (float pot : {-0.3f, 0.3f}) {
            upright_cylinder(builder_, {x + pot, top, z}, 0.7f, 0.2f, 0.15f, 8);
        }
    }
    const uint32_t machines = plan_.pitched_roof ? 0 : 1 + rng.below(4);
    for (uint32_t i = 0; i < machines && can_pay(10 + 48); ++i) {
        const float x = rng.range(-half, half);
        const float z = -rng.range(0.2f, 0.8f) * plan_.depth;
        builder_.box({x - 0.9f, height_ - 0.1f, z - 0.5f}, {x + 0.9f, height_ + 1.1f, z + 0.5f},
                     MeshBuilder::kAllFaces & ~MeshBuilder::kNegY);
        upright_cylinder(builder_, {x, height_ + 1.1f, z}, 0.15f, 0.4f, 0.4f, 16);
    }
}

Mesh House::build(std::string name, uint32_t item_triangles)
{
    add_shell();
    add_walls();
    add_parapets();
    add_roof_furniture();
    add_sills();
    if (has_reveals_) {
        add_doors();
        add_frames();
    }
    add_balconies();
    add_ledges();
    add_cornices();
    if (has_reveals_) {
        add_glazing_bars();
    }
    add_shutters();
    add_air_conditioners();
    add_quoins();
    add_roof_tiles();
    add_bricks();
    return builder_.take(std::move(name), item_triangles);
}

float house_height(const HousePlan& plan)
{
    return kGroundFloor + kHouseFloor * static_cast<float>(plan.floors - 1);
}

float facade_area(const HousePlan& plan)
{
    const auto sides = [&](uint32_t mask) {
        const bool front = (mask & HousePlan::kFront) != 0;
        const bool back = (mask & HousePlan::kBack) != 0;
        const bool right = (mask & HousePlan::kRight) != 0;
        const bool left = (mask & HousePlan::kLeft) != 0;
        return plan.width * static_cast<float>(front + back) +
               plan.depth * static_cast<float>(right + left);
    };
    return (sides(plan.street_sides) + 0.6f * sides(plan.yard_sides)) * house_height(plan);
}

Mesh make_house(const HousePlan& plan, size_t budget, std::string name, uint32_t item_triangles)
{
    return House(plan, budget).build(std::move(name), item_triangles);
}

} // namespace occlude::tools
