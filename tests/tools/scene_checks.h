// Requirements of every generated scene: repeatable, sound, and passable along its paths.
#pragma once

#include "generate/scene_source.h"
#include "measure/stage.h"
#include "walk/paths.h"

#include <occlude/core/rng.h>

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vector_relational.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

namespace occlude::tools::test {

/// For stored hashes: they depend on how meshes are divided, and must stay the same with other
/// defaults.
inline const SceneOptions kHashedOptions{.item_triangles = 2048};

/// Loads a scene, and fails if it does not load.
inline SceneModel loaded(const std::string& source, const SceneOptions& options = {})
{
    auto model = load_scene(source, options);
    EXPECT_TRUE(model) << (model ? "" : model.error().message);
    return model ? std::move(*model) : SceneModel{};
}

inline uint64_t hash_of(const SceneModel& model)
{
    uint64_t hash = 0;
    const auto add = [&](float value) { hash = hash64(hash, std::bit_cast<uint32_t>(value)); };
    for (const Mesh& mesh : model.meshes) {
        for (const glm::vec3& p : mesh.positions) {
            add(p.x);
            add(p.y);
            add(p.z);
        }
        for (uint32_t index : mesh.indices) {
            hash = hash64(hash, index);
        }
    }
    for (const Instance& instance : model.instances) {
        hash = hash64(hash, instance.mesh);
        for (int column = 0; column < 4; ++column) {
            for (int row = 0; row < 3; ++row) {
                add(instance.world_from_mesh[column][row]);
            }
        }
        add(instance.color.x);
    }
    for (const SceneModel::NamedPath& path : model.paths) {
        for (const Keyframe& key : path.keys) {
            add(key.time);
            add(key.camera.eye.x);
            add(key.camera.target.z);
        }
    }
    return hash;
}

/// Finite positions, normals of length 1, parts that cover the indices, and no triangle that is
/// nearly a line or a point.
inline void expect_sound(const SceneModel& model)
{
    for (const Mesh& mesh : model.meshes) {
        ASSERT_EQ(mesh.positions.size(), mesh.normals.size()) << mesh.name;
        for (size_t i = 0; i < mesh.positions.size(); ++i) {
            ASSERT_TRUE(glm::dot(mesh.positions[i], mesh.positions[i]) < 1e8f) << mesh.name;
            ASSERT_NEAR(glm::length(mesh.normals[i]), 1.0f, 1e-3f) << mesh.name;
        }
        for (size_t i = 0; i < mesh.indices.size(); i += 3) {
            const glm::dvec3 a{mesh.positions[mesh.indices[i]]};
            const glm::dvec3 b{mesh.positions[mesh.indices[i + 1]]};
            const glm::dvec3 c{mesh.positions[mesh.indices[i + 2]]};
            const double longest =
                std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
            ASSERT_GT(glm::length(glm::cross(b - a, c - a)), 1e-5 * longest * longest)
                << mesh.name << ", triangle " << i / 3;
        }
        size_t covered = 0;
        for (const MeshPart& part : mesh.parts) {
            ASSERT_EQ(part.first_index, covered) << mesh.name;
            covered += part.index_count;
        }
        ASSERT_EQ(covered, mesh.indices.size()) << mesh.name;
    }
    for (const Instance& instance : model.instances) {
        ASSERT_LT(instance.mesh, model.meshes.size()) << instance.name;
        ASSERT_NE(glm::determinant(glm::dmat4{instance.world_from_mesh}), 0.0) << instance.name;
    }
}

/// Asks whether segments meet triangles of a scene.
class SegmentTester {
public:
    explicit SegmentTester(const SceneModel& model)
        : model_(model)
        , scene_(make_cull_scene(model))
    {
    }

    /// True if some triangle of the scene cuts the segment.
    bool hits(const glm::vec3& from, const glm::vec3& to) const
    {
        const Aabb way{glm::min(from, to), glm::max(from, to)};
        const std::span<const ItemBounds> bounds = scene_.scene.item_bounds();
        for (size_t i = 0; i < bounds.size(); ++i) {
            if (!glm::any(glm::greaterThan(bounds[i].box.min, way.max)) &&
                !glm::any(glm::lessThan(bounds[i].box.max, way.min)) &&
                item_hits(scene_.items[i], from, to)) {
                return true;
            }
        }
        return false;
    }

private:
    bool item_hits(const SceneModel::Item& item, const glm::vec3& from, const glm::vec3& to) const
    {
        const Instance& instance = model_.instances[item.instance];
        const Mesh& mesh = model_.meshes[instance.mesh];
        const MeshPart& part = mesh.parts[item.part];
        for (uint32_t i = part.first_index; i < part.first_index + part.index_count; i += 3) {
            const auto at = [&](uint32_t k) {
                return glm::vec3{instance.world_from_mesh *
                                 glm::vec4{mesh.positions[mesh.indices[i + k]], 1.0f}};
            };
            const glm::vec3 a = at(0);
            const glm::vec3 e1 = at(1) - a;
            const glm::vec3 e2 = at(2) - a;
            const glm::vec3 p = glm::cross(to - from, e2);
            const float det = glm::dot(e1, p);
            if (std::abs(det) < 1e-9f) {
                continue;
            }
            const glm::vec3 s = from - a;
            const float u = glm::dot(s, p) / det;
            const glm::vec3 q = glm::cross(s, e1);
            const float v = glm::dot(to - from, q) / det;
            const float t = glm::dot(e2, q) / det;
            if (u >= 0.0f && v >= 0.0f && u + v <= 1.0f && t >= 0.0f && t <= 1.0f) {
                return true;
            }
        }
        return false;
    }

