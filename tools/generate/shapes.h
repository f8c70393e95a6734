// Round and bent things for generated scenes, from square roots only: the same on every machine.
#pragma once

#include "model/mesh_tools.h"

#include <span>

namespace occlude::tools {

/// Two directions of length 1 that span the plane across `axis` (of any length but 0), so that
/// cross(first, second) points along it.
struct Across {
    glm::vec3 first;
    glm::vec3 second;
};
Across across(const glm::vec3& axis);

/// A tube around a line of points, mitred at each of them, open at both ends: 2 triangles per
/// segment and piece. Points that are the same as the one before are left out. Precondition: two
/// points differ, and the line nowhere turns straight back; segments is 4, 8, 16 or 32.
void tube(MeshBuilder& builder, std::span<const glm::vec3> line, float radius, uint32_t segments);

/// A closed cylinder between two points: 4 triangles per segment, less 4.
void rod(MeshBuilder& builder, const glm::vec3& from, const glm::vec3& to, float radius,
         uint32_t segments);

/// Turns a profile of points (radius, height) around an upright axis through `base`: 2 triangles
/// per segment and piece, 1 where the profile touches the axis. A profile that goes upward is seen
/// from outside.
void turned(MeshBuilder& builder, const glm::vec3& base, std::span<const glm::vec2> profile,
            uint32_t segments);

/// A box about a middle.
void block(MeshBuilder& builder, const glm::vec3& middle, const glm::vec3& size,
           uint32_t faces = MeshBuilder::kAllFaces);

/// Turns by a number of quarter turns about y, counter-clockwise seen from above, then moves.
glm::mat4 quarter_turned(uint32_t quarters, const glm::vec3& at);

/// The turn about y that takes +z to the direction (sine, cosine) in x and z, then a move.
/// Precondition: sine^2 + cosine^2 = 1.
glm::mat4 turned_about_y(float sine, float cosine, const glm::vec3& at);

} // namespace occlude::tools
