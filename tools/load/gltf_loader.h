// Scenes from glTF 2.0 files.
#pragma once

#include "load/loaded_scene.h"

#include <occlude/core/result.h>

#include <cstdint>
#include <filesystem>
#include <functional>

namespace occlude::tools {

/// The default scene of a glTF file: geometry, instances, perspective cameras, what materials hide.
/// Skins stand in their bind pose, morph targets in their default weights. Of extensions it knows
/// KHR_mesh_quantization, EXT_mesh_gpu_instancing, KHR_draco_mesh_compression,
/// EXT_meshopt_compression, KHR_node_visibility, KHR_materials_transmission, and those that change
/// shading only; another one is an error where the file requires it, and a note where it is used.
/// Errors name the file. `memory_budget`: bytes that decoding may allocate in all. `progress` hears
/// which share of the file's triangles is read; it may be empty.
///
/// Implements: glTF 2.0 (ISO/IEC 12113:2022). It parses JSON itself instead of through tinygltf,
/// which refuses buffers without a URI (the fallback buffers of EXT_meshopt_compression), decodes
/// all images, and copies all buffers.
Result<LoadedScene> load_gltf(const std::filesystem::path& file, uint64_t memory_budget,
                              const std::function<void(double share)>& progress);

/// Whether decoding the file runs code of others that may not survive broken data (Draco's meshes,
/// images of alpha masks).
bool gltf_needs_guard(const std::filesystem::path& file);

} // namespace occlude::tools