    const SceneModel& model_;
    CullScene scene_;
};

/// The keys of a path that came with the scene.
inline std::vector<Keyframe> keys_of(const SceneModel& model, const std::string& name)
{
    for (const SceneModel::NamedPath& path : model.paths) {
        if (path.name == name) {
            return path.keys;
        }
    }
    ADD_FAILURE() << model.name << " has no path " << name;
    return {Keyframe{}};
}

/// Along the whole path, no triangle comes between two places of the eye or within `clearance` of
/// it. Within a sixtieth of the path, or half a metre if that is more frames, the camera neither
/// jumps nor turns by more than `most_degrees`.
inline void expect_free_and_smooth(const SceneModel& model, const std::string& path,
                                   float clearance, float most_degrees = 15.0f)
{
    const std::vector<Keyframe> keys = keys_of(model, path);
    float length = 0.0f;
    for (size_t i = 1; i < keys.size(); ++i) {
        length += glm::distance(keys[i - 1].camera.eye, keys[i].camera.eye);
    }
    const size_t frames = std::max(size_t{60}, static_cast<size_t>(2.0f * length));
    const float step = length / static_cast<float>(frames);
    const std::vector<Camera> cameras = interpolate(keys, frames);
    const SegmentTester tester(model);
    for (size_t i = 0; i < cameras.size(); ++i) {
        const glm::vec3& eye = cameras[i].eye;
        for (int axis = 0; axis < 3 && clearance > 0.0f; ++axis) {
            glm::vec3 reach{0.0f};
            reach[axis] = clearance;
            ASSERT_FALSE(tester.hits(eye - reach, eye + reach))
                << path << ", frame " << i << " of " << frames << ": something is near " << eye.x
                << " " << eye.y << " " << eye.z;
        }
        if (i == 0) {
            continue;
        }
        const glm::vec3& before = cameras[i - 1].eye;
        ASSERT_LT(glm::distance(before, eye), 4.0f * step + 1e-3f) << path << ", frame " << i;
        ASSERT_FALSE(clearance > 0.0f && tester.hits(before, eye)) << path << ", frame " << i;
        const glm::vec3 old_way = glm::normalize(cameras[i - 1].target - before);
        const glm::vec3 way = glm::normalize(cameras[i].target - eye);
        const float degrees = glm::degrees(std::acos(std::min(glm::dot(old_way, way), 1.0f)));
        ASSERT_LT(degrees, most_degrees) << path << ", frame " << i << " of " << frames;
    }
}

/// The share of the objects in the frustum that own no pixel, over some frames of a path, drawn on
/// the CPU.
inline double hidden_share(const SceneModel& model, const std::string& path, size_t frames,
                           glm::ivec2 size = {320, 180})
{
    auto cameras = load_path(path, model, frames);
    EXPECT_TRUE(cameras) << (cameras ? "" : cameras.error().message);
    if (!cameras) {
        return 0.0;
    }
    choose_depth_range(*cameras, model);
    const CullScene scene = make_cull_scene(model);
    auto renderer = std::move(*make_cpu_renderer(model, scene.items, size));
    size_t in_frustum = 0;
    size_t seen = 0;
    const auto objects_of = [&](std::span<const ItemId> items) {
        std::vector<uint32_t> objects;
        for (const ItemId item : items) {
            objects.push_back(scene.items[item.value].instance);
        }
        std::sort(objects.begin(), objects.end());
        objects.erase(std::unique(objects.begin(), objects.end()), objects.end());
        return objects.size();
    };
    for (const Camera& camera : *cameras) {
        const View view = make_view(camera, size);
        const std::vector<ItemId> items = items_in_frustum(view, scene.scene.item_bounds());
        in_frustum += objects_of(items);
        seen += objects_of(owners_of_pixels(renderer->render_ids(view, items)));
    }
    return in_frustum > 0 ? 1.0 - static_cast<double>(seen) / static_cast<double>(in_frustum) : 0.0;
}

} // namespace occlude::tools::test
