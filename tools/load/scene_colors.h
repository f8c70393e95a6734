// Colours of objects, by their materials.
#pragma once

#include "load/loaded_scene.h"

#include <glm/vec3.hpp>

#include <cstdint>
#include <string_view>

namespace occlude::tools {

/// The file's colour, unless it is none, white or black: then a colour by the name of the material,
/// or of the mesh where there are no materials to tell apart.
glm::vec3 color_of(const LoadedScene& scene, uint32_t material_index, std::string_view mesh_name);

} // namespace occlude::tools
