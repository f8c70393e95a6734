#include "load/gltf_scene.h"

#include <fmt/format.h>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

#include <algorithm>
#include <cmath>

namespace occlude::tools {
namespace {

using nlohmann::json;

/// Skeletons, the deepest trees there are, have a few dozen levels.
constexpr uint32_t kDeepestNode = 1000;
/// A node has one parent, but where files do not keep to that, they are read as they are meant up
/// to this many nodes.
constexpr size_t kMostShared = size_t{1} << 20;

/// `count` numbers of a list, or nothing if there is no such list.
std::optional<std::vector<double>> numbers_of(const json& object, const char* key, size_t count)
{
    const auto found = object.find(key);
    if (found == object.end()) {
        return std::nullopt;
    }
    std::vector<double> numbers;
    for (size_t i = 0; found->is_array() && i < found->size(); ++i) {
        numbers.push_back((*found)[i].is_number() ? (*found)[i].get<double>() : NAN);
    }
    if (numbers.size() != count) {
        throw GltfError{
            fmt::format("the {} of a node does not have {} numbers; the file is broken, "
                        "export it again",
                        key, count)};
    }
    return numbers;
}

glm::dmat4 transform_of(const glm::dvec3& translation, const glm::dquat& rotation,
                        const glm::dvec3& scale)
{
    const glm::dmat4 turned =
        glm::translate(glm::dmat4{1.0}, translation) * glm::mat4_cast(rotation);
    return glm::scale(turned, scale);
}

glm::dquat unit_quaternion(double x, double y, double z, double w)
{
    const glm::dquat q{w, x, y, z};
    const double length = glm::length(q);
    return length > 0.0 ? q / length : glm::dquat{1.0, 0.0, 0.0, 0.0};
}

glm::dmat4 local_transform(const json& node)
{
    if (const auto matrix = numbers_of(node, "matrix", 16)) {
        glm::dmat4 out;
        for (int i = 0; i < 16; ++i) {
            out[i / 4][i % 4] = (*matrix)[static_cast<size_t>(i)];
        }
        return out;
    }
    const auto t = numbers_of(node, "translation", 3).value_or(std::vector<double>{0.0, 0.0, 0.0});
    const auto r =
        numbers_of(node, "rotation", 4).value_or(std::vector<double>{0.0, 0.0, 0.0, 1.0});
    const auto s = numbers_of(node, "scale", 3).value_or(std::vector<double>{1.0, 1.0, 1.0});
    return transform_of({t[0], t[1], t[2]}, unit_quaternion(r[0], r[1], r[2], r[3]),
                        {s[0], s[1], s[2]});
}

bool is_visible(const json& node)
{
    const json* visibility = extension_of(node, "KHR_node_visibility");
    return visibility == nullptr || visibility->value("visible", true);
}

/// The indices of a list of nodes; none if there is no list.
std::vector<uint32_t> node_list(const json& object, const char* key)
{
    std::vector<uint32_t> nodes;
    const auto list = object.find(key);
    if (list == object.end() || !list->is_array()) {
        return nodes;
    }
    for (const json& node : *list) {
        if (!node.is_number_unsigned() || node.get<uint64_t>() >= UINT32_MAX) {
            throw GltfError{fmt::format("{} is no index of a node; the file is broken, export it "
                                        "again",
                                        node.dump())};
        }
        nodes.push_back(node.get<uint32_t>());
    }
    return nodes;
}

/// The roots of the default scene; without scenes, all nodes that are no one's child.
std::vector<uint32_t> root_nodes(const GltfDocument& document)
{
    if (!document.list("scenes").empty()) {
        return node_list(document.entry("scenes", index_or(document.root(), "scene", 0)), "nodes");
    }
    const size_t count = document.list("nodes").size();
    std::vector<bool> is_child(count, false);
    for (size_t i = 0; i < count; ++i) {
        for (const uint32_t child : node_list(document.entry("nodes", i), "children")) {
            if (child < count) {
                is_child[child] = true;
            }
        }
    }
    std::vector<uint32_t> roots;
    for (uint32_t i = 0; i < count; ++i) {
        if (!is_child[i]) {
            roots.push_back(i);
        }
    }
    return roots;
}

/// True if a node is below one that is its own child, or its children's.
bool is_in_a_circle(const GltfDocument& document, uint32_t node)
{
    const size_t count = document.list("nodes").size();
    const auto for_each_child = [&](uint32_t parent, auto&& visit) {
        for (const uint32_t child : node_list(document.entry("nodes", parent), "children")) {
            if (child < count) {
                visit(child);
            }
        }
    };
    std::vector<uint32_t> parents(count, 0);
    for (uint32_t i = 0; i < count; ++i) {
        for_each_child(i, [&](uint32_t child) { ++parents[child]; });
    }
    std::vector<uint32_t> open; // nodes all of whose parents are known to be in no circle
    for (uint32_t i = 0; i < count; ++i) {
        if (parents[i] == 0) {
            open.push_back(i);
        }
    }
    while (!open.empty()) {
        const uint32_t at = open.back();
        open.pop_back();
        for_each_child(at, [&](uint32_t child) {
            if (--parents[child] == 0) {
                open.push_back(child);
            }
        });
    }
    return parents[node] > 0;
}

} // namespace

std::vector<PlacedNode> placed_nodes(const GltfDocument& document)
{
    struct Open {
        uint32_t node;
        uint32_t depth;
        glm::dmat4 world_from_parent;
    };
    std::vector<Open> open;
    size_t found = 0;
    const auto push = [&](const std::vector<uint32_t>& nodes, uint32_t depth,
                          const glm::dmat4& world) {
        found += nodes.size();
        for (size_t i = nodes.size(); i-- > 0;) {
            open.push_back({nodes[i], depth, world});
        }
    };
    push(root_nodes(document), 1, glm::dmat4{1.0});
    std::vector<PlacedNode> placed;
    while (!open.empty()) {
        const Open at = open.back();
        open.pop_back();
        if (at.depth > kDeepestNode) {
            throw GltfError{is_in_a_circle(document, at.node)
                                ? fmt::format("its nodes run in a circle above node {}; the file "
                                              "is broken, export it again",
                                              at.node)
                                : fmt::format("node {} lies more than {} nodes deep; export it "
                                              "again with fewer levels",
                                              at.node, kDeepestNode)};
        }
        if (found > std::max(kMostShared, document.list("nodes").size())) {
            throw GltfError{fmt::format("node {} is one of more than {} there are because nodes "
                                        "have several parents; export it again as a tree",
                                        at.node, kMostShared)};
        }
        const json& node = document.entry("nodes", at.node);
        if (!is_visible(node)) {
            continue;
        }
        const glm::dmat4 world = at.world_from_parent * local_transform(node);
        placed.push_back({at.node, world});
        push(node_list(node, "children"), at.depth + 1, world);
    }
    return placed;
}

std::vector<glm::dmat4> node_worlds(const GltfDocument& document)
{
    const size_t count = document.list("nodes").size();
    std::vector<uint32_t> parent(count, UINT32_MAX);
    for (uint32_t i = 0; i < count; ++i) {
        for (const uint32_t child : node_list(document.entry("nodes", i), "children")) {
            if (child < count && child != i) {
                parent[child] = i;
            }
        }
    }
    std::vector<glm::dmat4> worlds(count, glm::dmat4{1.0});
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t at = i;
        for (uint32_t depth = 0; at != UINT32_MAX && depth <= kDeepestNode; ++depth) {
            worlds[i] = local_transform(document.entry("nodes", at)) * worlds[i];
            at = parent[at];
        }
    }
    return worlds;
}

