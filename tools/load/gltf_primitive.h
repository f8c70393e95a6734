// One primitive of a glTF mesh as a list of triangles, whatever its mode and compression.
#pragma once

#include "load/gltf_accessors.h"
#include "load/loaded_scene.h"

#include <map>
#include <string>

namespace occlude::tools {

/// A vertex attribute: an accessor, or values that were decompressed.
struct GltfAttribute {
    const AccessorView* view = nullptr;
    std::vector<glm::vec4> decoded; ///< if there is no view

    size_t count() const { return view != nullptr ? view->count() : decoded.size(); }
    /// Missing components are 0.
    glm::vec4 at(size_t vertex) const;
};

struct GltfPrimitive {
    std::map<std::string, GltfAttribute> attributes; ///< POSITION among them
    std::vector<uint32_t> corners; ///< three per triangle; each below the number of vertices
    size_t vertices = 0;
    LeftOut left_out; ///< points and lines

    const GltfAttribute* find(const std::string& name) const;
};

/// Strips and fans become triangles, KHR_draco_mesh_compression is decoded. Throws GltfError.
GltfPrimitive read_primitive(GltfDocument& document, GltfAccessors& accessors,
                             const nlohmann::json& primitive);

/// How the vertices of a primitive are moved.
struct VertexMotion {
    std::vector<double> morph_weights = {}; ///< of the primitive's targets
    std::vector<glm::dmat4> joints = {};    ///< world_from_vertex of each joint; empty: no skin
};

/// The vertices that triangles use, in the order of their first use. If there are joints, positions
/// are in the world less `pivot`, which is set. Throws GltfError.
LoadedMesh build_mesh(GltfAccessors& accessors, const nlohmann::json& primitive,
                      const GltfPrimitive& data, const VertexMotion& motion, glm::dvec3& pivot);

} // namespace occlude::tools
