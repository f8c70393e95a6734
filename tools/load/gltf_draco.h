// KHR_draco_mesh_compression.
#pragma once

#include "load/gltf_primitive.h"

namespace occlude::tools {

/// Decodes attributes and triangles of a primitive that has the extension. Throws GltfError.
GltfPrimitive read_draco_primitive(GltfDocument& document, GltfAccessors& accessors,
                                   const nlohmann::json& extension);

} // namespace occlude::tools
