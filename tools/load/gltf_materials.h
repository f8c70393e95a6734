// What the materials of a glTF file hide, and their colours.
#pragma once

#include "load/gltf_document.h"
#include "load/loaded_scene.h"

namespace occlude::tools {

/// One entry per material of the file. Throws GltfError.
std::vector<LoadedMaterial> read_materials(const GltfDocument& document);

} // namespace occlude::tools
