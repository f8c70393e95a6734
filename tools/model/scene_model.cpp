#include "model/scene_model.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>

namespace occlude::tools {

// The space in which an instance rotates and bounces: the box of the origins, extended by the reach
// of the instance from its origin.
static Aabb moving_bounds(const SceneModel& model, const Instance& instance,
                          const InstanceMotion& motion)
{
    float reach = 0.0f;
    for (const MeshPart& part : model.meshes[instance.mesh].parts) {
        const Aabb turned = transformed(glm::mat4{glm::mat3{instance.world_from_mesh}}, part.box);
        reach = std::max(reach, glm::length(glm::max(glm::abs(turned.min), glm::abs(turned.max))));
    }
    const glm::vec3 origin{instance.world_from_mesh[3]};
    Aabb origins = merge(model.motion.box, {origin, origin});
    for (const MotionKey& key : motion.keys) {
        origins = merge(origins, {key.position, key.position});
    }
    return inflated(origins, reach);
}

Aabb world_box(const SceneModel& model, const Instance& instance)
{
    Aabb box;
    for (const MeshPart& part : model.meshes[instance.mesh].parts) {
        box = merge(box, transformed(instance.world_from_mesh, part.box));
    }
    return box;
}

std::string object_name(const SceneModel& model, uint32_t instance)
{
    const std::string& name = model.instances[instance].name;
    return name.empty() ? "object " + std::to_string(instance) : name;
}

Aabb world_bounds(const SceneModel& model)
{
    Aabb bounds;
    for (size_t i = 0; i < model.instances.size(); ++i) {
        const Instance& instance = model.instances[i];
        if (!model.motion.empty() && model.motion.instances[i].moves()) {
            bounds = merge(bounds, moving_bounds(model, instance, model.motion.instances[i]));
        }
        bounds = merge(bounds, world_box(model, instance));
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

std::vector<ItemDesc> item_descriptions(const SceneModel& model, uint32_t instance)
{
    const ItemFlags flags =
        model.instances[instance].translucent() ? ItemFlags::translucent : ItemFlags::none;
    std::vector<ItemDesc> items;
    for (const MeshPart& part : model.meshes[model.instances[instance].mesh].parts) {
        items.push_back({.local_box = part.box,
                         .triangles = part.index_count / 3,
                         .flags = flags,
                         .shape = part.shape});
    }
    return items;
}

CullScene make_cull_scene(const SceneModel& model)
{
    CullScene result;
    result.objects.reserve(model.instances.size());
    for (uint32_t i = 0; i < model.instances.size(); ++i) {
        const std::vector<ItemDesc> items = item_descriptions(model, i);
        for (uint32_t part = 0; part < items.size(); ++part) {
            // A new scene assigns item ids in the order in which items are added.
            result.items.push_back({i, part});
        }
        result.objects.push_back(result.scene.add(model.instances[i].world_from_mesh, items));
    }
    return result;
}

} // namespace occlude::tools