std::vector<glm::dmat4> instance_transforms(GltfAccessors& accessors, const json& node)
{
    const json* instancing = extension_of(node, "EXT_mesh_gpu_instancing");
    if (instancing == nullptr) {
        return {glm::dmat4{1.0}};
    }
    const auto attributes = instancing->find("attributes");
    if (attributes == instancing->end() || !attributes->is_object()) {
        throw GltfError{"EXT_mesh_gpu_instancing has no attributes; the file is broken, export it "
                        "again"};
    }
    const auto view_of = [&](const char* key, const char* type) {
        return attributes->contains(key) ? &accessors.open(index_of(*attributes, key), type)
                                         : nullptr;
    };
    const AccessorView* translation = view_of("TRANSLATION", "VEC3");
    const AccessorView* rotation = view_of("ROTATION", "VEC4");
    const AccessorView* scale = view_of("SCALE", "VEC3");
    size_t count = SIZE_MAX;
    for (const AccessorView* view : {translation, rotation, scale}) {
        count = view != nullptr ? std::min(count, view->count()) : count;
    }
    count = count == SIZE_MAX ? 0 : count;
    if (count > kMostShared * 16) {
        throw GltfError{fmt::format("EXT_mesh_gpu_instancing places {} instances in one node, more "
                                    "than this program reads",
                                    count)};
    }
    std::vector<glm::dmat4> transforms;
    transforms.reserve(count);
    for (size_t i = 0; i < count; ++i) {
        const glm::dvec3 t = translation != nullptr ? translation->vec3(i) : glm::vec3{0.0f};
        const glm::vec4 q = rotation != nullptr ? rotation->vec4(i) : glm::vec4{0, 0, 0, 1};
        const glm::dvec3 s = scale != nullptr ? scale->vec3(i) : glm::vec3{1.0f};
        transforms.push_back(transform_of(t, unit_quaternion(q.x, q.y, q.z, q.w), s));
    }
    return transforms;
}

