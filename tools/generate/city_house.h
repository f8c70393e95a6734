// A house under construction. Internal to city_buildings.h: the walls and the roof are in
// city_buildings.cpp, everything on them in city_ornament.cpp.
#pragma once

#include "generate/city_buildings.h"

#include <vector>

namespace occlude::tools {

inline constexpr float kGroundFloor = 4.0f; // metres
inline constexpr float kHouseFloor = 3.2f;
inline constexpr float kFoundation = 0.3f;
inline constexpr float kHouseBay = 2.6f; // at least this much wall per window
inline constexpr float kReveal = 0.25f;  // how deep windows lie in the wall
inline constexpr float kParapet = 0.9f;

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

} // namespace occlude::tools
