#include "generate/boxes_generator.h"

#include "model/mesh_tools.h"

#include <occlude/core/rng.h>

#include <fmt/format.h>

namespace occlude::tools {

SceneModel generate_boxes(const BoxesOptions& options, const SceneOptions& scene_options)
{
    constexpr float kHalfCube = 50.0f; // metres
    SceneModel model;
    model.name = fmt::format("boxes:count={},seed={}", options.count, options.seed);
    MeshBuilder builder;
    builder.box(glm::vec3{-0.5f}, glm::vec3{0.5f});
    model.meshes.push_back(builder.take("box", scene_options.item_triangles));
    model.instances.reserve(options.count);
    Rng rng(options.seed);
    for (uint32_t i = 0; i < options.count; ++i) {
        glm::mat4 world_from_mesh{1.0f};
        for (int axis = 0; axis < 3; ++axis) {
            const float t = rng.range(0.0f, 1.0f);
            world_from_mesh[axis][axis] = 0.25f + 7.75f * t * t * t; // mostly small
            world_from_mesh[3][axis] = rng.range(-kHalfCube, kHalfCube);
        }
        const glm::vec3 color{rng.range(0.2f, 0.9f), rng.range(0.2f, 0.9f), rng.range(0.2f, 0.9f)};
        model.instances.push_back({fmt::format("box {}", i), 0, world_from_mesh, color});
    }
    return model;
}

} // namespace occlude::tools