std::vector<glm::dmat4> joint_matrices(const GltfDocument& document, GltfAccessors& accessors,
                                       size_t skin, const std::vector<glm::dmat4>& worlds)
{
    const json& description = document.entry("skins", skin);
    const AccessorView* inverse_bind =
        description.contains("inverseBindMatrices")
            ? &accessors.open(index_of(description, "inverseBindMatrices"), "MAT4")
            : nullptr;
    std::vector<glm::dmat4> joints;
    for (const uint32_t joint : node_list(description, "joints")) {
        if (joint >= worlds.size()) {
            throw GltfError{
                fmt::format("skin {} names node {} of {}; the file is broken, export it "
                            "again",
                            skin, joint, worlds.size())};
        }
        const bool bound = inverse_bind != nullptr && joints.size() < inverse_bind->count();
        joints.push_back(bound ? worlds[joint] * inverse_bind->mat4(joints.size()) : worlds[joint]);
    }
    return joints;
}

std::optional<LoadedCamera> camera_of(const GltfDocument& document, const json& node,
                                      const glm::dmat4& world_from_node)
{
    const size_t index = index_of(node, "camera");
    const json& description = document.entry("cameras", index);
    const auto perspective = description.find("perspective");
    if (perspective == description.end() || !perspective->is_object()) {
        return std::nullopt;
    }
    LoadedCamera camera;
    const std::string node_name = text_of(node, "name");
    const std::string own_name = text_of(description, "name");
    camera.name = !node_name.empty()  ? node_name
                  : !own_name.empty() ? own_name
                                      : fmt::format("{}", index);
    camera.eye = glm::dvec3{world_from_node[3]};
    const auto direction = [](const glm::dvec4& v) {
        const double length = glm::length(glm::dvec3{v});
        return length > 0.0 ? glm::dvec3{v} / length : glm::dvec3{0.0};
    };
    camera.forward = -direction(world_from_node[2]);
    camera.up = direction(world_from_node[1]);
    camera.fov_y = static_cast<float>(
        std::clamp(glm::degrees(number_or(*perspective, "yfov", 1.0471976)), 0.1, 179.0));
    camera.near = static_cast<float>(std::max(number_or(*perspective, "znear", 0.0), 0.0));
    camera.far = static_cast<float>(std::max(number_or(*perspective, "zfar", 0.0), 0.0));
    const bool usable = camera.forward != glm::dvec3{0.0} && camera.up != glm::dvec3{0.0};
    return usable ? std::optional{camera} : std::nullopt;
}

} // namespace occlude::tools
