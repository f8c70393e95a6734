// What is on the walls and the roof of a house, in the order in which it is seen.
#include "generate/city_house.h"

#include <occlude/core/rng.h>

#include <algorithm>

namespace occlude::tools {

void House::add_sills()
{
    for (const Opening& o : openings_) {
        if (!o.is_door && !relief(o.frame, {o.low.x - 0.1f, o.low.y - 0.12f, 0.0f},
                                  {o.high.x + 0.1f, o.low.y, 0.16f})) {
            return;
        }
    }
}

void House::add_frames()
{
    constexpr float kBar = 0.09f;
    for (const Opening& o : openings_) {
        const float back = -kReveal;
        const float front = -kReveal + 0.1f;
        const float middle = o.middle();
        if (!can_pay(60)) {
            return;
        }
        relief(o.frame, {o.low.x, o.low.y, back}, {o.low.x + kBar, o.high.y, front});
        relief(o.frame, {o.high.x - kBar, o.low.y, back}, {o.high.x, o.high.y, front});
        relief(o.frame, {o.low.x, o.low.y, back}, {o.high.x, o.low.y + kBar, front - 0.01f});
        relief(o.frame, {o.low.x, o.high.y - kBar, back}, {o.high.x, o.high.y, front - 0.01f});
        relief(o.frame, {middle - 0.04f, o.low.y, back}, {middle + 0.04f, o.high.y, front + 0.01f});
        const float transom = o.low.y + 0.7f * (o.high.y - o.low.y);
        relief(o.frame, {o.low.x, transom, back}, {o.high.x, transom + 0.06f, front - 0.02f});
    }
}

/// Two rails with posts between them, parallel to the wall, from `begin` to `end` along u.
bool House::railing(const SurfaceFrame& frame, float begin, float end, float foot, float out)
{
    constexpr float kHeight = 1.0f;
    const auto posts = static_cast<uint32_t>((end - begin) / 0.14f);
    if (!relief(frame, {begin, foot + kHeight, out - 0.06f}, {end, foot + kHeight + 0.06f, out})) {
        return false;
    }
    for (uint32_t i = 0; i <= posts; ++i) {
        const float u = begin + (end - begin) * static_cast<float>(i) / static_cast<float>(posts);
        if (!relief(frame, {u - 0.012f, foot, out - 0.045f},
                    {u + 0.012f, foot + kHeight, out - 0.015f})) {
            return false;
        }
    }
    return true;
}

void House::add_balconies()
{
    constexpr float kOut = 1.1f;
    for (const Opening& o : openings_) {
        if (!o.has_balcony) {
            continue;
        }
        const float begin = o.low.x - 0.5f;
        const float end = o.high.x + 0.5f;
        const float foot = o.low.y;
        if (!relief(o.frame, {begin, foot - 0.18f, 0.0f}, {end, foot, kOut})) {
            return;
        }
        // The sides are walls of their own: u along the outward direction of the house wall.
        const SurfaceFrame right{o.frame.at(end, 0.0f, 0.0f), -o.frame.w, o.frame.v, o.frame.u};
        const SurfaceFrame left{o.frame.at(begin, 0.0f, 0.0f), o.frame.w, o.frame.v, -o.frame.u};
        if (!railing(o.frame, begin, end, foot, kOut) || !railing(right, -kOut, 0.0f, foot, 0.0f) ||
            !railing(left, 0.0f, kOut, foot, 0.0f)) {
            return;
        }
    }
}

/// String courses between the floors and hoods above the windows.
void House::add_ledges()
{
    for (const Wall& wall : walls_) {
        for (uint32_t floor = 1; wall.on_street && floor < plan_.floors; ++floor) {
            const float v = kGroundFloor + kHouseFloor * static_cast<float>(floor - 1);
            relief(wall.frame, {0.02f, v - 0.1f, 0.0f}, {wall.length - 0.02f, v + 0.02f, 0.1f});
        }
    }
    for (const Opening& o : openings_) {
        if (o.on_street && !relief(o.frame, {o.low.x - 0.15f, o.high.y + 0.05f, 0.0f},
                                   {o.high.x + 0.15f, o.high.y + 0.2f, 0.2f})) {
            return;
        }
    }
}

/// A moulding below the roof, carried by dentils.
void House::add_cornices()
{
    constexpr float kPitch = 0.45f;
    for (const Wall& wall : walls_) {
        if (!wall.on_street) {
            continue;
        }
        relief(wall.frame, {0.02f, height_ - 0.25f, 0.0f}, {wall.length - 0.02f, height_, 0.45f});
        const auto dentils = static_cast<uint32_t>(wall.length / kPitch);
        for (uint32_t i = 0; i < dentils; ++i) {
            const float u = kPitch * (static_cast<float>(i) + 0.3f);
            if (!relief(wall.frame, {u, height_ - 0.5f, 0.0f}, {u + 0.2f, height_ - 0.25f, 0.3f})) {
                return;
            }
        }
    }
}

void House::add_doors()
{
    for (const Opening& o : openings_) {
        if (!o.is_door) {
            continue;
        }
        const float left = o.low.x;
        const float right = o.high.x;
        for (uint32_t step = 0; step < 2; ++step) {
            const float s = static_cast<float>(step);
            relief(o.frame, {left - 0.3f + 0.1f * s, -0.1f, 0.0f},
                   {right + 0.3f - 0.1f * s, 0.175f * (s + 1.0f), 0.7f - 0.35f * s});
        }
        for (uint32_t panel = 0; panel < 6; ++panel) {
            const float u = (panel % 2 == 0 ? left : o.middle()) + 0.14f;
            const float v = o.low.y + 0.2f + 0.6f * static_cast<float>(panel / 2);
            relief(o.frame, {u, v, -kReveal}, {u + 0.38f, v + 0.48f, -kReveal + 0.05f});
        }
        relief(o.frame, {left - 0.5f, 3.2f, 0.0f}, {right + 0.5f, 3.35f, 1.0f});   // canopy
        relief(o.frame, {right + 0.25f, 1.4f, 0.0f}, {right + 0.4f, 1.8f, 0.05f}); // bells
    }
}

void House::add_glazing_bars()
{
    for (const Opening& o : openings_) {
        const float height = o.high.y - o.low.y;
        for (uint32_t i = 1; i < 4; ++i) {
            const float v = o.low.y + 0.23f * height * static_cast<float>(i);
            if (!o.is_door && !relief(o.frame, {o.low.x, v - 0.015f, -kReveal},
                                      {o.high.x, v + 0.015f, -kReveal + 0.04f})) {
                return;
            }
        }
    }
}

void House::add_shutters()
{
    constexpr uint32_t kSlats = 12;
    for (const Opening& o : openings_) {
        if (o.is_door || o.floor == 0 || uniform_below(o.hash, 3) == 0) {
            continue;
        }
        const float width = 0.5f * (o.high.x - o.low.x);
        for (float left : {o.low.x - width, o.high.x}) {
            if (!relief(o.frame, {left, o.low.y, 0.0f}, {left + width, o.high.y, 0.04f})) {
                return;
            }
            const float pitch = (o.high.y - o.low.y) / static_cast<float>(kSlats);
            for (uint32_t i = 0; i < kSlats; ++i) {
                const float v = o.low.y + pitch * (static_cast<float>(i) + 0.2f);
                if (!relief(o.frame, {left + 0.05f, v, 0.04f},
                            {left + width - 0.05f, v + 0.6f * pitch, 0.06f})) {
                    return;
                }
            }
        }
    }
}

void House::add_air_conditioners()
{
    for (const Opening& o : openings_) {
        if (o.is_door || o.floor == 0 || o.has_balcony || uniform_below(mix64(o.hash), 4) != 0) {
            continue;
        }
        const float u = o.middle() - 0.4f;
        const float v = o.low.y - 0.75f;
        if (!relief(o.frame, {u, v, 0.0f}, {u + 0.8f, v + 0.55f, 0.35f})) {
            return;
        }
        for (uint32_t i = 0; i < 8; ++i) {
            const float grille = v + 0.06f + 0.055f * static_cast<float>(i);
            relief(o.frame, {u + 0.08f, grille, 0.35f}, {u + 0.6f, grille + 0.02f, 0.37f});
        }
    }
}

/// Alternating long and short stones at the ends of street walls, and a drainpipe.
void House::add_quoins()
{
    constexpr float kStone = 0.4f;
    for (const Wall& wall : walls_) {
        if (!wall.on_street) {
            continue;
        }
        const auto stones = static_cast<uint32_t>((height_ - 0.6f) / kStone);
        for (uint32_t i = 0; i < stones; ++i) {
            const float v = kStone * static_cast<float>(i);
            const float reach = i % 2 == 0 ? 0.55f : 0.35f;
            if (!relief(wall.frame, {0.03f, v + 0.02f, 0.0f}, {reach, v + kStone - 0.02f, 0.05f})) {
                return;
            }
        }
        relief(wall.frame, {wall.length - 0.3f, 0.0f, 0.02f},
               {wall.length - 0.2f, height_ - 0.3f, 0.12f});
    }
}

void House::add_roof_tiles()
{
    if (!plan_.pitched_roof) {
        return;
    }
    constexpr float kRow = 0.5f;
    constexpr float kTile = 0.5f;
    const float half = 0.5f * plan_.width;
    const SurfaceFrame front{
        {-half, height_, 0.0f}, {1.0f, 0.0f, 0.0f}, {0.0f, 0.6f, -0.8f}, {0.0f, 0.8f, 0.6f}};
    const SurfaceFrame back{{half, height_, -plan_.depth},
                            {-1.0f, 0.0f, 0.0f},
                            {0.0f, 0.6f, 0.8f},
                            {0.0f, 0.8f, -0.6f}};
    const auto rows = static_cast<uint32_t>(0.625f * plan_.depth / kRow);
    const auto tiles = static_cast<uint32_t>(plan_.width / kTile);
    for (const SurfaceFrame& slope : {front, back}) {
        for (uint32_t i = 0; i < rows * tiles; ++i) {
            const float u = kTile * static_cast<float>(i % tiles);
            const float v = kRow * static_cast<float>(i / tiles);
            const float thick = (i + i / tiles) % 2 == 0 ? 0.04f : 0.06f;
            if (!relief(slope, {u + 0.02f, v, 0.0f},
                        {u + kTile - 0.02f, v + kRow - 0.04f, thick})) {
                return;
            }
        }
    }
}

/// Bricks standing out of the piers between the windows: any budget can be spent here.
void House::add_bricks()
{
    constexpr float kCourse = 0.11f;
    constexpr float kBrick = 0.3f;
    for (const bool street : {true, false}) {
        for (const Opening& o : openings_) {
            if (o.on_street != street) {
                continue;
            }
            const float first = std::max(o.bay_v.x, 0.0f);
            const auto courses = static_cast<uint32_t>((o.bay_v.y - first) / kCourse);
            for (uint32_t i = 0; i < courses; ++i) {
                const float v = first + kCourse * static_cast<float>(i);
                const float shift = i % 2 == 0 ? 0.02f : 0.5f * kBrick;
                for (float u = o.bay_u.x + shift; u + kBrick < o.low.x; u += kBrick) {
                    if (!relief(o.frame, {u, v, 0.0f},
                                {u + kBrick - 0.02f, v + kCourse - 0.02f, 0.02f})) {
                        return;
                    }
                }
                for (float u = o.high.x + shift; u + kBrick < o.bay_u.y; u += kBrick) {
                    if (!relief(o.frame, {u, v, 0.0f},
                                {u + kBrick - 0.02f, v + kCourse - 0.02f, 0.02f})) {
                        return;
                    }
                }
            }
        }
    }
}

} // namespace occlude::tools
