#include "scenes/scene_model.h"

namespace occlude::tools {

Aabb world_bounds(const SceneModel& model)
{
    Aabb bounds;
    for (const Instance& instance : model.instances) {
        for (const MeshPart& part : model.meshes[instance.mesh].parts) {
            bounds = merge(bounds, transformed(instance.world_from_mesh, part.box));
        }
    }
    return bounds;
}

uint64_t drawn_triangles(const SceneModel& model)
{
    uint64_t triangles = 0;
    for (const Instance& instance : model.instances) {
        triangles += model.meshes[instance.mesh].indices.size() / 3;
    }
    return triangles;
}

CullScene make_cull_scene(const SceneModel& model)
{
    CullScene result;
    result.objects.reserve(model.instances.size());
    std::vector<ItemDesc> items;
    for (uint32_t i = 0; i < model.instances.size(); ++i) {
        const Instance& instance = model.instances[i];
        const Mesh& mesh = model.meshes[instance.mesh];
        const ItemFlags flags = instance.opacity < 1.0f ? ItemFlags::translucent : ItemFlags::none;
        items.clear();
        for (uint32_t part = 0; part < mesh.parts.size(); ++part) {
            items.push_back({.local_box = mesh.parts[part].box,
                             .triangles = mesh.parts[part].index_count / 3,
                             .flags = flags});
            // A fresh scene gives out item ids in the order of the items added.
            result.items.push_back({i, part});
        }
        result.objects.push_back(result.scene.add(instance.world_from_mesh, items));
    }
    return result;
}

} // namespace occlude::tools
