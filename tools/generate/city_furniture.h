// What stands in the streets of the generated city.
#pragma once

#include "model/mesh_tools.h"

#include <cstdint>

namespace occlude::tools {

enum class Furniture : uint32_t { tree, car, lamp, bench, bin, sign };
constexpr uint32_t kFurnitureKinds = 6;

/// The most triangles that `kind` can make use of.
size_t furniture_limit(Furniture kind);

/// One piece in metres, standing on y = 0 at the origin, with at most max(`budget`, 40) triangles.
/// Cars are 4.2 m long along x; lamps and signs reach toward +z, and benches face it.
Mesh make_furniture(Furniture kind, uint64_t seed, size_t budget, uint32_t item_triangles);

} // namespace occlude::tools
