// A scene with its triangles: made by files and generators, drawn by renderers.
#pragma once

#include "model/motion.h"

#include <occlude/core/aabb.h>
#include <occlude/core/ids.h>
#include <occlude/scene/camera_path.h>
#include <occlude/scene/scene.h>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace occlude::tools {

/// A run of a mesh's index buffer that one item draws.
struct MeshPart {
    uint32_t first_index = 0;
    uint32_t index_count = 0;                ///< three per triangle
    Aabb box;                                ///< in the space of the mesh
    std::shared_ptr<const Shape> shape = {}; ///< in the same space; null: none
};

/// An indexed triangle mesh. Counter-clockwise triangles face outward, but nothing relies on it:
/// both sides are drawn.
struct Mesh {
    std::string name;
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals; ///< one per position, length 1
    std::vector<uint32_t> indices;
    std::vector<MeshPart> parts; ///< covers all indices, in order; at least one
};

/// One placement of a mesh: an object of the scene, with one item per part of its mesh.
struct Instance {
    std::string name;
    uint32_t mesh = 0;
    glm::mat4 world_from_mesh{1.0f};
    glm::vec3 color{0.7f}; ///< linear base colour
    float opacity = 1.0f;  ///< below 1: translucent, blended over the things behind
    /// Its material lets something through although it is drawn with full opacity: it is drawn like
    /// a translucent one and hides nothing.
    bool see_through = false;

    bool translucent() const { return see_through || opacity < 1.0f; }
};

struct SceneModel {
    std::string name;
    std::vector<Mesh> meshes;
    std::vector<Instance> instances;
    glm::vec3 up{0.0f, 1.0f, 0.0f};
    /// World units per metre: 1 for scenes in metres; used for human height and the near plane.
    float unit = 1.0f;
    /// Named camera paths that came with the scene (generators make some); may be empty.
    struct NamedPath {
        std::string name;
        std::vector<Keyframe> keys;
    };
    std::vector<NamedPath> paths;
    /// How the instances move from frame to frame of a path; empty if they stand still.
    Motion motion;
    /// The point of the file that lies at (0, 0, 0) here: world = file - origin. It is not zero if
    /// the file's scene lies so far from its origin that single precision would distort it.
    glm::dvec3 origin{0.0};
    /// The loader's notes on the file, one sentence each; empty for generated scenes.
    std::vector<std::string> load_notes;
    /// Losses: what the file has and the scene leaves out, one sentence each.
    std::vector<std::string> load_losses;
    /// Triangles of all instances in the file, including those left out; 0: there is no file.
    uint64_t file_triangles = 0;
    /// Triangles of all instances before meshes were cut into items; set by load_scene().
    uint64_t uncut_triangles = 0;

    /// The instance and the part that one item draws.
    struct Item {
        uint32_t instance = 0;
        uint32_t part = 0;
    };
};

/// The box of an instance under its transform, in world space.
Aabb world_box(const SceneModel& model, const Instance& instance);

/// The name of an instance in messages; "object 7" if it has none.
std::string object_name(const SceneModel& model, uint32_t instance);

/// Bounds of all instances in all frames, world space.
Aabb world_bounds(const SceneModel& model);

/// Triangles of all instances.
uint64_t drawn_triangles(const SceneModel& model);

/// The scene in the form that culling needs, and what each of its items draws (indexed by ItemId).
/// Object i of `objects` is instance i.
struct CullScene {
    Scene scene;
    std::vector<ObjectId> objects;
    std::vector<SceneModel::Item> items;
};
CullScene make_cull_scene(const SceneModel& model);

/// The items of one instance as Scene::add() takes them, one per part of its mesh.
std::vector<ItemDesc> item_descriptions(const SceneModel& model, uint32_t instance);

} // namespace occlude::tools
