// Meshes cut exactly into items (scene/split.h), cached on disk.
#pragma once

#include "model/scene_model.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace occlude::tools {

/// The default folder of the cache: $XDG_CACHE_HOME/occlude, else $HOME/.cache/occlude; empty if
/// neither exists.
std::filesystem::path default_cache_folder();

/// Replaces positions, normals, indices and parts of a mesh of more than `item_triangles` triangles
/// by the same mesh cut exactly into parts of about that many. A smaller mesh becomes one part.
/// Uses and fills `cache_folder`; an empty path, or a folder that cannot be written, only costs the
/// time to cut again. True if the mesh came from the cache.
bool split_mesh_exactly(Mesh& mesh, uint32_t item_triangles,
                        const std::filesystem::path& cache_folder);

/// The file name for a mesh and a size of parts: a hash of everything that the cut depends on.
std::string split_cache_name(const Mesh& mesh, uint32_t item_triangles);

/// Writes positions, normals, indices and parts, under another name first and renamed when
/// complete, so that readers see all of it or nothing. False, and no file, if that fails.
bool write_cut_mesh(const std::filesystem::path& file, const Mesh& mesh);

/// Reads them back into a mesh without a name; nothing if there is no such file or it is damaged in
/// any way: a checksum covers every byte.
std::optional<Mesh> read_cut_mesh(const std::filesystem::path& file);

} // namespace occlude::tools
