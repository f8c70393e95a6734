// The interface that an engine implements for the CPU device: the triangles of an item.
#pragma once

#include <occlude/core/aabb.h>
#include <occlude/core/ids.h>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include <cstdint>
#include <span>

namespace occlude {

/// The triangles of one draw of an item. The spans must live until the calling verb returns. A
/// triangle with an index outside `positions`, or with a position that is not finite, is not drawn.
struct CpuItem {
    std::span<const glm::vec3> positions; ///< in the space of the mesh; may be shared by many items
    std::span<const uint32_t> indices;    ///< three per triangle; only these positions are read
    glm::mat4 world_from_mesh{1.0f};
    /// Bounds of the indexed positions, in the space of the mesh, for rejecting the item as a
    /// whole. The default rejects nothing.
    Aabb box = Aabb::everything();
    /// Translucent: hides nothing, not even itself; its fragments are listed, not written.
    bool translucent = false;
};

class CpuScene {
public:
    virtual ~CpuScene() = default;

    /// The current triangles of `item`. An unknown item has none.
    virtual CpuItem item(ItemId item) const = 0;
};

} // namespace occlude
