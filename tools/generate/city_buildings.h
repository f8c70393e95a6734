// The houses of the generated city.
#pragma once

#include "model/mesh_tools.h"

#include <cstdint>
#include <string>

namespace occlude::tools {

/// A house in its own space, in metres: the front stands on z = 0 and faces +z, x runs from
/// -width / 2 to width / 2, and the ground is y = 0 (walls go 0.3 m deeper).
struct HousePlan {
    enum Sides : uint32_t { kFront = 1, kRight = 2, kBack = 4, kLeft = 8, kAllSides = 15 };

    float width = 12.0f;
    float depth = 13.0f;
    uint32_t floors = 5;
    uint32_t street_sides = kFront; ///< walls with doors, balconies and ornament
    uint32_t yard_sides = kBack;    ///< walls with plain windows; the others are blank
    bool pitched_roof = false;      ///< else flat behind a parapet
    float wing = 0.0f;              ///< width of a wing at the back; 0: none
    uint64_t seed = 1;              ///< of the ornament
};

float house_height(const HousePlan& plan);

/// Area of the walls with windows, in square metres: what its share of triangles should follow.
float facade_area(const HousePlan& plan);

/// Builds the house with at most `budget` triangles, but at least its walls and roof. The budget
/// is spent in the order in which detail is seen: openings, parapet and chimneys, sills, frames,
/// balconies, cornices, glazing bars, shutters, roof tiles, and at last bricks; each from the
/// ground up.
Mesh make_house(const HousePlan& plan, size_t budget, std::string name, uint32_t item_triangles);

} // namespace occlude::tools
