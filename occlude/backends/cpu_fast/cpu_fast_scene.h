// What CpuFastDevice asks the engine: which mesh an item is drawn with, if it may hide anything.
#pragma once

#include <occlude/backends/cpu_fast/occluder_mesh.h>
#include <occlude/core/ids.h>

#include <glm/mat4x4.hpp>

namespace occlude {

struct CpuFastItem {
    /// The triangles that one draw of the item draws, or fewer of them; null if the item hides
    /// nothing: alpha-tested, translucent, displaced by a shader. Must live until end_frame().
    const OccluderMesh* mesh = nullptr;
    glm::mat4 world_from_mesh{1.0f};
};

class CpuFastScene {
public:
    virtual ~CpuFastScene() = default;

    /// The item as it is drawn now. An unknown item hides nothing.
    virtual CpuFastItem item(ItemId item) const = 0;
};

} // namespace occlude
