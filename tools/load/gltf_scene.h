// The nodes of a glTF scene: which there are, where they stand, and what hangs from them.
#pragma once

#include "load/gltf_accessors.h"
#include "load/loaded_scene.h"

#include <glm/mat4x4.hpp>

#include <vector>

namespace occlude::tools {

/// A node that can be reached from the default scene, each time it is.
struct PlacedNode {
    uint32_t index = 0;
    glm::dmat4 world_from_node{1.0};
};

/// The visible nodes of the default scene, parents first, siblings in their order. Throws GltfError
/// for nodes that nest too deeply, or are too many by having several parents.
std::vector<PlacedNode> placed_nodes(const GltfDocument& document);

/// world_from_node of every node of the file, as if each had one parent. For joints of skins.
std::vector<glm::dmat4> node_worlds(const GltfDocument& document);

/// The transforms of EXT_mesh_gpu_instancing relative to the node; one identity without it.
std::vector<glm::dmat4> instance_transforms(GltfAccessors& accessors, const nlohmann::json& node);

/// The matrices of a skin's joints, from vertices to the world.
std::vector<glm::dmat4> joint_matrices(const GltfDocument& document, GltfAccessors& accessors,
                                       size_t skin, const std::vector<glm::dmat4>& worlds);

/// The camera of a node, if it has a perspective one.
std::optional<LoadedCamera> camera_of(const GltfDocument& document, const nlohmann::json& node,
                                      const glm::dmat4& world_from_node);

} // namespace occlude::tools
