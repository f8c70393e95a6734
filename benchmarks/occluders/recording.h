// Recordings of the input of a masked occlusion culling library (.mocrec): the occluders of one
// frame, with their matrices.
//
// Layout, little-endian: u32 0xA701B600, f32 near, u32 width, u32 height; then records. Each starts
// with a byte for its kind:
//   0, 2  render or test triangles: i32 result, i32 vertices (0 ends the record), i32 stride,
//         vertices, i32 triangles, u32 indices, u8 has a matrix (then 16 f32), i32 clip planes,
//         i32 winding, 3 i32 layout
//   1     test a rectangle: i32 result, 5 f32
//   3     clear
//   0x7f  end
#pragma once

#include <occlude/occluder_buffer.h>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>

#include <optional>
#include <string>
#include <vector>

namespace occlude::benchmarks {

struct Recording {
    struct Instance {
        OccluderMesh mesh;
        glm::mat4 world_from_mesh{1.0f};
    };
    glm::ivec2 size_px{0};
    glm::mat4 clip_from_world{1.0f}; ///< from the first instance: its mesh's space is the world
    std::vector<Instance> instances;
    size_t triangles = 0;
};

/// Empty if the file cannot be read, or does not record triangles with matrices.
std::optional<Recording> read_recording(const std::string& path);

} // namespace occlude::benchmarks
