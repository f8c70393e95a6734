// The Utah teapot, from the control points that Martin Newell published.
#pragma once

#include "model/scene_model.h"

#include <cstdint>

namespace occlude::tools {

/// Patches of the teapot; each is cut into n x n squares of two triangles.
inline constexpr uint32_t kTeapotPatches = 32;

/// The n for which 32 n^2 2 is nearest to `triangles`; at least 1.
uint32_t teapot_steps(uint64_t triangles);

/// The teapot in Newell's units (6.4 long, 3.15 high), upright along y, its bottom at y = 0, spout
/// towards +x. Has 64 n^2 - 8 n triangles: at the knob's top and the bottom's middle one side of
/// every square has no length, and the triangle there is left out. Neighbouring patches share the
/// positions of their edges exactly. Body, lid and bottom are one closed surface but for the slit
/// under the lid; handle and spout end inside of the body, as published.
Mesh make_teapot(uint32_t steps, uint32_t item_triangles);

} // namespace occlude::tools
