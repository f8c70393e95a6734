// The engine's world: houses, lamps and driving cars. It does not depend on OpenGL.
#pragma once

#include <occlude/hierarchy/hierarchy.h>

#include <glm/mat4x4.hpp>

#include <cstdint>
#include <vector>

namespace gl_engine {

/// One draw of the engine; its index is its ItemId.
struct Draw {
    enum class Mesh : uint8_t { cube, sphere }; ///< both fill -0.5 .. 0.5
    Mesh mesh = Mesh::cube;
    uint32_t material = 0; ///< what the engine sorts by
    glm::mat4 world_from_mesh{1.0f};
};

class Town {
public:
    static constexpr uint32_t kMaterials = 4;
    static constexpr float kSide = 160.0f; ///< world units; the town is around the origin

    Town();

    /// Moves everything to its place at this time, in seconds.
    void move_to(double seconds);

    const std::vector<Draw>& draws() const { return draws_; }
    /// Boxes and triangle counts by ItemId, as the library expects them.
    std::vector<occlude::ItemBounds> bounds() const;
    bool moves(size_t item) const { return item >= first_car_; }

private:
    std::vector<Draw> draws_;
    size_t first_car_ = 0;
};

/// Triangles of a mesh of this kind.
uint32_t triangle_count(Draw::Mesh mesh);

} // namespace gl_engine
