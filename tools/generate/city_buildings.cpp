#include "generate/city_buildings.h"

#include <occlude/core/rng.h>

#include <algorithm>

namespace occlude::tools {
namespace {

constexpr float kGroundFloor = 4.0f; // metres
constexpr float kFloor = 3.2f;
constexpr float kFoundation = 0.3f;
constexpr float kBay = 2.6f;     // at least this much wall per window
constexpr float kReveal = 0.25f; // how deep windows lie in the wall
constexpr float kParapet = 0.9f;

struct Opening {
    SurfaceFrame frame; ///< of its wall: u = 0 at the wall's left end, v = 0 on the ground
    glm::vec2 low{0.0f};
    glm::vec2 high{0.0f};
    glm::vec2 bay_u{0.0f}; ///< the bay of wall around it
    glm::vec2 bay_v{0.0f};
    uint32_t floor = 0;
    bool is_door = false;
    bool on_street = false;
    bool has_balcony = false;
    uint64_t hash = 0;

    float middle() const { return 0.5f * (low.x + high.x); }
};

struct Wall {
    SurfaceFrame frame;
    float length = 0.0f;
    bool has_windows = false;
    bool on_street = false;
};

/// A house under construction: one member function per kind of detail, each of which stops when
/// the budget is spent.
class House {
public:
    House(const HousePlan& plan, size_t budget);
    Mesh build(std::string name, uint32_t item_triangles);

private:
    void plan_walls();
    void plan_openings(const Wall& wall, uint32_t wall_number);

    void add_shell();
    void add_pitched_roof();
    void add_wing();
    void add_walls();
    void add_parapets();
    void add_roof_furniture();
    void add_sills();
    void add_frames();
    void add_balconies();
    void add_ledges();
    void add_cornices();
    void add_doors();
    void add_glazing_bars();
    void add_shutters();
    void add_air_conditioners();
    void add_quoins();
    void add_roof_tiles();
    void add_bricks();

    bool can_pay(size_t triangles) const { return builder_.triangles() + triangles <= budget_; }
    bool relief(const SurfaceFrame& frame, const glm::vec3& low, const glm::vec3& high);
    bool railing(const SurfaceFrame& frame, float begin, float end, float foot, float out);

    HousePlan plan_;
    size_t budget_;
    float height_;
    MeshBuilder builder_;
    std::vector<Wall> walls_;
    std::vector<Opening> openings_; ///< from the ground up
    bool has_reveals_ = false;      ///< windows lie in holes of the wall, not on it
};

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
    const auto bays = std::max(1u, static_cast<uint32_t>(wall.length / kBay));
    const float bay = wall.length / static_cast<float>(bays);
    const uint32_t door_bay = uniform_below(hash64(plan_.seed, wall_number, 1), bays);
    const uint32_t balcony_phase = uniform_below(hash64(plan_.seed, wall_number, 2), 3);
    const bool has_shop = uniform_below(hash64(plan_.seed, 3), 2) == 0;
    for (uint32_t floor = 0; floor < plan_.floors; ++floor) {
        const float foot =
            floor == 0 ? 0.0f : kGroundFloor + kFloor * static_cast<float>(floor - 1);
        const float head = floor == 0 ? kGroundFloor : foot + kFloor;
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
    const float top = height_ - kFloor;
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
            const float v = kGroundFloor + kFloor * static_cast<float>(floor - 1);
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

} // namespace

float house_height(const HousePlan& plan)
{
    return kGroundFloor + kFloor * static_cast<float>(plan.floors - 1);
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
