// What a reader found in a file, before the program decides about origin, unit and items.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace occlude::tools {

/// How much a material hides of what is behind it.
enum class Surface : uint8_t {
    opaque,       ///< everything
    masked,       ///< what its texture leaves; treated as hiding nothing
    blended,      ///< nothing, whatever its opacity
    transmissive, ///< nothing: light passes through
};

struct LoadedMaterial {
    std::string name = {};
    std::optional<glm::vec3> color = {}; ///< linear; empty: the file gives none
    float opacity = 1.0f;                ///< of blended materials
    Surface surface = Surface::opaque;
};

/// What of a mesh cannot be drawn, and why.
struct LeftOut {
    uint64_t points = 0;
    uint64_t lines = 0;
    uint64_t degenerate = 0;  ///< triangles with two equal corners
    uint64_t non_finite = 0;  ///< triangles with a corner that is not a number, or out of range
    uint64_t masked_away = 0; ///< triangles of which the alpha mask leaves nothing

    uint64_t triangles() const { return degenerate + non_finite + masked_away; }
    uint64_t all() const { return points + lines + triangles(); }
    LeftOut& operator+=(const LeftOut& other);
};

inline constexpr uint32_t kNoMaterial = 0xffffffffu;

/// Triangles of one material. `normals` is empty, or has one entry per position.
struct LoadedMesh {
    std::string name = {};
    std::vector<glm::vec3> positions = {};
    std::vector<glm::vec3> normals = {};
    std::vector<uint32_t> indices = {}; ///< three per triangle, each below positions.size()
    uint32_t material = kNoMaterial;    ///< an index, or kNoMaterial
    LeftOut left_out = {};
    uint64_t repeated = 0; ///< triangles over the same three points as another one, same side out
    uint64_t backs = 0;    ///< the same, the other side out
};

struct LoadedInstance {
    std::string name = {};
    uint32_t mesh = 0;
    glm::dmat4 world_from_mesh{1.0};
};

/// A perspective camera of the file.
struct LoadedCamera {
    std::string name = {};
    glm::dvec3 eye{0.0};
    glm::dvec3 forward{0.0, 0.0, -1.0};
    glm::dvec3 up{0.0, 1.0, 0.0};
    float fov_y = 60.0f; ///< degrees
    float near = 0.0f;   ///< 0: the file does not say
    float far = 0.0f;    ///< 0: the file does not say, or infinite
};

/// A file that was read, and what was in it.
struct SourceFile {
    std::string path;
    uint64_t hash = 0; ///< content_hash()
};

/// Positions are in double precision through the matrices of instances: a reader whose vertices lie
/// far from the origin moves them there and puts the way into the matrix.
struct LoadedScene {
    std::vector<LoadedMesh> meshes;
    std::vector<LoadedInstance> instances;
    std::vector<LoadedMaterial> materials;
    std::vector<LoadedCamera> cameras;
    std::optional<float> units_per_metre; ///< as the file itself says
    std::optional<glm::vec3> up;          ///< as the file or its format says
    bool format_is_metric = false;        ///< the format defines that a unit is a metre
    std::vector<std::string> notes;       ///< sentences about what was not taken over
    std::vector<SourceFile> sources;      ///< for the cache; empty: it is not worth keeping
};

} // namespace occlude::tools
