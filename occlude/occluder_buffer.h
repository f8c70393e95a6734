// Software occlusion culling by itself, for engines that want nothing else of the library:
// OccluderBuffer and OccluderMesh. docs/integration.md has the five lines.
#pragma once

#include <occlude/backends/cpu_fast/occluder_buffer.h>
#include <occlude/backends/cpu_fast/occluder_mesh.h>
