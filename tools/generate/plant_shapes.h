// What the parts of the plant are made of. Internal to plant_parts.h.
#pragma once

#include "generate/plant_parts.h"

namespace occlude::tools::plant {

inline constexpr float kIn = kPlantInner;
inline constexpr float kBay = 0.5f * kPlantPitch;
inline constexpr float kUnder = kPlantFloor - 0.45f; // where the beams of the floor above begin

/// The middle of the i-th of `count` equal pieces of 0 to 1.
inline float ratio(uint32_t i, uint32_t count)
{
    return (static_cast<float>(i) + 0.5f) / static_cast<float>(count);
}

/// An upright or level I-beam between two points: flanges along `side`.
void beam(MeshBuilder& builder, const glm::vec3& from, const glm::vec3& to, float depth);
/// A ring around a pipe at `at`, across `way`.
void flange(MeshBuilder& builder, const glm::vec3& at, const glm::vec3& way, float radius);

// Machinery: plant_machinery.cpp.
void make_boiler(MeshBuilder& builder, uint32_t elements);
void make_bundle(MeshBuilder& builder, uint32_t elements);
void make_rack(MeshBuilder& builder, uint32_t elements, uint64_t seed);
void make_vessel(MeshBuilder& builder, uint32_t elements, float radius, float height);
void make_machine(MeshBuilder& builder, uint32_t elements);
void make_trays(MeshBuilder& builder, uint32_t elements, uint64_t seed);

// What holds it: plant_structure.cpp.
void make_stairs(MeshBuilder& builder, uint32_t elements);
void make_grating(MeshBuilder& builder, uint32_t elements);
void make_frame(MeshBuilder& builder, uint32_t elements);
void make_cladding(MeshBuilder& builder, uint32_t elements);
void make_pipework(MeshBuilder& builder, uint32_t elements, uint64_t seed);

} // namespace occlude::tools::plant
