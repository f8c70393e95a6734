// Scenes of a few quads that tests can reason about by hand.
#pragma once

#include "measure/stage.h"
#include "model/scene_model.h"

#include <occlude/core/result.h>
#include <occlude/cull/parts/cull_frame.h>
#include <occlude/cull/registry.h>
#include <occlude/hierarchy/builders/bvh_builder.h>

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>

#include <string>

namespace occlude::tools::test {

/// Adds an object of one item: a rectangle that faces +z, at depth `z`.
inline void add_quad(SceneModel& model, glm::vec2 low, glm::vec2 high, float z,
                     glm::vec3 color = glm::vec3{0.7f})
{
    Mesh mesh;
    mesh.name = "quad";
    mesh.positions = {
        {low.x, low.y, z}, {high.x, low.y, z}, {high.x, high.y, z}, {low.x, high.y, z}};
    mesh.normals.assign(4, glm::vec3{0.0f, 0.0f, 1.0f});
    mesh.indices = {0, 1, 2, 0, 2, 3};
    mesh.parts = {{0, 6, {{low.x, low.y, z}, {high.x, high.y, z}}}};
    const auto index = static_cast<uint32_t>(model.meshes.size());
    model.meshes.push_back(std::move(mesh));
    model.instances.push_back(
        {.name = "quad", .mesh = index, .world_from_mesh = glm::mat4{1.0f}, .color = color});
}

/// Seen from the origin along -z: item 0 is a wall, 1 and 2 stand hidden behind it, 3 before it, 4
/// beside it, 5 behind the camera.
inline SceneModel wall_model()
{
    SceneModel model;
    model.name = "wall";
    add_quad(model, {-4.0f, -4.0f}, {4.0f, 4.0f}, -5.0f);
    add_quad(model, {-1.0f, -1.0f}, {1.0f, 1.0f}, -10.0f);
    add_quad(model, {-3.0f, 1.0f}, {-1.0f, 3.0f}, -12.0f);
    add_quad(model, {-0.5f, -0.5f}, {0.5f, 0.5f}, -4.0f);
    add_quad(model, {9.0f, -1.0f}, {11.0f, 1.0f}, -10.0f);
    add_quad(model, {-1.0f, -1.0f}, {1.0f, 1.0f}, 20.0f);
    return model;
}

/// A camera at `eye` that looks along -z, turned by `degrees` to the left, 90 degrees wide.
inline View look_along_z(glm::vec3 eye = glm::vec3{0.0f}, float degrees = 0.0f,
                         glm::ivec2 size = {48, 32})
{
    const glm::mat4 clip_from_eye = glm::perspectiveRH_NO(
        glm::radians(90.0f), static_cast<float>(size.x) / static_cast<float>(size.y), 0.1f, 100.0f);
    const glm::mat4 world_from_eye = glm::rotate(
        glm::translate(glm::mat4{1.0f}, eye), glm::radians(degrees), glm::vec3{0.0f, 1.0f, 0.0f});
    return View::from_clip(clip_from_eye * glm::inverse(world_from_eye), size);
}

/// A model with everything needed to run algorithms on it.
struct TinyStage {
    explicit TinyStage(SceneModel scene_model, glm::ivec2 size = {48, 32})
        : model(std::move(scene_model))
        , scene(make_cull_scene(model))
        , hierarchy(
              build_bvh(scene.scene.item_bounds(), {.max_leaf_items = 1, .leaf_triangles = 0}))
        , renderer(std::move(*make_cpu_renderer(model, scene.items, size)))
    {
    }
    Stage stage() { return {hierarchy, scene.scene.item_bounds(), *renderer}; }

    SceneModel model;
    CullScene scene;
    Hierarchy hierarchy;
    std::unique_ptr<SceneRenderer> renderer;
};

/// An algorithm of the registry with its defaults.
inline Contender registered(const std::string& name)
{
    return {name, [name](const Hierarchy& hierarchy) { return make_culler(name, hierarchy); }};
}

/// Draws all leaves in the frustum except the one that holds `dropped`, which it reports hidden: an
/// error whenever that item is visible.
class DroppingCuller final : public Culler {
public:
    DroppingCuller(const Hierarchy& hierarchy, ItemId dropped)
        : Culler(hierarchy)
        , dropped_(dropped)
    {
    }

private:
    void cull_frame(CullFrame& frame) override { walk(frame, frame.hierarchy().root(), 0x3f); }
    void reset_state() override {}

    void walk(CullFrame& frame, NodeId node, PlaneMask mask)
    {
        if (!frame.visit(node, mask)) {
            return;
        }
        if (!frame.hierarchy().is_leaf(node)) {
            for (uint32_t i = 0; i < frame.hierarchy().node(node).child_count; ++i) {
                walk(frame, NodeId{frame.hierarchy().node(node).first_child.value + i}, mask);
            }
            return;
        }
        const std::span<const ItemId> items = frame.hierarchy().subtree_items(node);
        if (std::find(items.begin(), items.end(), dropped_) != items.end()) {
            frame.decide(node, Decision::hidden);
        } else {
            frame.draw_leaf(node, mask, Decision::drawn);
        }
    }

    ItemId dropped_;
};

inline Contender dropping(ItemId item)
{
    return {"dropping", [item](const Hierarchy& hierarchy) -> Result<std::unique_ptr<Culler>> {
                return std::unique_ptr<Culler>{new DroppingCuller{hierarchy, item}};
            }};
}

} // namespace occlude::tools::test
